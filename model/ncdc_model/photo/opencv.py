"""Reads image files by OpenCV: PNG, JPEG, PNM, BMP, WebP, GIF, AVIF, JPEG 2000 and others."""

import warnings
from io import BytesIO

import cv2
import numpy as np
from PIL import Image

from ncdc_model.photo.headers import declared_white, is_grey_png, pnm_pictures
from ncdc_model.photo.kinds import Kind
from ncdc_model.photo.photo import Photo
from ncdc_model.photo.quiet import captured_stderr
from ncdc_model.samples import eight_bits
from ncdc_spec.errors import InputError

__all__ = ["read_opencv"]

_PIXELS = 178_000_000      # also Pillow's limit, above which it assumes an attack


def read_opencv(path, content, kind, bits, warn):
    """The :class:`Photo` in ``content`` of the file ``path``, with its first picture.

    Pillow reads only the header: size, mode and number of pictures.

    Raises
    ------
    InputError
        If nothing can be decoded, the file is damaged or too large, or ``bits`` does not suit it.
    """
    mode, pictures = _header(path, content)
    if kind is Kind.PNM:
        content, pictures = content + b"\n", pnm_pictures(content)  # ASCII may end in a digit
    samples, printed = _decoded(content)
    corrupt = [line for line in printed if line.startswith("Corrupt JPEG data")]
    if samples is None or any("premature end" in line for line in corrupt):
        if kind is Kind.OTHER:
            raise InputError(f"{path} holds no image that can be decoded")
        raise InputError(f"{path} holds no image that can be decoded: it is a {kind.value} file "
                         f"that is damaged, cut short or of a variant that is not supported")
    if samples.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{path} holds {samples.dtype} samples, 8 or 16 bit integers are needed")
    if corrupt:
        warn(f"{path} is damaged ({corrupt[0]}): parts of the picture may be wrong")
    if pictures > 1:
        warn(f"{path}: the first of {pictures} pictures is taken")
    if mode == "CMYK":
        warn(f"{path} is in CMYK: converted to R, G, B")
    samples, declared = declared_white(kind, content, samples)
    image = eight_bits(samples, declared, bits, path, warn)
    return Photo(_channels(image, mode in ("1", "L", "LA", "P") or
                           kind is Kind.PNG and is_grey_png(content)), None, kind is Kind.JPEG)


def _header(path, content):
    """Mode and number of pictures of a file by Pillow; (None, 1) for an unknown one."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(BytesIO(content)) as header:
                size, mode, pictures = header.size, header.mode, getattr(header, "n_frames", 1)
    except Image.DecompressionBombError as error:
        raise InputError(f"{path} has too many pixels, {_PIXELS} are the limit: {error}") from error
    except Exception:       # many kinds for a damaged or unknown file
        return None, 1
    if size[0] * size[1] > _PIXELS:
        raise InputError(f"{path} has {size[0]}x{size[1]} pixels, {_PIXELS} in all are the limit")
    return mode, pictures


def _decoded(content):
    """Samples by OpenCV, or None, and the lines that the decoder printed."""
    with captured_stderr() as printed:
        try:
            samples = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
        except (cv2.error, MemoryError):
            samples = None
    return samples, printed


def _channels(image, may_be_grey):
    """(h, w), or (h, w, 3) in R, G, B order, from OpenCV's B, G, R with or without alpha."""
    if image.ndim == 2 or image.shape[2] == 1:
        return image.reshape(image.shape[:2])
    if image.shape[2] == 2:
        return np.ascontiguousarray(image[:, :, 0])
    if may_be_grey:
        blue, green, red = cv2.split(image)[:3]
        if np.array_equal(blue, green) and np.array_equal(green, red):
            return green
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB if image.shape[2] == 3 else cv2.COLOR_BGRA2RGB)
