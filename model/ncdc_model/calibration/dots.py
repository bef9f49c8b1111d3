"""Finds and numbers the dots of a page of black dots on white."""

import numpy as np
from scipy.spatial import cKDTree

from ncdc_model.calibration.blobs import find_blobs
from ncdc_model.calibration.lattice import number_lattice
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.rim import recover_cut_dots
from ncdc_model.errors import InputError

__all__ = ["find_dots"]

_ENOUGH = 25           # numbered dots below which a photo does not show a page of dots


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
        If fewer than 25 dots form one lattice.
    """
    blobs = find_blobs(image)
    height, width = image.shape[:2]
    where, index, dropped = number_lattice(blobs.xy, ((width - 1) / 2, (height - 1) / 2))
    if len(where) < _ENOUGH:
        raise InputError(f"{len(where)} dots on one lattice were found, at least {_ENOUGH} are "
                         f"needed")
    xy, area = blobs.xy[where], blobs.area[where]
    cut_xy, cut_index, cut_area = recover_cut_dots(image, xy, index, area)
    rejected = dict(blobs.rejected)
    for reason, count in (("out of line with its neighbours", dropped),
                          ("not on the lattice", len(blobs.xy) - len(where) - dropped),
                          ("cut by the border", _without(blobs.cut, cut_xy, area))):
        if count:
            rejected[reason] = count
    index = np.vstack([index, cut_index])
    return PhotoPoints(index=index - index.min(axis=0), xy=np.vstack([xy, cut_xy]),
                       area=np.concatenate([area, cut_area]), rejected=rejected,
                       cut=np.arange(len(index)) >= len(xy))


def _without(cut, recovered, area):
    """How many of the blobs ``cut`` by the border are not one of the ``recovered`` dots."""
    if not len(cut) or not len(recovered):
        return len(cut)
    distance, _ = cKDTree(recovered).query(cut)
    return int((distance > np.sqrt(np.percentile(area, 90))).sum())
