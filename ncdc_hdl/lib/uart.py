"""Bytes on an asynchronous serial line: eight bits, no parity, one stop bit."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

__all__ = ["UartReceiver", "UartTransmitter"]

_BITS = 10      # start, eight of data, stop


class UartReceiver(wiring.Component):
    """Receives bytes.

    The line is sampled in the middle of each bit, counted from the edge of the start bit. A
    start bit that is over by its middle, and a byte without a stop bit, count as noise.

    Parameters
    ----------
    divisor : int
        Clocks of a bit, at least 8.

    Members
    -------
    line : ``In(1)``
        Asynchronous.
    valid, byte : ``Out(1)``, ``Out(8)``
        A byte has come; for one clock.

    Raises
    ------
    ValueError
        If ``divisor`` is below 8.
    """

    def __init__(self, divisor):
        if divisor < 8:
            raise ValueError(f"a bit has {divisor} clocks, at least 8 are needed")
        self.divisor = divisor
        super().__init__({"line": In(1), "valid": Out(1), "byte": Out(8)})

    def elaborate(self, platform):
        m = Module()
        line = Signal(init=1)
        m.submodules.line = FFSynchronizer(self.line, line, init=1)
        left = Signal(range(self.divisor))      # clocks to the middle of the next bit
        bits = Signal(range(_BITS + 1))         # bits that are still to come; 0: the line is idle
        broken = Signal()                       # there was no stop bit: the line must be idle first
        m.d.sync += self.valid.eq(0)
        with m.If(bits == 0):
            with m.If(~line):
                m.d.sync += [bits.eq(_BITS), left.eq(self.divisor // 2)]
        with m.Elif(left != 0):
            m.d.sync += left.eq(left - 1)
        with m.Else():
            m.d.sync += [left.eq(self.divisor - 1), bits.eq(bits - 1)]
            with m.If((bits == _BITS) & line):      # no start bit
                m.d.sync += bits.eq(0)
            m.d.sync += self.byte.eq(Cat(self.byte[1:], line))
        # The stop bit: eight bits are in, and the line is high in its middle.
        with m.If((bits == 1) & (left == 0)):
            m.d.sync += [self.valid.eq(line & ~broken), broken.eq(~line), left.eq(0),
                         bits.eq(~line), self.byte.eq(self.byte)]
        return m


class UartTransmitter(wiring.Component):
    """Sends bytes.

    Parameters
    ----------
    divisor : int
        Clocks of a bit.

    Members
    -------
    i : ``In(stream.Signature(8))``
    line : ``Out(1)``
        From a register.
    """

    def __init__(self, divisor):
        self.divisor = divisor
        super().__init__({"i": In(stream.Signature(8)), "line": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        left = Signal(range(self.divisor))
        bits = Signal(range(_BITS + 1))         # bits still to be sent, with this one
        shift = Signal(_BITS - 1)
        m.d.comb += self.i.ready.eq(bits == 0)
        with m.If(self.i.ready):
            m.d.sync += self.line.eq(1)
            with m.If(self.i.valid):
                m.d.sync += [self.line.eq(0), shift.eq(Cat(self.i.payload, 1)), bits.eq(_BITS),
                             left.eq(self.divisor - 1)]
        with m.Elif(left != 0):
            m.d.sync += left.eq(left - 1)
        with m.Else():
            m.d.sync += [left.eq(self.divisor - 1), bits.eq(bits - 1), self.line.eq(shift[0]),
                         shift.eq(Cat(shift[1:], 1))]
        return m
