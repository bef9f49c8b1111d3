"""A rendered camera before which a target moves, with its true lens."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ncdc_bench.photos.lens import Lens, Plane
from ncdc_bench.photos.targets import Bank, Pose
from ncdc_model.fitted_plane import fitted_plane

__all__ = ["HAND_PICKED", "SIZE", "STEP", "Hand", "hand_picked", "map_error", "played", "seen_by",
           "sweep", "true_lens", "write_film"]

STEP = 0.2              # seconds from frame to frame
STILL = 3               # frames for which a pose is held
BLURRED = 6             # of so many moves from pose to pose, one has a frame in between
_VIEW = 0.6             # focal length over the width: 98 degrees across
SIZE = 480, 360
_BANK = Bank(Path(__file__).resolve().parents[1] / "data", SIZE[0] / 1280)
# A careful person's: the middle, each corner, each side, tilted to every side.
HAND_PICKED = tuple(Pose(middle=middle, step=step, turn=turn, tilts=tilts)
                    for middle, step, turn, tilts in (
    ((0, 0), .19, 2, (0, 0)), ((-.8, -.55), .17, -4, (20, 15)), ((.8, -.55), .17, 5, (15, -25)),
    ((-.8, .55), .17, 3, (-25, 20)), ((.8, .55), .17, -6, (-15, -20)), ((0, -.5), .15, 0, (30, 0)),
    ((0, .5), .15, 4, (-30, 5)), ((-.7, 0), .15, -3, (5, 30)), ((.7, 0), .15, 2, (0, -30)),
    ((.1, 0), .13, 20, (25, 25)), ((-.1, .1), .2, -15, (-20, 10))))


def sweep(seed=3, rounds=3):
    """Poses of a hand that goes over the picture several times, in no particular order."""
    rng, poses = np.random.default_rng(seed), [Pose(step=.16, turn=2.0, tilts=(0.0, 0.0))]
    for _ in range(rounds):
        places = [(x, y) for x in (-.8, 0, .8) for y in (-.58, 0, .58)]
        poses += [Pose(middle=(x + rng.uniform(-.12, .12), y + rng.uniform(-.08, .08)),
                       step=rng.uniform(.13, .19), turn=rng.uniform(-10, 10),
                       tilts=tuple(rng.uniform(-30, 30, 2))) for x, y in rng.permutation(places)]
    return poses


@dataclass(frozen=True)
class Hand:
    """A target of a ``kind`` and ``size`` (columns, rows)."""
    kind: str = "chessboard"
    size: tuple = (9, 6)

    @property
    def target(self):
        """As of ``ncdc calibrate --target``."""
        return "{}:{}x{}".format(self.kind, *self.size)

    def photo(self, pose, seed=1):
        """The :class:`ncdc_bench.photos.targets.Photo` of the target in a pose."""
        return _BANK.render((self.kind, *self.size, pose), view=_VIEW, seed=seed)

    def frames(self, poses):
        """Yield (image, seconds): each of ``poses`` held for a while, some blurred frames between.
        """
        time = 0.0
        for number, pose in enumerate(poses):
            still = self.photo(pose, number).image
            if number % BLURRED == 1:
                yield cv2.blur(still, (25, 1)), time
                time += STEP
            rng = np.random.default_rng(number)
            for _ in range(STILL):
                noise = rng.normal(0, 1.5, still.shape)
                yield np.clip(np.rint(still + noise), 0, 255).astype(np.uint8), time
                time += STEP


def write_film(path, poses):
    """Write a film of 30 frames per second in which a chessboard is held in ``poses``."""
    from ncdc_model.film import writing_film
    count = 0
    with writing_film(path, SIZE, 30) as out:
        for image, seconds in Hand().frames(poses):
            while count / 30 < 1.5 * (seconds + STEP):
                out.write(image)
                count += 1


def played(calibrator, frames):
    """States of a :class:`LiveCalibrator` until it is done, and its pictures by name."""
    states, pictures = [], []
    for image, seconds in frames:
        states.append(calibrator.look(image, seconds))
        if states[-1].seen == "taken":
            pictures.append((f"{len(pictures) + 1}.png", image))
        if states[-1].done:
            break
    return states, pictures


def hand_picked(hand):
    """Pictures by name, one of each pose of :data:`HAND_PICKED`."""
    return [(f"{k}.png", hand.photo(pose, 100 + k).image) for k, pose in enumerate(HAND_PICKED)]


def true_lens(size):
    """The lens of the pictures, of this ``size``."""
    width, height = size
    return Lens(_VIEW * width, ((width - 1) / 2 + 6, (height - 1) / 2 - 4))


def seen_by(pose, size, seed, columns=9, rows=6, noise=0.03):
    """Index (n, 2) and pixels (n, 2), with ``noise``, of the points that the lens would see."""
    j, i = np.mgrid[:rows, :columns]
    index = np.stack([i.ravel(), j.ravel()], axis=1).astype(np.float64)
    plane = Plane(pose, (columns, rows))
    xy = true_lens(size).pixels(plane.rays(index))
    seen = ((xy > 3) & (xy < np.array(size) - 4)).all(axis=1)
    rng = np.random.default_rng(seed)
    return index[seen], xy[seen] + rng.normal(0, noise, (seen.sum(), 2))


def map_error(camera, lens):
    """Distances (n,) in pixels of the map of ``camera`` from that of the true ``lens``, over the
    whole picture, apart from the view."""
    width, height = camera.size
    x, y = (part.ravel() for part in np.meshgrid(np.arange(4.0, width, 16),
                                                 np.arange(4.0, height, 16)))
    a, b = lens.plane(x, y)
    return np.hypot(*np.subtract(fitted_plane(camera, a, b, x, y)(a, b), (x, y)))
