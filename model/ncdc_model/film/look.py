"""How the pictures of a film look: samples, colours, shape of the pixels, rotation, HDR."""

import struct
from dataclasses import dataclass, field
from fractions import Fraction

import av
import cv2
import numpy as np
from av.sidedata.sidedata import Type
from av.video.reformatter import ColorRange, Colorspace, Interpolation

__all__ = ["COLOUR_TAGS", "Look", "planes_of", "rgb_of", "tags_of", "transparent"]

COLOUR_TAGS = "color_range", "colorspace", "color_primaries", "color_trc"
_UNSPECIFIED = 2        # of a matrix, primaries and transfer in H.273
_BT709 = 1
# swscale's matrix by the number of H.273; others have the primaries' of no common film.
_MATRICES = {1: Colorspace.ITU709, 4: Colorspace.FCC, 7: Colorspace.SMPTE240M,
             9: Colorspace.BT2020, 10: Colorspace.BT2020}
# Without these, swscale's fast ways to RGB are two levels too dark.
_TO_RGB = (Interpolation.BICUBIC | Interpolation.ACCURATE_RND | Interpolation.FULL_CHR_H_INT
           | Interpolation.FULL_CHR_H_INP)
_FROM_RGB = Interpolation.BILINEAR | Interpolation.ACCURATE_RND
_MASTERING = struct.Struct("=20i2i")    # AVMasteringDisplayMetadata: ten fractions, two flags


@dataclass(frozen=True)
class Look:
    """What the pictures of a film have in common.

    Parameters
    ----------
    bits : int
        Of a sample.
    chroma : str
        ``420``, ``422`` or ``444``.
    tags : dict
        The numbers of H.273 by the names :data:`COLOUR_TAGS`.
    rgb : bool
        The source's samples are red, green and blue, which become Y'CbCr.
    alpha : bool
        The source has an alpha channel.
    aspect : Fraction
        Width of a pixel over its height.
    matrix : tuple of int
        By which players turn and mirror the pictures, or empty.
    mastering, light : tuple of int
        Of HDR: x and y of red, green, blue and white in units of 1/50000, least and greatest
        luminance in 1/10000 cd/m2; greatest and mean light level in cd/m2. Or empty.
    """
    bits: int = 8
    chroma: str = "420"
    tags: dict = field(default_factory=lambda: {
        "color_range": int(ColorRange.MPEG), "colorspace": _BT709,
        "color_primaries": _UNSPECIFIED, "color_trc": _UNSPECIFIED})
    rgb: bool = True
    alpha: bool = False
    aspect: Fraction = Fraction(1)
    matrix: tuple = ()
    mastering: tuple = ()
    light: tuple = ()

    @classmethod
    def of(cls, frame, aspect):
        """The look of a decoded ``frame``; ``aspect`` of its pixels, None for squares."""
        layout, side = frame.format, frame.side_data
        rgb, parts = _is_rgb(layout), layout.components
        chroma = "444" if rgb else "420"
        if len(parts) >= 3 and not rgb:
            chroma = ("444" if layout.chroma_width() == frame.width else
                      "422" if layout.chroma_height() == frame.height else "420")
        return cls(max(part.bits for part in parts), chroma, tags_of(frame), rgb,
                   any(part.is_alpha for part in parts), Fraction(aspect or 1),
                   _numbers(side.get(Type.DISPLAYMATRIX), "9i"), _mastering(side),
                   _numbers(side.get(Type.CONTENT_LIGHT_LEVEL), "2I"))

    @property
    def _conversion(self):
        """swscale's matrix and range, of which it takes an unspecified one for limited."""
        return {"dst_colorspace": _MATRICES.get(self.tags["colorspace"], Colorspace.DEFAULT),
                "dst_color_range": self.tags["color_range"] or ColorRange.MPEG}

    def frame_of(self, rgb, form):
        """A frame of the pixel format ``form``, with the tags, of an ``rgb`` picture, uint8."""
        height, width = rgb.shape[:2]
        picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(rgb), "rgb24").reformat(
            format="444p".join(form.split(f"{_chroma(form)}p")), interpolation=_FROM_RGB,
            **self._conversion)
        made = self.tagged(av.VideoFrame(width, height, form))
        for target, plane in zip(planes_of(made), planes_of(picture), strict=True):
            target[:] = _reduced(plane, target.shape)
        return made

    def sampled(self, frame, form):
        """``frame`` in a pixel format ``form`` of Y'CbCr. If it was so before, nothing but the
        number of its samples and their bits change, whatever its matrix."""
        if _is_rgb(frame.format):
            return self.tagged(frame.reformat(format=form, interpolation=_FROM_RGB,
                                              **self._conversion))
        matrix = frame.colorspace
        # swscale rejects a matrix that it cannot convert, even where there is nothing to convert.
        frame.colorspace = _BT709
        span = frame.color_range or self.tags["color_range"] or ColorRange.MPEG
        changed = frame.reformat(format=form, interpolation="BICUBIC", src_color_range=span,
                                 dst_color_range=span)
        frame.colorspace = matrix
        if len(frame.format.components) < 3:
            for plane in planes_of(changed)[1:]:
                plane[:] = 1 << changed.format.components[0].bits - 1     # grey
        return changed

    def tagged(self, target):
        """``target``, a frame or an encoder, with the tags."""
        for name, value in self.tags.items():
            setattr(target, name, value)
        return target

    def hdr_options(self, codec):
        """Options of an encoder that write the constant data of HDR; none if it has no such."""
        if codec not in _HDR:
            return {}
        option, mastering, light, unit, nits = _HDR[codec]
        words = []
        if self.mastering:
            red, green, blue, white = (
                ",".join(_decimal(part, unit) for part in self.mastering[k:k + 2])
                for k in (0, 2, 4, 6))
            low, high = (_decimal(part, nits) for part in self.mastering[8:])
            words.append(f"{mastering}=G({green})B({blue})R({red})WP({white})L({high},{low})")
        if self.light:
            words.append(f"{light}={self.light[0]},{self.light[1]}")
        return {option: ":".join(words)} if words else {}


