"""Layouts that the front end shares with its neighbours."""

from amaranth import *
from amaranth.lib import data

from ncdc_hdl.neural.layouts import hidden_layout, output_layout
from ncdc_model.geometry import MAX_SIZE, SCAN

__all__ = ["SIZE", "SPANS", "coordinate_layout", "network_layout", "scan_layout"]

SIZE = range(MAX_SIZE + 1)                       # of a width, a height, the end of a span
SPANS = data.StructLayout({"start0": SIZE, "stop0": SIZE, "start1": SIZE, "stop1": SIZE})


def scan_layout():
    """What the scan needs to know: size in pixels, origin and step in Q1.31."""
    return data.StructLayout({
        "width": SIZE, "height": SIZE,
        "origin_x": signed(SCAN.width), "step_x": signed(SCAN.width),
        "origin_y": signed(SCAN.width), "step_y": signed(SCAN.width),
    })


def network_layout(hidden_neurons, formats):
    """Weights and biases of the whole network, raw in ``formats``."""
    return data.StructLayout({"hidden": hidden_layout(hidden_neurons, formats),
                              "output": output_layout(hidden_neurons, formats)})


def coordinate_layout(formats):
    """A back-map coordinate: x', y' in pixels, whether the pixel has no source (``blank``), and
    whether it is the ``first`` or the ``last`` of the frame."""
    return data.StructLayout({
        "x": signed(formats.coordinate.width), "y": signed(formats.coordinate.width),
        "blank": 1, "first": 1, "last": 1,
    })
