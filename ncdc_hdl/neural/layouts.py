"""Layouts between the layers of the network and the front end."""

from amaranth import *
from amaranth.lib import data
from amaranth.utils import ceil_log2

__all__ = ["hidden_layout", "output_layout", "pixel_layout"]


def hidden_layout(hidden_neurons, formats):
    """Weights and biases of the hidden neurons, raw in ``formats``."""
    return data.ArrayLayout(data.StructLayout({
        "weights": data.ArrayLayout(signed(formats.hidden_weight.width), 2),
        "bias": signed(formats.hidden_bias.width)}), hidden_neurons)


def output_layout(hidden_neurons, formats, in_memory=False):
    """Weights, biases and skip weights, if any, of the two output neurons, raw in ``formats``.

    No weights if they are ``in_memory``, see :class:`ncdc_hdl.neural.banks.WeightBanks`.
    """
    members = {"bias": signed(formats.output_bias.width)}
    if not in_memory:
        members |= {"weights": data.ArrayLayout(signed(formats.output_weight.width),
                                                hidden_neurons)}
    if formats.skip_weight is not None:
        members |= {"skip": data.ArrayLayout(signed(formats.skip_weight.width), 2)}
    return data.ArrayLayout(data.StructLayout(members), 2)


def pixel_layout(formats, lanes=1):
    """A scanned pixel: its normalised coordinates ``x``, ``y``, and the difference of the next one
    in its lane, ``lanes`` pixels further.

    Within a row x grows by ``x_step + x_carry``. If ``new_row``, y grows by ``y_step + y_carry``
    and x is again that of the row's first pixel; if ``new_strip``, both are new. The steps are
    constant in a frame, the carries come from the fraction dropped by the coordinates' rounding.
    """
    number = signed(formats.input.width)
    # Groups of a narrow picture are more than half the range apart.
    stride = signed(formats.input.width + ceil_log2(lanes))
    return data.StructLayout({"x": number, "y": number, "x_step": stride, "y_step": number,
                              "x_carry": 1, "y_carry": 1, "new_row": 1, "new_strip": 1})
