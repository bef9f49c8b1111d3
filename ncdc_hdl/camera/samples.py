"""The stream of samples that each kind of camera gives."""

from amaranth import Cat, Const
from amaranth.lib import data, wiring
from amaranth.lib.wiring import Out

from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["FRAME_GAP", "samples", "upper"]

FRAME_GAP = 3
"""Clocks between two frames: the last samples of a frame may leave two entries, then its end, and
the beginning of the next one comes before its first samples."""


def samples(count):
    """Signature of a stream of frames with up to ``count`` samples per clock, without ``ready``.

    A source cannot be held up: a consumer counts what it cannot take. With more than one sample
    per clock at least :data:`FRAME_GAP` clocks without samples lie between two frames.

    - ``valid``: one bit per sample. A row begins with sample 0. Only the last clock of a row may
      have fewer than ``count`` samples, and then has the lower ones.
    - ``sample``: each of 12 bits; a shorter one is in the upper bits, and the others are zero.
    - ``first``: high with the first samples of a frame.
    - ``last``: high with the last samples of a row. A row that the source lost in part may lack it.
    - ``end``: high for a clock, with the last samples of a frame or after them. A frame without
      one before the next ``first`` is bad.
    - ``bad``: high with ``end`` if the source found a fault in the frame.
    """
    return wiring.Signature({
        "valid": Out(count), "sample": Out(data.ArrayLayout(SAMPLE_BITS, count)),
        "first": Out(1), "last": Out(1), "end": Out(1), "bad": Out(1)})


def upper(value):
    """``value`` of 8 to 16 bits as a sample: its upper bits, or with zeros below."""
    if len(value) > SAMPLE_BITS:
        return value[-SAMPLE_BITS:]
    return Cat(Const(0, SAMPLE_BITS - len(value)), value)
