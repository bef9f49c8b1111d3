"""Light on the emulated sensor: a photo, or the built-in scene in motion."""

import cv2
import numpy as np

from ncdc_model.example import scene_at
from ncdc_model.golden.corrector import check_raw
from ncdc_model.golden.inverse import inverse_map
from ncdc_model.images import is_raw, mosaic

__all__ = ["POSITIONS", "MovingScene", "Photo"]

POSITIONS = 16          # of the scene in motion, before it repeats
_SWING = 0.05           # of the picture's width that it moves to either side
_MARGIN = 0.25          # of the width that is painted around the corrected frame
_BAND = 32              # rows that are painted at a time: a pixel takes 100 bytes meanwhile


class Photo:
    """The same raw frame again and again.

    Parameters
    ----------
    image : ndarray
        Raw frame, or an RGB picture, which is mosaiced; of the distorted size.
    geometry : Geometry

    Raises
    ------
    InputError
        If it is of another size.
    """
    def __init__(self, image, geometry):
        self._raw = image if is_raw(image) else mosaic(image, geometry.bayer)
        check_raw(self._raw, geometry)

    def position(self, number):
        """Which of the pictures frame ``number`` shows."""
        return 0

    def raw(self, position):
        """Raw uint8 (height, width) frame of that light at the reference exposure."""
        return self._raw


class MovingScene:
    """The built-in scene, moved a little from frame to frame, through the lens of a descriptor.

    The scene is flat in the corrected picture; the descriptor's map, inverted between knots, bends
    it. So a device of any descriptor shows something that its correction makes straight.
    """
    def __init__(self, descriptor):
        self._geometry = geometry = descriptor.geometry
        width, height = geometry.corrected
        self._margin = round(_MARGIN * width)
        scale, painted = 2.0 / width, []
        for top in range(-self._margin, height + self._margin, _BAND):
            v, u = np.mgrid[top:min(top + _BAND, height + self._margin),
                            -self._margin:width + self._margin]
            painted.append(scene_at(((u - width / 2) * scale).astype(np.float32),
                                    ((v - height / 2) * scale).astype(np.float32)).astype(np.uint8))
        self._world = cv2.GaussianBlur(np.concatenate(painted), (3, 3), 0)
        self._map = inverse_map(descriptor)
        self._frames = {}       # by position: all of them take as much as five pictures

    def position(self, number):
        """Which of the pictures frame ``number`` shows: each one twice."""
        return number // 2 % POSITIONS

    def raw(self, position):
        """Raw uint8 (height, width) frame of that light at the reference exposure."""
        if position not in self._frames:
            self._frames[position] = self._painted(position)
        return self._frames[position]

    def _painted(self, position):
        angle = 2 * np.pi * position / POSITIONS
        swing = _SWING * self._geometry.corrected_width
        x = self._map[0] + np.float32(self._margin + swing * np.sin(angle))
        y = self._map[1] + np.float32(self._margin + swing / 2 * np.cos(angle))
        light = cv2.remap(self._world, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        return mosaic(light, self._geometry.bayer)
