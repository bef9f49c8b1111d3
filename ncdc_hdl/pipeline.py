"""Registers of free-running pipelines."""

from amaranth import *

__all__ = ["delay", "register"]


def register(m, name, value, shape=None, reset_less=True):
    """``value`` one clock later, of its own shape unless ``shape`` is given.

    Data needs no reset: nothing reads it before it is written.
    """
    r = Signal(shape or value.shape(), name=name, reset_less=reset_less)
    m.d.sync += r.eq(value)
    return r


def delay(m, value, clocks, name, reset_less=True):
    """``value`` as it was ``clocks`` clocks ago, through a chain of registers."""
    for k in range(clocks):
        value = register(m, f"{name}_d{k}", value, reset_less=reset_less)
    return value
