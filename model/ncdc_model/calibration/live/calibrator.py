"""Chooses the pictures of a calibration from a running camera: frames in, a state out.

A picture is taken when the target stands still, is sharp, and is in a pose that adds to what the
pictures so far determine. The end is reached when enough of the frame is covered and no further
pose would help much; see :mod:`ncdc_model.calibration.live.information`.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.detect import parse_target
from ncdc_model.calibration.live.information import Information
from ncdc_model.calibration.live.poses import Pose, plane_of, wishes
from ncdc_model.calibration.live.sighting import may_show, sighting_of
from ncdc_model.calibration.smooth import fit_smooth
from ncdc_spec.errors import InputError

__all__ = ["MAX_PICTURES", "LiveCalibrator", "LiveState"]

MAX_PICTURES = 40
_CELLS = 10             # of the coverage map, across the frame
_COVERED = 0.9          # of the cells: the corners are hard to reach
_MIN_GAIN = 0.08        # of the best further pose: with less the calibration is complete
_STILL_SECONDS = 0.35   # without motion, before a picture is taken
_SEARCH_SECONDS = 2.0   # between searches while no target is seen, not even at a glance
_SPEED = 0.02           # of the width per second: slower is still
_SHARP = 1 / 400        # of the width: blur that counts as sharp in any case
_SOFTER = 1.4           # times the sharpest frame so far: more blur is no picture
_WRONG = 4.0            # times the usual distance from the lens: points of a wrong picture


@dataclass(frozen=True)
class LiveState:
    """State after a frame; :meth:`report` gives it as plain values.

    Parameters
    ----------
    seen : str
        What the frame shows: ``nothing``, ``moving``, ``blurred``, ``known`` (a pose of a picture
        already taken), ``wrong`` (no lens explains it with the other pictures), ``waiting`` (still,
        but not for long enough) or ``taken`` (this frame is a picture of the calibration).
    target : str
        Target that the frame shows, as of ``ncdc calibrate --target``; empty without one.
    points : ndarray, shape (n, 2)
        Its points in pixels of the frame.
    speed_px_per_second, blur_px : float
        Motion of the points; usual blur of edges. Not-a-number if not known.
    gain : float
        Part, 0 to 1, by which this pose would reduce the uncertainty; not-a-number before the
        first picture.
    pictures : int
        Pictures taken.
    coverage : ndarray of bool, shape (rows, columns)
        Parts of the frame in which pictures have points.
    uncertainty_px : float
        Of the map, rms, apart from the view; not-a-number before the first picture.
    wish : Wish or None
        The pose that would help most.
    done : bool
        Whether the calibration is complete.
    """
    seen: str
    target: str
    points: np.ndarray
    speed_px_per_second: float
    blur_px: float
    gain: float
    pictures: int
    coverage: np.ndarray
    uncertainty_px: float
    wish: object
    done: bool

    @property
    def covered(self):
        """Part of the frame's cells that are covered."""
        return float(self.coverage.mean())

    def report(self):
        """The state as plain values; the coverage map as a text per row, ``#`` where covered."""
        return {"seen": self.seen, "target": self.target, "points": len(self.points),
                "speed_px_per_second": _rounded(self.speed_px_per_second),
                "blur_px": _rounded(self.blur_px), "gain": _rounded(self.gain),
                "pictures": self.pictures, "covered": _rounded(self.covered),
                "coverage": ["".join(".#"[cell] for cell in row) for row in self.coverage.tolist()],
                "uncertainty_px": _rounded(self.uncertainty_px),
                "wish": None if self.wish is None else
                {"text": self.wish.text, "gain": _rounded(self.wish.gain)},
                "done": self.done}


def _rounded(value):
    return round(value, 4) if np.isfinite(value) else None


