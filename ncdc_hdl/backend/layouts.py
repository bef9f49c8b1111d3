"""Layouts of the streams between the parts of the back end."""

from amaranth.lib import data

from ncdc_hdl.lib.groups import grouped
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.interpolation import FAST

__all__ = ["edge_layout", "edges", "pixel_layout", "request_layout", "window_layout"]


def edge_layout(interpolation):
    """Number of columns, or rows, of a window outside the frame, and whether they are after
    its last one (else before its first one)."""
    return data.StructLayout({"missing": range(interpolation.margin + 1), "after": 1})


def edges(interpolation):
    """Fields ``edge_x`` and ``edge_y`` of a window that may leave the frame; else none."""
    if not interpolation.margin:
        return {}
    return {"edge_x": edge_layout(interpolation), "edge_y": edge_layout(interpolation)}


def request_layout(f_bits, lanes=1, interpolation=FAST):
    """A window to fetch: the sample of its first point, the pixel's position relative to it as
    fractions of ``f_bits`` bits, whether the pixel is blank, and :func:`edges`; ``lanes`` of them
    as :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"x0": range(MAX_SIZE), "y0": range(MAX_SIZE), "fx": f_bits, "fy": f_bits,
                    "blank": 1, **edges(interpolation)}, lanes)


def window_layout(f_bits, lanes=1, interpolation=FAST):
    """A fetched window: the samples that ``interpolation`` uses, row by row, parities of the
    sample of the first point, the pixel's position, whether the pixel is blank; ``lanes`` of
    them as :func:`ncdc_hdl.lib.groups.grouped`.

    Windows with a margin are ``flipped`` so that their even columns are even ones of the frame, and
    their even rows of the parity with which the sample in row and column ``margin`` is green: with
    ``x`` the samples of each row come right to left, with ``y`` the rows last one first.
    """
    samples = data.ArrayLayout(8, len(interpolation.samples))
    parities = ({"flipped": data.StructLayout({"x": 1, "y": 1})} if interpolation.margin else
                {"odd_column": 1, "odd_row": 1})
    return grouped({"samples": samples, **parities, "fx": f_bits, "fy": f_bits, "blank": 1}, lanes)


def pixel_layout(lanes=1):
    """A corrected pixel: 8-bit colours; ``lanes`` of them as
    :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"b": 8, "g": 8, "r": 8}, lanes)
