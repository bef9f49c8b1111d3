"""Whether the photos of a unit agree with one lens."""

import numpy as np

__all__ = ["disagreement", "mixed"]

_COMMON, _OWN = 6, 4        # degrees of the polynomials
_TIMES = 2.0                # the noise of a point: photos that disagree by more are not of one lens
_MIN = 0.03, 1 / 20000    # pixels, and parts of the width: less is no matter


def mixed(frame):
    """The :func:`disagreement` of a frame, and a sentence if it is that of several lenses."""
    off, noise = disagreement(frame)
    if not off > max(_TIMES * noise, _MIN[0], _MIN[1] * frame.camera.size[0]):
        return off, ""
    return off, (f"the photos disagree on the lens by {off:.2f} px rms, the noise of their points "
                 f"is {noise:.2f} px: they are not all of this unit, or the page bent or moved")


def disagreement(frame):
    """Root mean square, in pixels, of what is smooth in the points' distance from the common lens
    and differs from photo to photo.

    Points of one lens and a flat page differ from the fitted lens by noise, and by what the model
    of the lens lacks, which is the same on every photo. A polynomial over the picture is fitted to
    this common part, and one of each photo to the rest. What the latter take from noise is
    subtracted.

    Parameters
    ----------
    frame : ncdc_model.calibration.frame.IdealFrame

    Returns
    -------
    (float, float)
        The disagreement, and the noise on an axis. For a single photo, or too few points, 0 and
        not-a-number.
    """
    rest = np.stack(frame.camera.back_map(*frame.corrected.T), axis=1) - frame.distorted
    at = 2 * frame.distorted / (np.array(frame.camera.size) - 1) - 1
    photos, common, own = np.unique(frame.photo), _terms(at, _COMMON), _terms(at, _OWN)
    if len(photos) < 2 or len(rest) < 2 * (common.shape[1] + len(photos) * own.shape[1]):
        return 0.0, np.nan
    each = [own * (frame.photo == k)[:, None] for k in photos[1:]]
    (alike, _), (left, degrees) = _left(common, rest), _left(np.hstack([common, *each]), rest)
    noise = left / (2 * degrees)            # variance on an axis
    extra = 2 * (len(photos) - 1) * own.shape[1]
    return float(np.sqrt(max(alike - left - extra * noise, 0) / len(rest))), float(np.sqrt(noise))


def _terms(at, degree):
    """Products of Legendre polynomials (n, terms) up to a ``degree`` in x and y together."""
    x, y = (np.polynomial.legendre.legvander(part, degree) for part in at.T)
    return np.stack([x[:, i] * y[:, j] for i in range(degree + 1) for j in range(degree + 1 - i)],
                    axis=1)


def _left(design, rest):
    """Sum of squares that the best combination of columns leaves, and degrees of freedom."""
    found = design @ np.linalg.lstsq(design, rest, rcond=None)[0]
    return float(((rest - found)**2).sum()), len(rest) - design.shape[1]
