"""Finds photos of which a part is out of focus: points there are displaced."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_model.calibration.neighbours import neighbours
from ncdc_model.calibration.sampling import bilinear
from ncdc_model.calibration.subpixel import edge_blur, gaps

__all__ = ["dot_blur", "part_out_of_focus", "with_focus"]

_SAMPLES = 33          # between a dot's centre and half of the distance to the next
_ENDS = 20, 90         # percentiles of the blur, of the sharp and of the blurred part
_BLURRED = 4.0         # pixels of a Gaussian: less moves no point by a pixel
_TIMES = 2.5           # ratio to the blur of the sharp part
_MIN_POINTS = 20            # with a known blur


def with_focus(grey, photo):
    """``photo``, PhotoPoints of ``grey`` (h, w), with a warning if a part of it is out of focus."""
    text = part_out_of_focus(grey, photo)
    return replace(photo, warnings=(*photo.warnings, text)) if text else photo


def part_out_of_focus(grey, photo):
    """One sentence if the edges of a part of ``photo``, PhotoPoints of ``grey`` (h, w), are far
    more blurred than those of the rest, else an empty one.

    A dot or corner at the boundary of the sharp part is sharp on one side only, which displaces
    it. The blur of each point is the median of its own and its neighbours'.
    """
    photo = photo.whole
    if len(photo.index) < _MIN_POINTS:
        return ""
    if photo.area.any():
        blur = dot_blur(grey, photo)
    else:
        blur = edge_blur(grey, photo.xy, gaps(photo.index, photo.xy))
    near = neighbours(photo.index)
    around = np.column_stack([np.where(near >= 0, blur[near], np.nan), blur])
    known = np.isfinite(around).sum(axis=1) >= 3
    if known.sum() < _MIN_POINTS:
        return ""
    blur, xy = np.nanmedian(around[known], axis=1), photo.xy[known]
    sharp, soft = np.percentile(blur, _ENDS)
    if soft < _BLURRED or soft < _TIMES * sharp:
        return ""
    beyond = blur > np.sqrt(sharp * soft)
    (x, y), (left, top), (right, bottom) = (part(xy[beyond], axis=0) for part in
                                            (np.mean, np.min, np.max))
    return (f"a part is out of focus: edges are blurred by {soft:.1f} px around ({x:.0f}, "
            f"{y:.0f}), x from {left:.0f} to {right:.0f}, y from {top:.0f} to {bottom:.0f}, and by "
            f"{sharp:.1f} px elsewhere; points where the focus ends may be off by over a pixel")


def dot_blur(grey, photo):
    """Blur (n,), a Gaussian's sigma in pixels, of the softest edge of each dot towards the dots
    next to it; not-a-number for a dot that has none."""
    number_of = {tuple(key): k for k, key in enumerate(photo.index.tolist())}
    pairs = np.array([(k, number_of[key]) for (i, j), k in number_of.items()
                      for key in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1),
                                  (i + 1, j + 1), (i - 1, j - 1), (i + 1, j - 1), (i - 1, j + 1))
                      if key in number_of]).reshape(-1, 2)
    blur = np.full(len(photo.index), np.nan)
    if not len(pairs):
        return blur
    first, second = photo.xy[pairs[:, 0]], photo.xy[pairs[:, 1]]
    part = np.linspace(0, 0.5, _SAMPLES)[:, None, None]
    at = first + part * (second - first)
    values = bilinear(cv2.GaussianBlur(grey, (0, 0), 0.7), at)
    pixels = np.linalg.norm(second - first, axis=1) * 0.5 / (_SAMPLES - 1)
    slope = np.abs(values[2:] - values[:-2]).max(axis=0) / (2 * pixels)
    soft = np.ptp(values, axis=0) / np.sqrt(2 * np.pi) / np.maximum(slope, 1e-6)
    np.fmax.at(blur, pairs[:, 0], soft)
    return blur