class LiveCalibrator:
    """Takes frames one after the other; all must have one size.

    Parameters
    ----------
    target : str
        As of ``ncdc calibrate --target``.
    limit : int
        Pictures after which the calibration ends in any case.

    Raises
    ------
    InputError
        If the target is not understood.
    """

    def __init__(self, target="auto", limit=MAX_PICTURES):
        parse_target(target)
        self.target, self.limit = target, limit
        self._size = self._coverage = self._last = self._since = self._information = None
        self._searched = -np.inf
        self._photos, self._poses, self._wish, self._sharpest = [], [], None, np.inf

    def look(self, image, seconds):
        """:class:`LiveState` after the frame ``image``, uint8 (h, w) or (h, w, 3), taken at the
        time ``seconds``.

        Raises
        ------
        InputError
            If its size is not that of the frames before.
        """
        self._check(image.shape[1::-1])
        sighting = self._sighting(image, seconds)
        speed = self._speed(sighting, seconds)
        if sighting is None:
            return self._state("nothing", None, speed, np.nan)
        self._sharpest = min(self._sharpest, np.nan_to_num(sighting.blur, nan=np.inf))
        plane = (None if self.lens is None else
                 plane_of(self.lens, sighting.index, sighting.xy))
        gain = np.nan if plane is None else self._information.gain(plane, sighting.index)
        seen = self._judged(sighting, speed, seconds, plane)
        if seen == "taken":
            seen = self._take(sighting)
        return self._state(seen, sighting, speed, gain)

    @property
    def lens(self):
        """The :class:`Camera` that explains the pictures so far; None before the first."""
        return None if self._information is None else self._information.camera

    def _sighting(self, image, seconds):
        """What the frame shows. As long as no target is seen, a search must be worth its time."""
        unseen = self._last is not None and self._last[0] is None
        if unseen and seconds - self._searched < _SEARCH_SECONDS and not may_show(image,
                                                                                   self.target):
            return None
        self._searched = seconds
        return sighting_of(image, self.target)

    def _check(self, size):
        if self._size is None:
            self._size, (width, height) = size, size
            self._coverage = np.zeros((max(1, round(_CELLS * height / width)), _CELLS), bool)
        elif size != self._size:
            raise InputError("the frame has {}x{} pixels, those before it have {}x{}".format(
                *size, *self._size))

    def _speed(self, sighting, seconds):
        """Pixels per second since the last frame; infinite without a sighting in both."""
        last, self._last = self._last, (sighting, seconds)
        if sighting is None or last is None or last[0] is None:
            speed = np.inf
        else:
            speed = sighting.moved(last[0]) / max(seconds - last[1], 1e-6)
        if speed > _SPEED * self._size[0]:
            self._since = seconds
        return speed

    def _judged(self, sighting, speed, seconds, plane):
        if speed > _SPEED * self._size[0]:
            return "moving"
        if sighting.blur > max(_SOFTER * self._sharpest, _SHARP * self._size[0]):
            return "blurred"
        if self._information is not None and (plane is None or not all(
                Pose.of(plane, sighting.index).differs(pose) for pose in self._poses)):
            return "known"
        return "waiting" if seconds - self._since < _STILL_SECONDS else "taken"

    def _take(self, sighting):
        """Fit the lens to the picture too; ``taken``, or ``wrong`` if it does not fit."""
        photos = [*self._photos, (sighting.index, sighting.xy)]
        try:
            fit = fit_smooth(self._size, photos, rough=True)
        except InputError:
            return "wrong"
        usual = [float(np.median(np.linalg.norm(fit.pixels(k, index) - xy, axis=1)))
                 for k, (index, xy) in enumerate(photos)]
        if len(photos) > 1 and usual[-1] > max(1.0, _WRONG * np.median(usual[:-1])):
            return "wrong"
        self._photos, self._information = photos, Information(fit, photos)
        self._poses = [Pose.of(plane, index) for plane, (index, _) in zip(fit.planes, photos)]
        self._coverage |= _covered(sighting.xy, self._size, self._coverage.shape)
        largest = max((index for index, _ in photos), key=len)
        self._wish = next(iter(wishes(self._information, largest, float(np.median(
            [pose.distance for pose in self._poses])))), None)
        return "taken"

    def _state(self, seen, sighting, speed, gain):
        return LiveState(
            seen=seen, target="" if sighting is None else sighting.target,
            points=np.zeros((0, 2)) if sighting is None else sighting.xy,
            speed_px_per_second=speed, blur_px=np.nan if sighting is None else sighting.blur,
            gain=gain, pictures=len(self._photos), coverage=self._coverage.copy(),
            uncertainty_px=np.nan if self._information is None else self._information.uncertainty,
            wish=self._wish, done=self._done())

    def _done(self):
        enough = self._coverage.mean() >= _COVERED and (
            self._wish is None or self._wish.gain < _MIN_GAIN)
        return bool(self._photos) and (bool(enough) or len(self._photos) >= self.limit)


def _covered(xy, size, shape):
    """Cells (rows, columns) that have a point, or whose middle lies between points."""
    rows, columns = shape
    cells = (xy + .5) * (columns / size[0], rows / size[1])
    covered = np.zeros(shape, bool)
    column, row = np.clip(cells.astype(int), 0, (columns - 1, rows - 1)).T
    covered[row, column] = True
    hull = cv2.convexHull(cells.astype(np.float32))
    for j, i in np.argwhere(~covered):
        covered[j, i] = cv2.pointPolygonTest(hull, (float(i) + .5, float(j) + .5), False) >= 0
    return covered
