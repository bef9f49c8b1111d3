"""Image files, the Bayer mosaic, and its conversions. Colours are in R, G, B order."""

from pathlib import Path

import cv2
import numpy as np

from ncdc_model.photo.kinds import HEAD, film_by
from ncdc_model.photo.read import read_photo
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file
from ncdc_spec.geometry import BAYER_PHASE, MONO

__all__ = ["ANIMATIONS", "FILMS", "check_animation", "check_suffix", "demosaic", "is_film",
           "is_film_name", "is_raw", "mosaic", "read_image", "write_animation", "write_image"]

ANIMATIONS = (".png", ".webp", ".gif")
FILMS = (".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi")

# OpenCV names a pattern by the 2x2 block that starts at the second row and column, so that its
# "BG" is the pattern whose first two samples are R, G.
_OPENCV = {"RGGB": "BG", "GRBG": "GB", "GBRG": "GR", "BGGR": "RG"}
_METHODS = {"bilinear": "", "edge-aware": "_EA", "vng": "_VNG"}     # of OpenCV's demosaicing


def read_image(path, bits=None, warn=lambda sentence: None):
    """The image in the file ``path`` as uint8, (height, width) or (height, width, 3) RGB.

    See :func:`ncdc_model.photo.read.read_photo`.
    """
    return read_photo(path, bits, warn).image


def check_suffix(path):
    """Raise :class:`InputError` if OpenCV writes no format with the suffix of ``path``."""
    try:
        known = cv2.haveImageWriter(f"x{Path(path).suffix}")
    except cv2.error:
        known = False
    if not known:
        raise InputError(f"{path} has the suffix {Path(path).suffix!r}, which names no image "
                         f"format; .png is one")


def write_image(path, image):
    """Write uint8 ``image``, (h, w) or (h, w, 3) RGB, in the format that the suffix names.

    The file is replaced whole or not at all.

    Raises
    ------
    InputError
        If OpenCV knows no format of that suffix or the folder cannot be written.
    """
    image = np.asarray(image)
    check_suffix(path)
    try:
        picture = cv2.cvtColor(image, cv2.COLOR_RGB2BGR) if image.ndim == 3 else image
        content = cv2.imencode(Path(path).suffix, picture)[1]
    except cv2.error as error:
        raise InputError(f"cannot write {path}: {error.err}") from error
    with replace_file(path) as temporary:
        temporary.write_bytes(content.tobytes())


def check_animation(path):
    """Raise :class:`InputError` if no animation is written with the suffix of ``path``."""
    if Path(path).suffix.lower() not in ANIMATIONS:
        raise InputError(f"{path} has the suffix {Path(path).suffix!r}, an animation is written as "
                         f"one of {', '.join(ANIMATIONS)}")


def write_animation(path, frames, milliseconds):
    """Write uint8 RGB ``frames``, each shown for ``milliseconds``, in an endless loop.

    The file is replaced whole or not at all.

    Raises
    ------
    InputError
        If the suffix is none of :data:`ANIMATIONS` or the folder cannot be written.
    """
    check_animation(path)
    animation = cv2.Animation()
    animation.frames = [np.ascontiguousarray(frame[:, :, ::-1]) for frame in frames]
    animation.durations = np.full(len(frames), milliseconds, np.int32)
    content = cv2.imencodeanimation(Path(path).suffix.lower(), animation)[1]
    with replace_file(path) as temporary:
        temporary.write_bytes(content.tobytes())


def is_film_name(path):
    """Whether the suffix of ``path`` is one of :data:`FILMS`, as which films are written."""
    return Path(path).suffix.lower() in FILMS


def is_film(path, animated=False):
    """Whether the file ``path`` holds a film, by its first bytes; see :mod:`ncdc_model.film`.

    The suffix decides where they say nothing: of bytes that no format known here begins with, or
    a file that cannot be read. A GIF is a film if ``animated``, else a picture.
    """
    try:
        with open(path, "rb") as file:
            head = file.read(HEAD)
    except (OSError, ValueError):
        return is_film_name(path)
    known = film_by(head, animated)
    return is_film_name(path) if known is None else known


def is_raw(image):
    """Whether ``image`` has one channel, as the raw frame of a sensor has."""
    return np.ndim(image) == 2


def mosaic(rgb, bayer="RGGB"):
    """Raw (h, w) frame: the colour of each pixel of ``rgb`` (h, w, 3) that the filter passes.

    For a grey sensor (``MONO``) the brightness (red + 2 green + blue) / 4, rounded for integers.
    """
    if bayer == MONO:
        brightness = (np.asarray(rgb) @ np.array([.25, .5, .25])).astype(np.float64)
        if np.issubdtype(np.asarray(rgb).dtype, np.integer):
            return np.floor(brightness + .5).astype(np.asarray(rgb).dtype)
        return brightness.astype(np.asarray(rgb).dtype)
    column, row = BAYER_PHASE[bayer]
    raw = np.array(rgb[:, :, 1])
    raw[row::2, column::2] = rgb[row::2, column::2, 0]
    raw[1 - row::2, 1 - column::2] = rgb[1 - row::2, 1 - column::2, 2]
    return raw


def demosaic(raw, bayer="RGGB", method="bilinear"):
    """RGB (h, w, 3) of a uint8 ``raw`` frame by OpenCV: bilinear, edge-aware or vng.

    All three colours of a grey sensor's frame (``MONO``) are the samples themselves.
    """
    if bayer == MONO:
        return np.repeat(raw[:, :, None], 3, axis=2)
    code = getattr(cv2, f"COLOR_Bayer{_OPENCV[bayer]}2RGB{_METHODS[method]}")
    return cv2.cvtColor(np.ascontiguousarray(raw), code)
