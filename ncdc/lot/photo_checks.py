"""What a photo of a unit shows of its sensor and its focus: bad rows, and a soft half."""

import numpy as np

from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.focus import dot_blur
from ncdc_model.calibration.subpixel import edge_blur, gaps
from ncdc_model.images import is_raw

__all__ = ["bad_lines", "blur_ratio", "level_picture", "soft_half"]

_CONTRAST = 30.0        # grey levels, at least, of a picture that shows something
_BAND = 128             # rows in work at a time
_PARTS = 8              # of the width: a bad row is one in most of them
_MIN_PARTS = 6
_STEP, _LIKE = 0.25, 0.15   # of the contrast: a step, and what is none
_ODD = 0.15             # of the columns in which a row at a wrong position is a step off
_WEAK = 0.08            # of the contrast: a row that is off by it in half of the columns is dead
_NOISE = 6.0            # times the usual distance from the neighbours: no weaker row is seen
_SWAPPED = 0.73         # of the columns with steps, whose steps are smaller after an exchange
_COLUMNS = 20           # of them, at least
_HALVES = ("left", "right"), ("upper", "lower")
_POINTS = 20            # of a half, at least
_SHARP = 0.8            # pixels of a Gaussian: blur below it makes no difference
_SOFTER = 1.6           # ratio of the blur of opposite halves from which a half is out of focus


def level_picture(image):
    """Grey picture (h, w), float32; the four sites of a raw frame are made equally bright."""
    if not is_raw(image):
        return grey_picture(image).astype(np.float32)
    level = image.astype(np.float32)
    bright = float(np.median(level))
    for row, column in np.ndindex(2, 2):
        site = level[row::2, column::2]
        site *= bright / max(float(np.median(site)), 1.0)
    return level


def bad_lines(level):
    """Sentences on rows and columns of a :func:`level_picture` that the sensor did not read well.

    A dead row, or one from another position, is a step off both rows next to it, which are alike.
    Two exchanged rows have smaller steps to the rows around them in the other order. Both hold in
    most parts of the width, unlike a line that stands in front of the camera.
    """
    contrast = max(float(np.subtract(*np.percentile(level[::4, ::4], (95, 5)))),
                   _CONTRAST)
    found = []
    for name, picture in (("row", level), ("column", level.T)):
        odd, swapped = _bad_rows(picture, contrast)
        if odd.any():
            found.append(f"{_listed(name, odd)} unlike the {name}s next to it: dead, or read from "
                         f"another position")
        if swapped.any():
            found.append(f"{_listed(name, swapped)} exchanged with the next one")
    return found


def _listed(name, marked):
    numbers = np.flatnonzero(marked)
    more = f" and {len(numbers) - 5} more" if len(numbers) > 5 else ""
    plural, verb = ("", "is") if len(numbers) == 1 else ("s", "are")
    return f"the {name}{plural} {', '.join(map(str, numbers[:5]))}{more} {verb}"


def _bad_rows(picture, contrast):
    """Masks (h,) of the rows that are odd, and of those that are exchanged with the next one."""
    odd, swapped = np.zeros((2, len(picture)), bool)
    some = picture[1:-1:7]
    weak = max(_WEAK * contrast, _NOISE * float(np.median(
        np.abs(some - (picture[0:-2:7] + picture[2::7]) / 2))))
    for top in range(0, len(picture) - 3, _BAND):
        part = np.ascontiguousarray(picture[top:top + _BAND + 3])
        first, second, third, fourth = part[:-3], part[1:-2], part[2:-1], part[3:]
        off, step = np.abs(second - (first + third) / 2), np.abs(third - first)
        far = (off > _STEP * contrast) & (step < _LIKE * contrast)
        odd[top + 1:][:len(off)] = ((far.mean(axis=1) > _ODD) & _everywhere(far)
                                    | ((off - step / 2 > weak).mean(axis=1) > 0.5))
        here = (first - second)**2 + (third - fourth)**2
        other = (first - third)**2 + (second - fourth)**2
        steps = np.maximum(here, other) > (0.2 * contrast)**2
        count, better = steps.sum(axis=1), steps & (here > other)
        swapped[top + 1:][:len(off)] = ((count >= _COLUMNS) & _everywhere(better)
                                        & (better.sum(axis=1) > _SWAPPED * count))
    near = odd | np.roll(odd, 1) | np.roll(odd, -1) | np.roll(odd, -2)
    return odd, swapped & ~near


def _everywhere(marked):
    """Mask of the rows that are marked in most parts of the width."""
    return sum(part.any(axis=1) for part in np.array_split(marked, _PARTS, axis=1)) >= _MIN_PARTS


def soft_half(ratio, name, blur):
    """A sentence on a :func:`blur_ratio` of a picture with a half out of focus; else empty."""
    if not ratio > _SOFTER:
        return ""
    return (f"the {name} half is out of focus: edges are usually blurred by {blur:.1f} px, "
            f"{ratio:.1f} times as much as in the other half")


def blur_ratio(grey, photo):
    """Blur of the softest half of a picture over that of the half opposite, and its name.

    The blur of a half is the median of that of its points, a Gaussian's sigma in pixels.

    Parameters
    ----------
    grey : ndarray of uint8, shape (h, w)
    photo : PhotoPoints

    Returns
    -------
    (float, str, float)
        Ratio, name of the half, and its blur in pixels; not-a-number with too few points.
    """
    photo = photo.whole
    blur = (dot_blur(grey, photo) if photo.area.any()
            else edge_blur(grey, photo.xy, gaps(photo.index, photo.xy)))
    found = [(np.nan, "", np.nan)]
    for axis, names in enumerate(_HALVES):
        beyond = photo.xy[:, axis] > (grey.shape[1 - axis] - 1) / 2
        halves = [blur[np.isfinite(blur) & side] for side in (~beyond, beyond)]
        if min(map(len, halves)) >= _POINTS:
            each = [float(np.median(half)) for half in halves]
            softer = int(each[1] > each[0])
            found.append((max(each[softer], _SHARP) / max(each[1 - softer], _SHARP),
                          names[softer], each[softer]))
    return max(found[1:] or found)
