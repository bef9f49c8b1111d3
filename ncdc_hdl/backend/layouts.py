"""Layouts of the streams between the parts of the back end."""

from amaranth.lib import data

from ncdc_hdl.lib.groups import grouped
from ncdc_model.geometry import MAX_SIZE, WINDOW

__all__ = ["pixel_layout", "request_layout", "window_layout"]


def request_layout(f_bits, lanes=1):
    """A window to fetch: origin in pixels, place in it as fractions of ``f_bits`` bits, whether
    the pixel is blank; ``lanes`` of them as :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"x0": range(MAX_SIZE), "y0": range(MAX_SIZE), "fx": f_bits, "fy": f_bits,
                    "blank": 1}, lanes)


def window_layout(f_bits, lanes=1):
    """A fetched window: samples row by row, parity of the origin, place in it, whether the pixel
    is blank; ``lanes`` of them as :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"samples": data.ArrayLayout(8, WINDOW * WINDOW), "odd_column": 1, "odd_row": 1,
                    "fx": f_bits, "fy": f_bits, "blank": 1}, lanes)


def pixel_layout(lanes=1):
    """A corrected pixel: 8-bit colours; ``lanes`` of them as
    :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"b": 8, "g": 8, "r": 8}, lanes)
