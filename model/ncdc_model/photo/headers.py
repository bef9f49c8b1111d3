"""Reads the range of samples from headers of PNG, PNM, JPEG 2000, which OpenCV drops."""

import re

import numpy as np

from ncdc_model.photo.kinds import Kind

__all__ = ["declared_white", "is_grey_png", "pnm_pictures"]

_PNM = re.compile(rb"P[2356](?:\s|#[^\n]*\n)+\d+(?:\s|#[^\n]*\n)+\d+(?:\s|#[^\n]*\n)+(\d+)")
_PAM = re.compile(rb"P7\n(?:[^\n]*\n)*?MAXVAL\s+(\d+)")
_CONTAINER = 255, 65535


def declared_white(kind, content, samples):
    """Samples and their largest value by the header; None if that only says 16 bits.

    ``samples``: decoded from ``content`` by OpenCV. Samples of a PNG whose sBIT chunk
    declares fewer bits than it stores are shifted down to that number.
    """
    if kind is Kind.PNG:
        return _by_sbit(content, samples)
    declared = None
    if kind is Kind.PNM and (match := _PNM.match(content) or _PAM.match(content)):
        declared = int(match[1])
        if content[1:2] in b"23" and declared < 256:
            declared = 255      # OpenCV scales only samples in ASCII
    elif kind is Kind.JPEG_2000 and (start := content.find(b"\xff\x4f\xff\x51")) >= 0:
        declared = (1 << (content[start + 42] & 0x7f) + 1) - 1
    elif kind is Kind.AVIF and samples.dtype == np.uint16:
        declared = _avif_white(content)
    if declared is None or declared in _CONTAINER:
        declared = 255 if samples.dtype == np.uint8 else None
    return samples, declared


def _avif_white(content):
    """1023 or 4095, by the high_bitdepth and twelve_bit flags of the AV1 configuration."""
    start = content.find(b"av1C")
    flags = content[start + 6] if start >= 0 else 0
    return {0: 255, 0x40: 1023, 0x60: 4095}.get(flags & 0x60)


def _chunks(content):
    """(name, data) of the chunks of a PNG up to its picture."""
    start = 8
    while start + 8 <= len(content):
        length, name = int.from_bytes(content[start:start + 4]), content[start + 4:start + 8]
        if name == b"IDAT":
            return
        yield name, content[start + 8:start + 8 + length]
        start += length + 12


def is_grey_png(content):
    """Whether a PNG is grey with alpha, which OpenCV decodes as four channels."""
    return content[25] == 4


def _by_sbit(content, samples):
    """Samples of a PNG and their largest value, by its sBIT chunk.

    The standard has n bits in the upper n; the others are zeros, a repetition, or those of linear
    scaling. Many programs write them in the lower n, with zeros above.
    """
    size = 8 * samples.dtype.itemsize
    chunk = dict(_chunks(content)).get(b"sBIT", b"")
    bits = set(chunk[:len(chunk) - (content[25] in (4, 6))])
    if len(bits) != 1 or content[25] == 3 or not 0 < (n := bits.pop()) <= size:
        return samples, 255 if size == 8 else None
    white, full = (1 << n) - 1, (1 << size) - 1
    seen = np.zeros(full + 1, bool)
    seen[samples[..., :3] if samples.ndim == 3 else samples] = True
    values = np.flatnonzero(seen)
    upper = values >> (size - n)
    repeated = sum((upper << size - n) >> (k * n) for k in range(-(-size // n)))
    linear = ((2 * values * white + full) // (2 * full) * 2 * full + white) // (2 * white)
    in_upper = any((values == shape).all() for shape in (upper << size - n, repeated, linear))
    if not in_upper and values[-1] <= white:
        return samples, white
    return samples >> (size - n), white


def pnm_pictures(content):
    """Number of pictures in a binary PNM file, of which OpenCV reads the first; else 1."""
    match = re.match(rb"P([456])(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)", content)
    if not match:
        return 1
    digit, width, height = (int(value) for value in match.groups())
    header = match if digit == 4 else _PNM.match(content)
    if not header:
        return 1
    row = ((width + 7) // 8 if digit == 4 else
           width * (3 if digit == 6 else 1) * (2 if int(header[1]) > 255 else 1))
    length, count, start = header.end() + 1 + row * height, 1, 0
    while content[start + length:start + length + 2] == content[:2]:
        start, count = start + length, count + 1
    return count
