"""Layouts of the streams between the parts of the back end."""

from amaranth.lib import data

from ncdc_model.geometry import MAX_SIZE, WINDOW

__all__ = ["pixel_layout", "request_layout", "window_layout"]

_FLAGS = {"blank": 1, "first": 1, "last": 1}


def request_layout(f_bits):
    """A window to fetch: origin in pixels, place in it as fractions of ``f_bits`` bits, flags."""
    return data.StructLayout({"x0": range(MAX_SIZE), "y0": range(MAX_SIZE),
                              "fx": f_bits, "fy": f_bits, **_FLAGS})


def window_layout(f_bits):
    """A fetched window: samples row by row, parity of the origin, place in it, flags."""
    return data.StructLayout({"samples": data.ArrayLayout(8, WINDOW * WINDOW),
                              "odd_column": 1, "odd_row": 1, "fx": f_bits, "fy": f_bits, **_FLAGS})


def pixel_layout():
    """A corrected pixel: 8-bit colours, and whether it is the frame's first or last."""
    return data.StructLayout({"b": 8, "g": 8, "r": 8, "first": 1, "last": 1})
