"""Image files written by tifffile, Pillow and by hand from the standards, for readers to read."""

import struct
import zlib

import numpy as np
import tifffile

from ncdc_model.photo.read import read_photo

__all__ = ["SAMPLES", "dng", "png", "read"]

# 16-bit samples with every upper byte.
SAMPLES = (np.arange(48 * 64, dtype=np.uint32).reshape(48, 64) * 40503 % 65536).astype(np.uint16)


def read(path, bits=None):
    """(photo, its warnings) of a file."""
    said = []
    return read_photo(path, bits, said.append), said


def png(path, samples, depth, colour=0, chunks=()):
    """Write a PNG with more ``chunks``, (name, data), ahead of its picture."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(
            ">I", zlib.crc32(name + data))

    height, width = samples.shape[:2]
    rows = samples.astype(">u2" if depth == 16 else np.uint8)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(
        ">IIBBBBB", width, height, depth, colour, 0, 0, 0)) + b"".join(
            chunk(*one) for one in chunks) + chunk(
                b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows)))
        + chunk(b"IEND", b""))


def dng(path, samples, photometric=32803, pattern=(0, 1, 1, 2), white=4095, more=()):
    """Write a DNG by tifffile: a black RGB preview, in a SubIFD the raw frame ``samples``."""
    tags = [(50706, "B", 4, (1, 4, 0, 0), True), (50708, "s", 0, "Peer", True),
            (271, "s", 0, "Peer", True), (272, "s", 0, "Camera", True),
            (50721, "2i", 9, (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1), True),
            (50728, "2I", 3, (1, 1, 1, 1, 1, 1), True), (50778, "H", 1, 21, True)]
    size = round(len(pattern)**.5)
    filtered = [(33421, "H", 2, (size, size), True),
                (33422, "B", len(pattern), pattern, True), (50717, "H", 1, white, True), *more]
    with tifffile.TiffWriter(path) as file:
        file.write(np.zeros((24, 32, 3), np.uint8), photometric="rgb", subfiletype=1, subifds=1,
                   extratags=tags, metadata=None)
        file.write(samples, photometric=photometric, subfiletype=0, extratags=filtered,
                   metadata=None)
