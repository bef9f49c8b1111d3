"""Gains of the colours: the product of a value with a gain, and the gains of raw samples."""

from amaranth import *
from amaranth.lib import data

from ncdc_hdl.lib.pipeline import register
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.white_balance import GAIN_BITS, GAIN_F_BITS

__all__ = ["BALANCE", "GAINED_LATENCY", "NO_BALANCE", "gain_of", "gained"]

BALANCE = data.StructLayout({"gains": data.ArrayLayout(GAIN_BITS, 3), "phase": 3})
"""Gains of red, green and blue raw samples in 256ths, and which samples are red: as the register
``BAYER_PHASE`` has it. A grey sensor's samples have the gain of green."""

NO_BALANCE = {"gains": list(NO_RAW_GAINS), "phase": 0}
"""A :data:`BALANCE` that changes no sample."""

GAINED_LATENCY = 3
"""Clocks of :func:`gained`: two registers of a multiplier, the limited value."""


def gain_of(balance, red_column, red_row):
    """The gain of a raw sample, by whether its column and its row have red samples."""
    red, green, blue = (balance.gains[k] for k in range(3))
    return Mux((red_column ^ red_row) | balance.phase[2], green, Mux(red_column, red, blue))


def gained(m, name, value, gain, most):
    """min(``most``, (``gain`` ``value`` + 128) >> 8), as wide as ``value``, GAINED_LATENCY later.

    ``value`` and ``gain`` come from registers. ``most`` is constant.
    """
    product = register(m, f"{name}_p1", register(m, f"{name}_p0", value * gain))
    # Adding a half carries exactly if the highest bit dropped is set.
    whole = Signal(len(product) - GAIN_F_BITS, name=f"{name}_whole")
    m.d.comb += whole.eq(product[GAIN_F_BITS:] + product[GAIN_F_BITS - 1])
    return register(m, name, Mux(whole > most, most, whole[:len(value)]), len(value))
