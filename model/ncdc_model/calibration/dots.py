"""Finds and numbers the dots of a page of black dots on white."""

from ncdc_model.calibration.blobs import find_blobs
from ncdc_model.calibration.lattice import number_lattice
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.errors import InputError

__all__ = ["find_dots"]

_ENOUGH = 25           # numbered dots below which a photo does not show a page of dots


def find_dots(image):
    """Dots of a page in the uint8 ``image``, (h, w) raw or grey, or (h, w, 3) RGB.

    Returns
    -------
    PhotoPoints
        Indices from 0; centres and areas of the dots; rejected blobs by reason.

    Raises
    ------
    InputError
        If fewer than 25 dots form one lattice.
    """
    blobs = find_blobs(image)
    height, width = image.shape[:2]
    where, index, dropped = number_lattice(blobs.xy, ((width - 1) / 2, (height - 1) / 2))
    rejected = dict(blobs.rejected)
    for reason, count in (("out of line with its neighbours", dropped),
                          ("not on the lattice", len(blobs.xy) - len(where) - dropped)):
        if count:
            rejected[reason] = count
    if len(where) < _ENOUGH:
        raise InputError(f"{len(where)} dots on one lattice were found, at least {_ENOUGH} are "
                         f"needed")
    return PhotoPoints(index=index, xy=blobs.xy[where], area=blobs.area[where], rejected=rejected)