# Option, names of the two words, and what a unit of them is in those of a Look.
_HDR = {"libx264": ("x264-params", "mastering-display", "cll", 1, 1),
        "libx265": ("x265-params", "master-display", "max-cll", 1, 1),
        "libsvtav1": ("svtav1-params", "mastering-display", "content-light", 50000, 10000)}


def rgb_of(frame):
    """The RGB picture of a ``frame``, uint8 (height, width, 3); raises av.FFmpegError if its
    matrix is none that swscale converts."""
    return frame.to_ndarray(format="rgb24", interpolation=_TO_RGB)


def tags_of(frame):
    """The colour tags of a ``frame``, as they are when its samples have become Y'CbCr."""
    tags = {name: int(getattr(frame, name)) for name in COLOUR_TAGS}
    if _is_rgb(frame.format):
        tags |= {"color_range": int(ColorRange.MPEG), "colorspace": _BT709}
    elif len(frame.format.components) < 3 and not tags["color_range"]:
        tags["color_range"] = int(ColorRange.JPEG)      # as FFmpeg reads grey samples
    return tags


def _decimal(value, unit):
    return f"{value / unit:.6f}".rstrip("0").rstrip(".")


def _chroma(form):
    return form.removeprefix("yuv")[:3]


def _reduced(plane, shape):
    """A plane of colour with fewer columns and rows, whose samples lie where decoders take them to
    be: on the first of two columns, between two rows."""
    if plane.shape[1] > shape[1]:
        plane = cv2.sepFilter2D(plane, -1, np.array([.25, .5, .25]), np.ones(1),
                                borderType=cv2.BORDER_REPLICATE)[:, ::2]
    if plane.shape[0] > shape[0]:
        plane = (plane[::2].astype(np.uint32) + plane[1::2] + 1) // 2
    return plane


def _is_rgb(layout):
    return layout.is_rgb or layout.has_palette


def _numbers(data, form):
    return struct.unpack(f"={form}", bytes(data)) if data is not None else ()


def _mastering(side):
    data = side.get(Type.MASTERING_DISPLAY_METADATA)
    if data is None:
        return ()
    *parts, primaries, luminance = _MASTERING.unpack(bytes(data)[:_MASTERING.size])
    if not (primaries and luminance):
        return ()
    values = [Fraction(*pair) if pair[1] else Fraction(0) for pair in zip(parts[::2], parts[1::2])]
    return (*(round(50000 * value) for value in values[:8]),
            *(round(10000 * value) for value in values[8:]))


def planes_of(frame):
    """Views (height, width) of the samples in the planes of a ``frame`` of Y'CbCr."""
    kind = np.dtype("u1" if frame.format.components[0].bits == 8 else "<u2")
    return [np.frombuffer(plane, kind).reshape(-1, plane.line_size // kind.itemsize)[
        :plane.height, :plane.width] for plane in frame.planes]


def transparent(frame):
    """Whether a ``frame`` with an alpha channel has a pixel that is not opaque."""
    return planes_of(frame.reformat(format="yuva444p"))[3].min() < 255
