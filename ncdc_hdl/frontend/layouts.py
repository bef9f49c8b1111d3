"""Layouts that the front end shares with its neighbours."""

from amaranth import *
from amaranth.lib import data

from ncdc_hdl.lib.groups import grouped
from ncdc_hdl.neural.layouts import hidden_layout, output_layout
from ncdc_model.geometry import MAX_SIZE, SCAN

__all__ = ["SIZE", "SPANS", "coordinate_layout", "network_layout", "scan_layout"]

SIZE = range(MAX_SIZE + 1)                       # of a width, a height, the end of a span
SPANS = data.StructLayout({"start0": SIZE, "stop0": SIZE, "start1": SIZE, "stop1": SIZE})


def scan_layout():
    """The parameters of a scan.

    ``width`` and ``height`` are the corrected picture's in pixels, ``strip`` the columns of a strip
    (0: the picture is one strip). Origin and step of both coordinates are raw in Q1.31.
    """
    return data.StructLayout({
        "width": SIZE, "height": SIZE, "strip": SIZE,
        "origin_x": signed(SCAN.width), "step_x": signed(SCAN.width),
        "origin_y": signed(SCAN.width), "step_y": signed(SCAN.width),
    })


def network_layout(hidden_neurons, formats):
    """Weights and biases of the whole network, raw in ``formats``."""
    return data.StructLayout({"hidden": hidden_layout(hidden_neurons, formats),
                              "output": output_layout(hidden_neurons, formats)})


def coordinate_layout(formats, lanes=1):
    """A back-map coordinate: x', y' in pixels, whether the pixel has no source (``blank``);
    ``lanes`` of them as :func:`ncdc_hdl.lib.groups.grouped`."""
    return grouped({"x": signed(formats.coordinate.width), "y": signed(formats.coordinate.width),
                    "blank": 1}, lanes)
