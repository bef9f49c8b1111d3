"""Finds Kalibr's AprilGrid: numbered tags with a black square at each of their corners."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_model.calibration.boards import examined, grey_picture
from ncdc_model.calibration.corners import cornerlike
from ncdc_model.calibration.outliers import without_outliers
from ncdc_model.calibration.points import PhotoPoints, april_places
from ncdc_model.calibration.predicted import completed, plain_pixels
from ncdc_model.calibration.sampling import bilinear
from ncdc_model.calibration.smooth import rough_lens
from ncdc_model.calibration.subpixel import by_edges, refine
from ncdc_model.calibration.tags import april_family, find_tags
from ncdc_spec.errors import InputError

__all__ = ["SPACINGS", "find_any_aprilgrid", "find_aprilgrid"]

SPACINGS = 0.05, 1.0   # limits of the gap between two tags, in sides of a tag
_CORNERS = 12
_DATA = 6              # cells of a tag's code in a row
_DIAGONAL = 0.7        # of the gap that is plain around a corner: the next one lies in a row
_SEED = 3.0            # pixels that a detected tag's corner may be off in any case
_BLUR = 1.0            # pixels, where a corner is looked for first
_FARTHER = 0, 0.04, 0.08, 0.12, 0.16, 0.2      # parts of the way from a tag's middle to its corner
_MOST = 0.8            # of the corners of detected tags: then no others are looked for outwards
_RING = 0.8            # of what is plain: radius at which a corner's surroundings are compared
_ROUNDS = 3            # of measuring the spacing
_STEP = 0.01           # of it: for the change of the corners
_MORE = 3              # rows that OpenCV may have missed, looked for if the size is not known
_DIGITS = 4            # of the measured spacing
_EXPLAINED = 3.0       # pixels, median residual of the lens
_SADDLES = 0.5         # of the detected tags' corners
_ALIKE = 0.6           # correlation of a tag's cells with its code: a covered one has less
_CELL = 1.5            # pixels of a cell: smaller ones are not compared
_FOREIGN = "a marker whose number does not fit its place"
_COVERED = "of a tag whose cells are not those of its number"
_WRONG = 0.25          # of the tags: with more whose cells are others the numbers are wrong
_DIFFER = 0.005        # of a side: the spacing that is seen may differ by as much from a stated one


def find_aprilgrid(image, columns, rows, spacing=None):
    """Corners of the tags of an AprilGrid of ``columns`` x ``rows`` tags, and the spacing.

    OpenCV finds tags, the numbers of neighbours say how they are arranged. Their corners are
    saddles of brightness, smoothed by no more than the squares and the tag's border allow. A lens
    that is fitted to them predicts the corners of the other tags. At the end the cells of every
    tag are sampled where the lens shows them, and compared with the code of its number.

    Parameters
    ----------
    image : ndarray of uint8
    columns, rows : int
        Tags.
    spacing : float, optional
        Gap between two tags in sides of a tag; measured in the picture by default.

    Returns
    -------
    PhotoPoints
        Two columns and two rows of corners per tag, counted from the upper left one.
    float
        The spacing, as stated or measured.

    Raises
    ------
    InputError
        If fewer than 12 corners are found, the tags are those of another board, or the spacing is
        not the stated one.
    """
    grey = grey_picture(image)
    tags = find_tags(grey)
    if tags is None:
        raise InputError(f"no AprilGrid of {columns}x{rows} tags was found")
    _check_size(tags, columns, rows)
    border = tags.border / (_DATA + 2 * tags.border)
    index, xy = _seeds(grey, tags, (columns, rows), border)
    size, every = grey.shape[::-1], _all_corners(columns, rows)
    seen = _measured_spacing(size, index, xy)
    plain = min(border, _DIAGONAL * seen)
    index, xy = completed(grey, (index, xy), every, lambda key: april_places(key, seen), plain)
    spacing = _agreed_spacing(spacing, _measured_spacing(size, index, xy))

    def places(key):
        return april_places(key, spacing)
    photo = _photo(image, index, xy, places, tags.foreign)
    photo = _by_code(grey, photo, tags, (columns, rows), places)
    if len(photo.index) < _CORNERS:
        raise InputError(f"{len(photo.index)} corners of an AprilGrid of {columns}x{rows} tags "
                         f"were found, at least {_CORNERS} are needed")
    return examined(image, grey, photo), spacing


def _check_size(tags, columns, rows):
    if tags.columns not in (None, columns):
        raise InputError(f"it shows an AprilGrid of {tags.columns} columns of tags, not of "
                         f"{columns}")
    if tags.ids.max() >= columns * rows:
        raise InputError(f"it shows tags up to number {int(tags.ids.max())}, an AprilGrid of "
                         f"{columns}x{rows} has {columns * rows} from 0")


def _agreed_spacing(stated, seen):
    """The stated spacing, if it is what is seen, or else that."""
    if stated is not None and abs(seen - stated) > _DIFFER:
        raise InputError(f"the gap between its tags is {seen:.4f} of a tag's side, {stated:g} is "
                         f"stated: more than {_DIFFER:g} apart")
    return stated or round(seen, _DIGITS)


def _seeds(grey, tags, size, border):
    """Index (n, 2) and pixels (n, 2) of the corners of the detected tags."""
    columns, rows = size
    row, column = np.divmod(tags.ids, columns)
    first = 2 * np.stack([column, rows - 1 - row if tags.upwards else row], axis=1)
    index = (first[:, None] + ((0, 0), (1, 0), (1, 1), (0, 1))).reshape(-1, 2)
    xy = tags.corners.reshape(-1, 2).copy()
    side = np.linalg.norm(tags.corners - np.roll(tags.corners, 1, axis=1), axis=2).min(axis=1)
    plain = np.repeat(side, 4) * min(border, _DIAGONAL * _spacing_near(index, xy))
    smooth, middle = cv2.GaussianBlur(grey, (0, 0), _BLUR), tags.corners.mean(axis=1)
    away = xy - np.repeat(middle, 4, axis=0)
    found = np.zeros(len(xy), bool)
    # OpenCV cuts tags off where they touch the squares, at times all around: go on outwards.
    for farther in _FARTHER:
        left = np.flatnonzero(~found)
        near = by_edges(smooth, xy[left] + farther * away[left], plain[left])
        moved = refine(grey, index[left], near, np.clip(plain[left], _SEED, None).max(),
                       plain[left])
        good = np.linalg.norm(moved - near, axis=1) < np.maximum(plain[left], _SEED)
        good &= cornerlike(smooth, moved, _RING * plain[left])
        xy[left[good]], found[left[good]] = moved[good], True
        if found.sum() >= _MOST * len(found):
            break
    if found.sum() < _SADDLES * len(found):
        raise InputError("most corners of its tags have no black square, as those of an AprilGrid "
                         "have")
    return index[found], xy[found]


def _spacing_near(index, xy):
    """Spacing from the cross ratios of the four corners that two neighbouring tags have in a line;
    it is exact without distortion."""
    number_of = {tuple(key): k for k, key in enumerate(index.tolist())}
    ratios = []
    for i, j in number_of:
        for step in ((1, 0), (0, 1)):
            line = [number_of.get((i + n * step[0], j + n * step[1])) for n in range(4)]
            if (i, j)[step.index(1)] % 2 == 0 and None not in line:
                far = [np.linalg.norm(xy[line[a]] - xy[line[b]])
                       for a, b in ((2, 0), (3, 1), (2, 1), (3, 0))]
                ratios.append(far[0] * far[1] / max(far[2] * far[3], 1e-9))
    if not ratios:
        raise InputError("no two tags of its AprilGrid next to each other were found")
    ratio = max(float(np.median(ratios)), 1 + 1e-6)
    return float(np.clip(np.sqrt(ratio / (ratio - 1)) - 1, *SPACINGS))


def _measured_spacing(size, index, xy):
    """Spacing for which a lens explains the corners best."""
    spacing = _spacing_near(index, xy)
    for _ in range(_ROUNDS):
        places = april_places(index, spacing)
        fit = rough_lens(size, places, xy, _EXPLAINED)
        if fit is None:
            raise InputError("no smooth lens explains the corners of its tags: that is no flat "
                             "AprilGrid")
        # The pose and the lens absorb what is smooth of the change: a zigzag remains.
        terms = np.column_stack([places, places**2, places[:, :1] * places[:, 1:],
                                 np.ones(len(places))])
        change = index // 2
        change = change - terms @ np.linalg.lstsq(terms, change, rcond=1e-9)[0]
        moved = (fit.pixels(0, places + _STEP * change) - fit.pixels(0, places)) / _STEP
        rest = xy - fit.pixels(0, places)
        good = np.linalg.norm(rest, axis=1) < _EXPLAINED * max(
            1, 2 * np.median(np.linalg.norm(rest, axis=1)))
        spacing += float((rest * moved)[good].sum() / (moved * moved)[good].sum())
        spacing = float(np.clip(spacing, *SPACINGS))
    return spacing


def _all_corners(columns, rows):
    i, j = np.meshgrid(np.arange(2 * columns), np.arange(2 * rows))
    return np.stack([i.ravel(), j.ravel()], axis=1)


def _photo(image, index, xy, places, foreign):
    """PhotoPoints without outliers."""
    order = np.lexsort(index.T)
    photo = PhotoPoints(index=index[order], xy=xy[order], area=np.zeros(len(xy)),
                        rejected={_FOREIGN: foreign} if foreign else {})
    return without_outliers(image.shape[1::-1], photo, places(photo.index))


def _by_code(grey, photo, tags, size, places):
    """``photo`` without the corners of tags whose cells are not those of their number.

    Raises :class:`InputError` if too many are not: then the numbers are wrong.
    """
    fit = rough_lens(grey.shape[::-1], places(photo.index), photo.xy, _EXPLAINED)
    if fit is None:
        raise InputError("no smooth lens explains the corners of its tags")
    columns, rows = size
    cells = _DATA + 2 * tags.border
    at = (np.arange(_DATA) + tags.border + 0.5) / cells
    inner = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    wrong, count, judged = np.zeros(len(photo.index), bool), 0, 0
    for number in range(columns * rows):
        row, column = divmod(number, columns)
        first = np.array([2 * column, 2 * (rows - 1 - row if tags.upwards else row)])
        on = ((photo.index >= first) & (photo.index <= first + 1)).all(axis=1)
        spots = fit.pixels(0, places(first[None]) + inner)
        inside = ((spots > 1) & (spots < np.array(grey.shape[::-1]) - 2)).all()
        if not on.any() or not inside or plain_pixels(
                fit, places(first[None]) + 0.5, 1 / cells)[0] < _CELL:
            continue
        judged += 1
        code = cv2.aruco.generateImageMarker(april_family(), number, cells,
                                             borderBits=tags.border)
        code = np.rot90(code, tags.turn)[tags.border:-tags.border, tags.border:-tags.border]
        if not np.corrcoef(bilinear(grey, spots), code.ravel())[0, 1] > _ALIKE:
            wrong |= on
            count += 1
    if count > _WRONG * judged:
        raise InputError(f"{count} of {judged} tags have other cells than those of their numbers: "
                         f"it is no AprilGrid of {columns}x{rows}")
    keep = ~wrong
    return replace(
        photo, index=photo.index[keep], xy=photo.xy[keep], area=photo.area[keep],
        cut=photo.cut[keep],
        rejected={**photo.rejected, **({_COVERED: int(wrong.sum())} if wrong.any() else {})},
        dropped=photo.dropped + tuple((float(x), float(y), _COVERED) for x, y in photo.xy[wrong]))


def find_any_aprilgrid(image):
    """Columns and rows of tags of a board whose size is not known: the rows are those up to the
    highest number that is seen, whether OpenCV finds that tag or the lens leads to it.

    Raises
    ------
    InputError
        If the picture shows no board.
    """
    tags = find_tags(grey_picture(image))
    if tags is None or tags.columns is None:
        raise InputError("no AprilGrid was found")
    columns, rows = tags.columns, int(tags.ids.max()) // tags.columns + 1 + _MORE
    photo, _ = find_aprilgrid(image, columns, rows)
    row = photo.index[:, 1] // 2
    return columns, rows - int(row.min()) if tags.upwards else int(row.max()) + 1
