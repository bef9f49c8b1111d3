"""Free pictures of our own making that are hard to demosaic, the same in every checkout.

Each is computed at three times its size and reduced by area, as light falls on a sensor's pixels.
"""

import cv2
import numpy as np

__all__ = ["SYNTHETIC", "synthetic_picture"]

_SIZE = 384, 256        # columns and rows
_FINER = 3              # computed points of a pixel, in each direction


def synthetic_picture(name):
    """The picture ``name`` of :data:`SYNTHETIC`, uint8 (256, 384, 3)."""
    width, height = _SIZE
    y, x = (np.indices((height * _FINER, width * _FINER)) + .5) / _FINER
    light = SYNTHETIC[name](x, y, np.random.default_rng(1))
    reduced = cv2.resize(light.astype(np.float32), _SIZE, interpolation=cv2.INTER_AREA)
    return np.clip(np.floor(reduced + .5), 0, 255).astype(np.uint8)


def _colour(rng, spread):
    """Red, green and blue of a random brightness, that differ from it by about ``spread``."""
    return np.clip(rng.uniform(25, 230) + spread * rng.standard_normal(3), 0, 255)


def _leaves(x, y, rng):
    """Discs of 2 to 40 pixels' radius, one over another: edges of every size and direction."""
    light = np.full((*x.shape, 3), 127, np.float32)
    for radius in rng.uniform(40**-2, 2**-2, 8000)**-.5:
        centre = rng.uniform((0, 0), x.shape[::-1])
        cv2.circle(light, np.rint(centre).astype(int).tolist(), round(radius * _FINER),
                   _colour(rng, 25).tolist(), cv2.FILLED)
    return light


def _rings(x, y, rng):
    """Rings that become finer outwards, to 3 pixels a ring; their colour turns with the angle."""
    x, y = x - _SIZE[0] / 2, y - _SIZE[1] / 2
    reach = np.hypot(*_SIZE) / 2
    wave = np.cos(np.pi / 3 * (x * x + y * y) / reach)
    tint = 30 * np.cos(np.arctan2(y, x)[..., None] + np.array([0, 2, 4]) * np.pi / 3)
    return 127 + 90 * wave[..., None] + tint


def _fabric(x, y, rng):
    """Threads of two saturated colours that cross, from 12 to 5 pixels wide."""
    pitch = 12 - 7 * x / _SIZE[0]
    along, down = ((.94 * a + sign * .34 * b) / pitch for a, b, sign in ((x, y, 1), (y, x, -1)))
    over = (np.floor(along) + np.floor(down)) % 2 == 0
    round_off = .45 + .55 * np.sin(np.pi * np.where(over, along, down))**2
    return np.where(over[..., None], (205, 60, 45), (40, 95, 190)) * round_off[..., None]


def _fence(x, y, rng):
    """Slanted white posts, ever closer, before a soft coloured sky."""
    soft = rng.standard_normal((8, 12, 3)).astype(np.float32) * 18
    sky = np.array([110, 150, 190]) + cv2.resize(soft, x.shape[::-1], interpolation=cv2.INTER_CUBIC)
    phase = (x + .15 * y) * (.08 + .12 * x / _SIZE[0])
    post = (np.mod(phase, 1) < .5) & (y > 20 + 30 * np.mod(.37 * np.floor(phase), 1))
    return np.where(post[..., None], (238, 234, 226), sky)


SYNTHETIC = {"leaves": _leaves, "rings": _rings, "fabric": _fabric, "fence": _fence}
