"""Finds and numbers the dots of a page of black dots on white."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.calibration.background import contrast, on_one_background
from ncdc_model.calibration.blobs import Blobs, find_blobs
from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.border_dots import recover_cut_dots
from ncdc_model.calibration.focus import with_focus
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.calibration.neighbours import OutlierReason, fits_in
from ncdc_model.calibration.outliers import location_text, split_at_kinks, without_outliers
from ncdc_model.calibration.patch_consistency import consistent_patches
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.spot_shape import are_square
from ncdc_model.nearest import Nearest
from ncdc_spec.errors import InputError

__all__ = ["Spots", "dots_of", "find_dots", "find_spots"]

_JOINED = 0.90         # of a lattice's points must be good, else it may be two that join
_ALIKE = 1.7           # largest ratio of the sizes of a dot at the edge and its only neighbour
_ENOUGH = 25           # numbered dots: a page of dots has as many or more
_NEXT = 3.5            # steps between two lattices of one page, at most
_INVERTED = 12         # bright spots on one lattice that form a target


@dataclass(frozen=True)
class Spots:
    """Round spots of a photo and their lattices.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photo.
    blobs : Blobs
    lattices : tuple of PhotoPoints
        Those without outliers, the one with most points first; steps may be oblique.
    doubt : str
        Why a lattice was rejected, if one was.
    inverted : bool
        Whether the spots are bright on a dark background, found in the negative.
    square : bool
        Whether those of the first lattice are squares: of a chessboard or a board of markers.
    """
    size: tuple
    blobs: Blobs
    lattices: tuple
    doubt: str = ""
    inverted: bool = False
    square: bool = False

    def check_round(self):
        """Raise :class:`InputError` if the spots are squares."""
        if self.square:
            raise InputError(f"its {len(self.lattices[0].index)} dark spots on one lattice are "
                             f"squares, not round: --target chessboard:CxR finds a chessboard, "
                             f"charuco:CxR or aprilgrid:CxR a board of markers")

    def dark(self, image):
        """The ``image``, or its negative, so that the spots are dark."""
        return 255 - image if self.inverted else image


def find_spots(image):
    """:class:`Spots` of the uint8 ``image``, (h, w) raw or grey, or (h, w, 3) RGB.

    They are dark on bright, or bright on dark if the dark ones hardly form a lattice.
    """
    found = _spots(image)
    if _count(found) < _ENOUGH:
        bright = _spots(255 - image)
        if _count(bright) >= max(_INVERTED, 2 * _count(found)):
            found = replace(bright, inverted=True, lattices=tuple(
                replace(photo, remarks=(*photo.remarks, "its dots are bright on a dark background"))
                for photo in bright.lattices))
    grey = grey_picture(found.dark(image))
    square = bool(found.lattices) and are_square(grey, found.lattices[0])
    return replace(found, square=square,
                   lattices=tuple(with_focus(grey, photo) for photo in found.lattices))


def _count(spots):
    return len(spots.lattices[0].index) if spots.lattices else 0


def _spots(image):
    blobs, size, doubt = find_blobs(image), image.shape[1::-1], ""
    lattices = []
    for lattice in find_lattices(blobs.xy, (np.array(size) - 1) / 2):
        walked = consistent_patches(image, on_one_background(image, _of_lattice(blobs, lattice)))
        walked = replace(walked, contrast=contrast(image, walked))
        try:
            whole = without_outliers(size, walked)
            if len(whole.index) > _JOINED * len(walked.index):
                lattices.append(whole)
                continue
        except InputError as error:
            doubt = doubt or str(error)
        for part in split_at_kinks(walked):
            try:
                lattices.append(without_outliers(size, part))
            except InputError as error:
                doubt = doubt or str(error)
    lattices = [photo for photo in lattices if len(photo.index) >= 9]
    return Spots(size, blobs, tuple(sorted(lattices, key=lambda photo: -len(photo.index))), doubt)


def _of_lattice(blobs, lattice):
    dropped = tuple((float(x), float(y), "out of line with its neighbours")
                    for x, y in blobs.xy[lattice.dropped])
    rejected = {**blobs.rejected, **({dropped[0][2]: len(dropped)} if dropped else {})}
    other = len(blobs.xy) - len(lattice.where) - len(lattice.dropped)
    if other:
        rejected["not on the lattice"] = other
    return PhotoPoints(index=lattice.index, xy=blobs.xy[lattice.where],
                       area=blobs.area[lattice.where], rejected=rejected, dropped=dropped)


def find_dots(image):
    """Dots of a page in the uint8 ``image``, (h, w) raw or grey, or (h, w, 3) RGB.

    Returns
    -------
    PhotoPoints
        Indices from 0; centres and areas of the dots, whole ones first, then those that the
        border cuts; rejected blobs by reason.

    Raises
    ------
    InputError
        If fewer than 25 dots form one lattice, its points scatter, or they are squares.
    """
    return dots_of(find_spots(image), image)


def dots_of(spots, image):
    """:func:`find_dots` from the :class:`Spots` of the same ``image``."""
    spots.check_round()
    count, image = _count(spots), spots.dark(image)
    if count < _ENOUGH:
        raise InputError(spots.doubt or f"{count} dots on one lattice were found, at least "
                                        f"{_ENOUGH} are needed")
    page = _supported(spots.lattices[0])
    cut_xy, cut_index, cut_area = _predicted_cut(page, *recover_cut_dots(
        image, page.xy, page.index, page.area))
    rejected = dict(page.rejected)
    cut = _without(spots.blobs.cut, cut_xy, page.area)
    if cut:
        rejected["cut by the border"] = cut
    index = np.vstack([page.index, cut_index])
    others = [other for other in spots.lattices[1:] if len(other.index) >= _ENOUGH]
    joined = tuple(
        f"{len(other.index)} dots {location_text(other)}, right next to those that are used, do "
        f"not continue their lines and are not used: the page may be of two sheets, folded, or "
        f"another"
        for other in others if _join(page, other))
    return replace(
        page, index=index - index.min(axis=0), xy=np.vstack([page.xy, cut_xy]),
        area=np.concatenate([page.area, cut_area]), rejected=rejected,
        cut=np.arange(len(index)) >= len(page.xy), warnings=page.warnings + joined,
        remarks=page.remarks + tuple(
            f"another page, {len(other.index)} dots {location_text(other)}, is not used"
            for other in others if not _join(page, other)))


def _join(page, other):
    """Whether two lattices of dots lie no farther apart than their own dots do."""
    tree = Nearest(page.xy)
    step = np.median(tree.query(page.xy, 2)[0][:, 1])
    return bool((tree.query(other.xy)[0][:, 0] < _NEXT * step).sum() >= 3)


def _supported(page):
    """``page`` without dots whose only neighbour has another size: they may be specks."""
    there = {tuple(key): area for key, area in zip(page.index.tolist(), page.area)}
    keep = np.ones(len(page.index), bool)
    for k, (i, j) in enumerate(page.index.tolist()):
        adjacent = [there[key] for key in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))
                  if key in there]
        keep[k] = len(adjacent) > 1 or (
            len(adjacent) == 1 and _ALIKE > page.area[k] / adjacent[0] > 1 / _ALIKE)
    reason = OutlierReason.LONELY.value
    dropped = tuple((float(x), float(y), reason) for x, y in page.xy[~keep])
    rejected = {**page.rejected}
    if dropped:
        rejected[reason] = rejected.get(reason, 0) + len(dropped)
    return replace(page, index=page.index[keep], xy=page.xy[keep], area=page.area[keep],
                   cut=page.cut[keep], rejected=rejected, dropped=page.dropped + dropped)


def _predicted_cut(page, xy, index, area):
    """Those of the dots cut by the border that the whole ones of ``page`` predict."""
    if not len(xy):
        return xy, index, area
    good = fits_in(page.index, page.xy, index, xy, page.agreement)
    return xy[good], index[good], area[good]


def _without(cut, recovered, area):
    """How many of the blobs ``cut`` by the border are not one of the ``recovered`` dots."""
    if not len(cut) or not len(recovered):
        return len(cut)
    distance, _ = Nearest(recovered).query(cut)
    return int((distance[:, 0] > np.sqrt(np.percentile(area, 90))).sum())
