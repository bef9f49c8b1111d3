"""Pictures inside a page: data URIs."""

import base64
import tempfile
from pathlib import Path

import cv2

__all__ = ["embedded", "embedded_plot"]

_LARGEST = 1600         # pixels: wider pictures are reduced, the page shows no more
_QUALITY = 88           # of JPEG


def embedded(picture):
    """Data URI of an RGB ``picture``, uint8 (height, width, 3), as a JPEG of 1600 columns or
    fewer."""
    width = picture.shape[1]
    if width > _LARGEST:
        picture = cv2.resize(picture, None, fx=_LARGEST / width, fy=_LARGEST / width,
                             interpolation=cv2.INTER_AREA)
    content = cv2.imencode(".jpg", picture[:, :, ::-1], (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))[1]
    return _uri("jpeg", content.tobytes())


def embedded_plot(plot, *values):
    """Data URI of the PNG that ``plot(path, *values)`` writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plot.png"
        plot(path, *values)
        return _uri("png", path.read_bytes())


def _uri(kind, content):
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
