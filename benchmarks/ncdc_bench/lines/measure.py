"""The paper's line test: a board seen by a lens and corrected; which of its lines are still lines.

Fig. 34 to 39 of the paper, with a simulated lens, so that every line of the board is valid.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.example.render import expose, ideal_samples, sensor
from ncdc_model.golden.picture import bilinear, corner_colours, raw_windows, window_address
from ncdc_model.lens.inverse import planar_inverse
from ncdc_spec.formats import Formats

__all__ = ["Line", "board_photo", "board_pitch", "corrected", "crossings", "find_lines",
           "summary"]

SQUARES = 20           # of the board across the corrected frame
DARK, LIGHT = 30, 215
EDGES = 60, 140        # lower and upper threshold of the edge detector (Canny)
TURN, WIDE = np.pi / 3600, 2    # resolution of the Hough transform: angle, pixels
STRAY = np.radians(3)  # maximum turn of a line found
SHARE = 0.75           # of its visible length that a line found must collect in edge pixels

_ROWS = 5              # rows whose mean is one point of an edge
_REACH = 4             # pixels on either side of an edge that its point is computed from
_CORNER = 8            # pixels around the corner of a square without edge points
_FULL = 0.8            # of the board's contrast that an edge must rise by
_RIM = 4               # pixels next to those without a source, which are not used


@dataclass(frozen=True)
class Line:
    """One line of the board in a corrected picture.

    Parameters
    ----------
    upright : bool
        A column, else a row.
    votes : int
        Maximum number of edge pixels on one straight line of the Hough transform.
    votes_needed : int
    ends : ndarray, shape (2, 2)
        (u, v) of both ends of the straight line fitted to the edge's points.
    deviations : ndarray
        Distances in pixels of the edge's points from it.
    """
    upright: bool
    votes: int
    votes_needed: int
    ends: np.ndarray
    deviations: np.ndarray

    @property
    def missed(self):
        """Whether the Hough transform does not find it."""
        return self.votes < self.votes_needed


def board_pitch(geometry):
    """Pixels of the corrected frame between neighbouring lines of the board."""
    return geometry.corrected_width / SQUARES


def board_photo(lens, seed=1):
    """Raw photo of a chessboard that fills the corrected frame of ``lens``, a ReferenceLens.

    The lines are at half the pitch from the frame's border and then every pitch.
    """
    pitch = board_pitch(lens.geometry)
    u, v = lens.camera.frame.pixel(*ideal_samples(lens.camera))
    sign = 1.0
    for axis in (u, v):
        # Distance to the nearest line, alternating in sign, over its change per subsample: an
        # edge is one subsample wide.
        distance = pitch * (np.abs(np.mod(axis / pitch, 2) - 1) - .5)
        slope = np.hypot(*np.gradient(axis))
        sign = sign * np.clip(2 * distance / slope, -1, 1)
    light = expose(DARK + (LIGHT - DARK) * (1 + sign) / 2)
    return sensor(np.repeat(light[:, :, None], 3, axis=2), lens.geometry.bayer, seed)


def corrected(back_map, raw, geometry):
    """The picture (height, width, 3) of the back end from ``raw`` at ``back_map``'s coordinates.

    The arithmetic of the hardware for any map, its coordinates rounded as the network's are.
    Returns the picture and where it has a source, (height, width).
    """
    coordinate = Formats().coordinate
    width, height = geometry.corrected
    windows = raw_windows(raw, geometry.interpolation)
    picture, valid = np.zeros((height, width, 3), np.uint8), np.zeros((height, width), bool)
    for top in range(0, height, 32):
        rows = slice(top, min(top + 32, height))
        v, u = np.mgrid[rows, 0:width].astype(np.float64)
        x, y = (np.nan_to_num(axis, nan=-9) for axis in back_map(u, v))
        limit = coordinate.real(coordinate.hi)
        x0, y0, fx, fy, inside = window_address(
            *(coordinate.quantise(np.clip(axis, -limit, limit)) for axis in (x, y)),
            geometry, coordinate)
        samples = corner_colours(windows[y0, x0], x0, y0, geometry)
        colours = bilinear(samples, fx, fy, coordinate.f_bits, geometry.interpolation)
        picture[rows] = np.where(inside[..., None], colours, 0)
        valid[rows] = inside
    return picture, valid


def crossings(lens, back_map):
    """The board's crossings in the picture corrected by ``back_map``, in real numbers.

    Returns (u, v), each of shape (rows, columns), not-a-number where there is none.
    """
    width, height = lens.geometry.corrected
    pitch = board_pitch(lens.geometry)
    u, v = np.meshgrid(np.arange(pitch / 2, width, pitch), np.arange(pitch / 2, height, pitch))
    x, y = lens.camera.back_map(u, v)
    # planar_inverse starts at its target: shift so that this is the true point.
    a, b = planar_inverse(lambda a, b: back_map(u + a - x, v + b - y), x, y, scale=width / 2)
    return u + a - x, v + b - y


def find_lines(picture, valid, pitch, crossing):
    """Every :class:`Line` of the board that is visible for two squares or more.

    Parameters
    ----------
    picture, valid : ndarray
        Results of :func:`corrected`.
    pitch : float
        Pixels between lines.
    crossing : (ndarray, ndarray)
        Result of :func:`crossings`: each line is looked for within a quarter of the pitch from the
        straight line through its crossings.
    """
    grey = picture.astype(np.float64).mean(2)
    inner = cv2.erode(valid.astype(np.uint8), np.ones((2 * _RIM + 1,) * 2)).astype(bool)
    # Outside of the picture there is no source either.
    inner[:_RIM] = inner[-_RIM:] = inner[:, :_RIM] = inner[:, -_RIM:] = False
    edges = cv2.Canny(np.round(grey).astype(np.uint8), *EDGES) * inner.astype(np.uint8)
    u, v = crossing
    lines = [_line(grey, edges, inner, pitch, along, across)
             for along, across in zip(v.T, u.T)]
    lines += [_line(grey.T, edges.T, inner.T, pitch, along, across, False)
              for along, across in zip(u, v)]
    return [line for line in lines if line]


def _line(grey, edges, inner, pitch, along, across, upright=True):
    """The line along the first axis through the crossings at rows ``along``; None if invisible."""
    height, width = grey.shape
    seen = np.isfinite(along) & np.isfinite(across)
    seen[seen] = inner[np.clip(along[seen], 0, height - 1).astype(int),
                       np.clip(across[seen], 0, width - 1).astype(int)]
    if seen.sum() < 2:
        return None
    slope, start = np.polyfit(along[seen], across[seen], 1)
    rows = np.arange(height)
    path = start + slope * rows
    visible = inner[rows, np.clip(path, 0, width - 1).astype(int)] & (path > 0) & (path < width - 1)
    rows, path = rows[visible], path[visible]
    if not len(rows) or rows[-1] - rows[0] < 2 * pitch:
        return None
    near = np.abs(np.arange(width) - (start + slope * np.arange(height))[:, None]) < pitch / 4
    votes = _votes(edges * near, np.arctan(slope))
    corner = np.abs(rows[:, None] - along[seen]).min(axis=1) < _CORNER
    rows, columns = _edge_points(grey, inner, rows, path, int(pitch / 4), ~corner)
    if len(rows) < 3:
        return None
    middle, direction, deviations = _straight(rows, columns)
    reach = (np.flatnonzero(visible)[[0, -1]] - middle[0]) / direction[0]
    ends = middle + reach[:, None] * direction
    return Line(upright, votes, int(np.ceil(SHARE * visible.sum())),
                ends[:, ::-1] if upright else ends, deviations)


def _votes(edges, lean):
    """Maximum number of pixels of ``edges`` on one line within STRAY of upright and ``lean``.

    Twice, the second time shifted by half of WIDE: a line must not fall between two cells.
    """
    # A line that leans to larger columns has a normal below zero, that is near pi.
    low, high = -lean - STRAY, -lean + STRAY
    highest = 0
    for turn in (0, np.pi):
        first, last = max(low + turn, 0), min(high + turn, np.pi)
        for shifted in (edges, edges[:, WIDE // 2:]) if first < last else ():
            found = cv2.HoughLinesWithAccumulator(np.ascontiguousarray(shifted), WIDE, TURN, 1,
                                                  min_theta=first, max_theta=last)
            if found is not None:
                highest = max(highest, int(found.reshape(-1, 3)[:, 2].max()))
    return highest


def _edge_points(grey, inner, rows, path, reach, clear):
    """Rows, and the column of the edge within ``reach`` of ``path`` in each, to sub-pixels.

    The column is the centroid of the grey levels' slope, the mean of five rows. Rows that are not
    ``clear``, and those where the edge has not its full height, are left out.
    """
    left = np.clip(np.round(path).astype(int) - reach, 0, grey.shape[1] - 2 * reach - 1)
    columns = left[:, None] + np.arange(2 * reach)
    # The five rows are taken at the same columns.
    mean = cv2.blur(grey, (1, _ROWS))
    slope = mean[rows[:, None], columns + 1] - mean[rows[:, None], columns]
    slope *= inner[rows[:, None], columns]
    peak = np.abs(slope).argmax(axis=1)
    clear = clear & (peak >= _REACH) & (peak < slope.shape[1] - _REACH)
    peak = np.clip(peak, _REACH, slope.shape[1] - _REACH - 1)
    offset = np.arange(-_REACH, _REACH + 1)
    near = np.take_along_axis(slope, peak[:, None] + offset, axis=1)
    rise = near.sum(axis=1)
    clear &= np.abs(rise) >= _FULL * (LIGHT - DARK)
    columns = left[clear] + .5 + peak[clear] + (near[clear] @ offset) / rise[clear]
    return rows[clear].astype(np.float64), columns


def _straight(along, across):
    """The straight line that fits points best: middle, direction, distances from it."""
    points = np.stack([along, across], axis=1)
    middle = points.mean(axis=0)
    direction, normal = np.linalg.svd(points - middle, full_matrices=False)[2]
    return middle, direction, (points - middle) @ normal


def summary(lines):
    """Counts of ``lines`` and ``lines_missed`` of a picture, and its straightness in pixels."""
    every = np.concatenate([line.deviations for line in lines])
    return {"lines": len(lines), "lines_missed": sum(line.missed for line in lines),
            "straightness_rms_px": float(np.sqrt(np.mean(every**2))),
            "straightness_max_px": float(np.abs(every).max())}
