"""Reads a photo or raw frame from a file of any supported format."""

from ncdc_model.photo.camera_raw import read_camera_raw
from ncdc_model.photo.kinds import Kind, kind_of
from ncdc_model.photo.numpy_file import read_npy
from ncdc_model.photo.opencv import read_opencv
from ncdc_model.photo.tiff import read_tiff
from ncdc_spec.files import read_bytes

__all__ = ["decode_photo", "read_photo"]

_READERS = {Kind.TIFF: read_tiff, Kind.CAMERA_RAW: read_camera_raw, Kind.NUMPY: read_npy}


def read_photo(path, bits=None, warn=lambda sentence: None):
    """The :class:`ncdc_model.photo.photo.Photo` in the file ``path``, with any suffix.

    ``bits`` of a sample are needed only if the file does not declare them. ``warn`` is called with
    a sentence if something is a guess, or only a part of the file is read.

    Raises
    ------
    InputError
        If the file cannot be read, holds no image of a supported format, or contradicts ``bits``.
    """
    return decode_photo(path, read_bytes(path), bits, warn)


def decode_photo(path, content, bits=None, warn=lambda sentence: None):
    """As :func:`read_photo`, of a file whose ``content`` was read before."""
    kind = kind_of(content, path)
    if reader := _READERS.get(kind):
        return reader(path, content, bits, warn)
    return read_opencv(path, content, kind, bits, warn)
