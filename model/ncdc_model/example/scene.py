"""The example's scene: a house front over a tiled square, with many straight lines."""

import numpy as np

from ncdc_model.example.camera import BAYER
from ncdc_model.example.render import expose, ideal_samples, sensor

__all__ = ["noise_picture", "scene_at", "scene_light", "scene_photo"]

_HORIZON, _KERB, _EAVES = 0.05, 0.62, -0.98     # ideal y of the horizon, the kerb and the roof
_STOREYS = (-0.86, -0.46, -0.06)                # ideal y of the tops of the rows of windows


def scene_photo(camera, seed=1, bayer=BAYER):
    """Raw uint8 photo (height, width) of the scene by ``camera``, deterministic for ``seed``."""
    return sensor(scene_light(camera), bayer, seed)


def scene_light(camera):
    """Linear light (height, width, 3) in 0..255 that falls on each pixel of ``camera``."""
    return expose(scene_at(*ideal_samples(camera)))


def noise_picture(width, height, seed=1):
    """Raw (height, width) uint8 frame of random 0 and 255: the hardest input for interpolation."""
    return (255 * np.random.default_rng(seed).integers(0, 2, (height, width))).astype(np.uint8)


def scene_at(a, b):
    """Light (..., 3) in 0..255 of the ideal points (a, b)."""
    image = np.empty((*a.shape, 3))
    image[:] = (1 + 0.25 * (b + 1))[..., None] * np.array([125, 165, 215])
    _wall(image, a, b)
    for k, top in enumerate(_STOREYS):
        _windows(image, a, b, top, k)
    _shops(image, a, b)
    _chart(image, a + 0.02, b - 0.02)
    _square(image, a, b)
    return np.clip(image, 0, 245)


def _wall(image, a, b):
    """Bricks with mortar, cornices between the storeys, the roof's edge."""
    wall = (b > _EAVES) & (b <= _KERB)
    course = np.floor(b / 0.032)
    along = a / 0.085 + 0.5 * (course % 2)
    tone = np.sin(12.9898 * np.floor(along) + 78.233 * course) * 43758.5453
    tone = 0.86 + 0.28 * (tone - np.floor(tone))
    mortar = (np.mod(b, 0.032) < 0.005) | (np.mod(along, 1) < 0.06)
    brick = np.where(mortar, 1.0, tone)[..., None] * np.where(
        mortar[..., None], np.array([172, 162, 150]), np.array([158, 84, 62]))
    image[wall] = brick[wall]
    for y, size in ((_EAVES, 0.045), (-0.52, 0.022), (-0.12, 0.022), (0.29, 0.035)):
        band = (b > y) & (b < y + size)
        image[band] = (225, 218, 202)
        image[(b > y + size) & (b < y + size + 0.008)] = (96, 62, 50)


def _windows(image, a, b, top, storey):
    """One row of windows: frame, glass with a reflection, glazing bars, a coloured blind."""
    x, y = np.mod(a + 0.15, 0.30) - 0.15, b - top
    number = np.floor((a + 0.15) / 0.30)
    image[(abs(x) < 0.095) & (y > 0) & (y < 0.30)] = (232, 230, 222)
    glass = (abs(x) < 0.080) & (y > 0.015) & (y < 0.285)
    shine = 0.75 + 0.35 * (np.mod(x + 0.45 * y, 0.13) < 0.035) - 0.8 * y
    image[glass] = (shine[..., None] * np.array([70, 112, 140]))[glass]
    colours = np.array([[196, 60, 52], [240, 186, 64], [62, 128, 96], [70, 92, 170],
                        [220, 214, 200]])
    pick = colours[np.mod(3 * number + 2 * storey, 5).astype(int)]
    blind = glass & (y < 0.06 + 0.05 * np.mod(number + storey, 3))
    stripe = np.where(np.mod(x, 0.016) < 0.008, 1.0, 0.82)[..., None]
    image[blind] = (pick * stripe)[blind]
    image[glass & ((abs(x) < 0.006) | (abs(y - 0.16) < 0.005))] = (232, 230, 222)


def _shops(image, a, b):
    """Ground floor: coloured panels, doors, striped awnings."""
    x = np.mod(a + 0.30, 0.60) - 0.30
    number = np.floor((a + 0.30) / 0.60)
    colours = np.array([[52, 86, 120], [148, 52, 62], [58, 106, 78], [196, 150, 60]])
    pick = colours[np.mod(number, 4).astype(int)]
    front = (abs(x) < 0.27) & (b > 0.35) & (b <= _KERB)
    image[front] = pick[front]
    pane = (abs(np.mod(x + 0.27, 0.18) - 0.09) < 0.075) & (b > 0.43) & (b < 0.585) & front
    image[pane] = ((0.7 + 1.2 * (b - 0.43))[..., None] * np.array([92, 120, 128]))[pane]
    awning = (abs(x) < 0.285) & (b > 0.325) & (b < 0.405)
    light = np.mod(x, 0.05)[..., None] < 0.025
    image[awning] = np.where(light, np.array([240, 236, 226]), pick)[awning]


def _chart(image, a, b):
    """A board in the middle of the front: star of wedges, fine bars, a chessboard, colours."""
    image[(abs(a) < 0.235) & (abs(b) < 0.175)] = (52, 56, 62)
    board = (abs(a) < 0.222) & (abs(b) < 0.162)
    image[board] = (238, 238, 234)
    r, angle = np.hypot(a + 0.10, b + 0.02), np.arctan2(b + 0.02, a + 0.10)
    star = (r < 0.105) & (np.sin(18 * angle) > 0)
    image[star] = (24, 24, 26)
    chess = (a > 0.03) & (a < 0.21) & (b > -0.14) & (b < -0.02)
    dark = np.mod(np.floor((a - 0.03) / 0.02) + np.floor((b + 0.14) / 0.02), 2) == 0
    image[chess & dark] = (28, 28, 30)
    bars = (a > 0.03) & (a < 0.21) & (b > 0.0) & (b < 0.05)
    image[bars & (np.sin(np.pi * (a - 0.03) * (60 + 600 * (a - 0.03))) > 0)] = (28, 28, 30)
    patches = board & (b > 0.10) & (b < 0.15) & (abs(a) < 0.21)
    colours = np.array([[200, 50, 50], [230, 140, 40], [235, 215, 60], [60, 160, 75],
                        [50, 150, 190], [60, 75, 170], [140, 65, 150]])
    pick = colours[np.clip((a + 0.21) / 0.06, 0, 6).astype(int)]
    image[patches] = pick[patches]


def _square(image, a, b):
    """The square before the house: kerb and chessboard tiles in perspective."""
    ground = b > _KERB
    depth = (_KERB - _HORIZON) / np.maximum(b - _HORIZON, 0.1)
    x, z = a * depth / 0.11, 3.2 * depth / 0.35
    tone = np.where(np.mod(np.floor(x) + np.floor(z), 2) == 0, 1.0, 0.62)
    joint = (np.mod(x, 1) < 0.05) | (np.mod(z, 1) < 0.05)
    tile = np.where(joint, 0.45, tone)[..., None] * np.array([196, 190, 176])
    image[ground] = tile[ground]
    image[(b > _KERB) & (b < _KERB + 0.022)] = (206, 204, 200)
    image[(b > _KERB + 0.022) & (b < _KERB + 0.032)] = (92, 90, 88)
