"""Frames of a running source, whatever it is: a camera of the PC, a film, or a device."""

import time
from contextlib import contextmanager

from ncdc_host.client import open_device
from ncdc_host.client.view_state import has_correction, read_view, show_whole, write_view
from ncdc_model.images import is_film
from ncdc_model.pc_camera import is_pc_camera, opened_camera
from ncdc_spec.errors import InputError

__all__ = ["frames_of"]

_PAUSE = 0.15           # seconds between two pictures of a film that are looked at
_TIMEOUT = 5.0          # seconds to wait for a frame of a device


@contextmanager
def frames_of(name):
    """Yield an iterator of (image, seconds) of the source ``name``.

    The images are whole frames as the sensor's pixels lie, uint8: (height, width, 3) RGB, or
    (height, width) of a raw or a grey frame. The frames of a device of ours are raw; what it sent
    before is set again at the end.

    Parameters
    ----------
    name : str
        ``camera:0``, a film, or the URL of a device.

    Raises
    ------
    InputError, DeviceError
        If the source cannot be opened, or ends unexpectedly.
    """
    if is_pc_camera(name):
        with opened_camera(name) as camera:
            yield _camera_frames(camera)
    elif is_film(name):
        from ncdc_model.film import pictures_of  # needs an extra
        yield pictures_of(name, _PAUSE)
    elif "://" in name:
        with open_device(name) as device, _whole(device), device.stream() as stream:
            yield _device_frames(stream)
    else:
        raise InputError(f"{name} is no running source: camera:0, a film as clip.mp4, or the URL "
                         f"of a device as gige://192.168.1.20 is needed")


@contextmanager
def _whole(device):
    """With a device that sends its whole raw frames, as far as it can."""
    if not has_correction(device):
        yield
        return
    view = read_view(device)
    show_whole(device, False, mirrored=False)
    try:
        yield
    finally:
        write_view(device, view)


def _camera_frames(camera):
    while True:
        yield camera.newest(), time.monotonic()


def _device_frames(stream):
    while True:
        frame = stream.next(_TIMEOUT)
        yield frame.pixels, frame.time_ns / 1e9
