"""Photos whose points no smooth lens and flat page explain together."""

import numpy as np
from scipy.spatial import cKDTree

__all__ = ["left", "not_flat"]

_LEFT = 0.45           # pixels rms, for up to a width of 1280: what an uneven lens leaves is less
_WIDTH = 1280
_AROUND = 9            # points whose mean counts: noise of single points is another matter


def left(frame):
    """Pixels (n, 2) between the measured points of an :class:`IdealFrame`, with what was taken off
    as relief, and those of its smooth lens."""
    return frame.distorted + frame.relief - np.stack(frame.camera.back_map(*frame.corrected.T),
                                                     axis=1)


def not_flat(frame, width):
    """A sentence for each photo of an :class:`IdealFrame` of which too much is left.

    What is left of the points after the smooth lens and the pose of a flat page is averaged over
    nine points; its rms is compared with 0.45 pixels, in proportion for photos wider than
    1280.
    """
    rest = left(frame)
    limit, found = _LEFT * max(1.0, width / _WIDTH), []
    for number, name in enumerate(frame.names):
        on = frame.photo == number
        if on.sum() < 2 * _AROUND:
            continue
        near = cKDTree(frame.index[on]).query(frame.index[on], _AROUND)[1]
        far = np.linalg.norm(rest[on][near].mean(axis=1), axis=1)
        rms = float(np.sqrt(np.mean(far**2)))
        if rms > limit:
            x, y = frame.distorted[on][far.argmax()]
            found.append(f"{name}: points lie {rms:.2f} px rms, {far.max():.1f} px around "
                         f"({x:.0f}, {y:.0f}), from where a smooth lens has those of a flat "
                         f"target, {limit:.2f} px is the limit: the target may be bent or of two "
                         f"sheets, the shutter rolling, or the lens uneven there")
    return found
