"""The cameras of the PC, by OpenCV: ``camera:0`` names the first one."""

import time
from contextlib import contextmanager

import numpy as np
from cv2 import CAP_PROP_FPS, VideoCapture

from ncdc_model.photo.quiet import captured_stderr
from ncdc_spec.errors import InputError

__all__ = ["PcCamera", "is_pc_camera", "opened_camera"]

_SCHEME = "camera:"
_MAX = 99               # number of a camera
_RATES = 1, 1000        # frames per second that a camera may claim
_RATE = 30.0            # taken for one that claims none
_STORED = 8             # frames that a driver may store
_WAITED = 0.25          # of a frame's time: a frame that took longer to come is a new one


def is_pc_camera(name):
    """Whether ``name`` is to mean a camera of the PC."""
    return str(name).startswith(_SCHEME)


class PcCamera:
    """A camera that is open.

    Parameters
    ----------
    name : str
    capture : cv2.VideoCapture
        Or any object with its ``grab``, ``retrieve`` and ``get``.
    first : ndarray of uint8, shape (height, width, 3)
        Its first frame, RGB.

    Attributes
    ----------
    size : (int, int)
        Width and height of its frames.
    rate : float
        Frames per second.
    """

    def __init__(self, name, capture, first):
        self.name, self._capture, self._first = name, capture, first
        self.size, rate = first.shape[1::-1], capture.get(CAP_PROP_FPS)
        self.rate = rate if _RATES[0] <= rate <= _RATES[1] else _RATE

    def read(self):
        """The next frame, uint8 RGB (height, width, 3).

        Raises
        ------
        InputError
            If no frame comes.
        """
        first, self._first = self._first, None
        return _frame(self.name, self._capture) if first is None else first

    def newest(self):
        """The newest frame, as :meth:`read`: those that the driver has stored are left out."""
        for _ in range(_STORED):
            start = time.monotonic()
            if not self._capture.grab() or time.monotonic() - start > _WAITED / self.rate:
                break
        self._first = None
        return _frame(self.name, self._capture)


@contextmanager
def opened_camera(name):
    """Yield the :class:`PcCamera` that ``name``, as ``camera:0``, means.

    Raises
    ------
    InputError
        If the name has no number of 0 to 99, there is no such camera, or it sends no frame.
    """
    number = str(name).removeprefix(_SCHEME)
    if not number.isdecimal() or int(number) > _MAX:
        raise InputError(f"{name} is no camera of this PC: camera:0 is the first one, the limit is "
                         f"camera:{_MAX}")
    with captured_stderr():         # OpenCV prints its search for a driver
        capture = VideoCapture(int(number))
    try:
        if not capture.isOpened():
            raise InputError(f"{name}: this PC has no camera of this number, or another program "
                             f"uses it")
        yield PcCamera(name, capture, _frame(name, capture))
    finally:
        capture.release()


def _frame(name, capture):
    there, picture = capture.retrieve() if capture.grab() else (False, None)
    if not there:
        raise InputError(f"{name} sends no frame any more")
    if picture.ndim == 2:
        picture = np.dstack([picture] * 3)
    return np.ascontiguousarray(picture[:, :, ::-1])
