"""Bytes of the MAC to the nibbles of any of the three interfaces, and back.

Both blocks are of one clock domain, the interface's own, and know nothing of pins.
"""

from liteeth.common import eth_interpacket_gap, eth_phy_description
from litex.gen import LiteXModule
from litex.soc.interconnect import stream
from migen import Cat, If, Mux, Signal

__all__ = ["SPEEDS", "Receiver", "Sender"]

SPEEDS = (10, 100, 1000)
"""Mbit/s, in the order in which RGMII's status and our registers count them."""

_START = 0xD5       # the byte after the preamble


class Sender(LiteXModule):
    """Frames to nibbles at the line's speed, with the interpacket gap of IEEE 802.3.

    A step is the time of a byte (``whole``) or of a nibble, the low one first; it takes ``clocks``
    + 1 clocks. Twelve bytes' times after a frame are idle: LiteEth's own gap counts clocks, which
    are bytes at 1000 Mbit/s only. On an underrun the frame continues with its error signal set
    until the next byte comes. The receiver drops the frame, and takes no part of it for another.

    Attributes
    ----------
    sink : stream.Endpoint
        Bytes from preamble to check sequence.
    whole : Signal
        A byte a step, both nibbles at once.
    clocks : Signal
        Clocks of a step, less one.
    low, high : Signal
        Nibbles of the clock's two halves; the same where a step is a nibble.
    enable, error : Signal
    clock : Signal
        Levels of the line's clock in the two halves of this clock, bit 0 first.
    """

    def __init__(self):
        self.sink = sink = stream.Endpoint(eth_phy_description(8))
        self.whole = Signal(reset=1)
        self.clocks = Signal(6)
        self.low, self.high = Signal(4), Signal(4)
        self.enable, self.error = Signal(), Signal()
        self.clock = Signal(2)

        elapsed = Signal(6)         # clocks of this step that are over
        step_ends = Signal()        # this step ends with this clock
        second = Signal()           # it is the high nibble's
        rest = Signal(4)            # that nibble
        inside = Signal()           # the frame's last byte was not taken
        gap = Signal(max=eth_interpacket_gap + 1)       # bytes' times that stay idle
        free = Signal(reset=1)      # none does: gap == 0
        # A product would be cut to six bits in the Verilog, and in there alone.
        twice = Cat(0, elapsed)
        byte_ends = Signal()
        self.comb += [
            byte_ends.eq(step_ends & (self.whole | second)),
            sink.ready.eq(byte_ends & free),
            self.clock.eq(Cat(twice <= self.clocks, twice < self.clocks)),
        ]
        # What ends, and whether a byte may come, are registers, so that ``ready`` comes early in
        # its clock.
        self.sync += [
            If(step_ends,
               elapsed.eq(0),
               step_ends.eq(self.clocks == 0),
               second.eq(~self.whole & ~second),
               self.low.eq(rest),
               self.high.eq(rest)
               ).Else(
                   elapsed.eq(elapsed + 1),
                   step_ends.eq(elapsed + 1 >= self.clocks)),
            If(byte_ends,
               self.low.eq(sink.data[:4]),
               self.high.eq(Mux(self.whole, sink.data[4:], sink.data[:4])),
               rest.eq(sink.data[4:]),
               self.error.eq(0),
               If(~free,
                  gap.eq(gap - 1),
                  free.eq(gap == 1),
                  self.enable.eq(0)
                  ).Elif(sink.valid,
                         self.enable.eq(1),
                         inside.eq(~sink.last),
                         If(sink.last, gap.eq(eth_interpacket_gap), free.eq(0))
                         ).Else(self.enable.eq(inside), self.error.eq(inside))),
        ]


class Receiver(LiteXModule):
    """Nibbles to frames.

    Where a clock brings one nibble, bytes are counted from the end of the preamble, which may have
    lost nibbles on its way. A byte is passed on with the next one or the end, so that the last one
    is known. An error anywhere in a frame is reported with its last byte. The sink is always ready.

    Attributes
    ----------
    source : stream.Endpoint
        Bytes from preamble to check sequence.
    whole : Signal
        A byte a clock, not a nibble.
    low, high : Signal
        Nibbles of the clock's two halves; ``high`` counts if ``whole``.
    valid, error : Signal
    """

    def __init__(self):
        self.source = source = stream.Endpoint(eth_phy_description(8))
        self.whole = Signal(reset=1)
        self.low, self.high = Signal(4), Signal(4)
        self.valid, self.error = Signal(), Signal()

        before = Signal(4)          # the nibble before
        there, wrong = Signal(), Signal()       # valid, error a clock ago
        byte = Signal(8)            # the byte of that clock, if it ends one
        starting = Signal()         # it is the one after the preamble
        second = Signal()           # the next nibble is a byte's high one
        started = Signal()          # the preamble is over
        now, whole_byte, start = Signal(8), Signal(), Signal()
        held, holds, bad = Signal(8), Signal(), Signal()
        self.comb += [
            now.eq(Mux(self.whole, Cat(self.low, self.high), Cat(before, self.low))),
            start.eq(~started & starting),
            whole_byte.eq(there & (self.whole | second | start)),
        ]
        self.sync += [
            source.valid.eq(0),
            source.last.eq(0),
            source.last_be.eq(0),
            source.error.eq(0),
            before.eq(Mux(self.valid, self.low, 0)),
            there.eq(self.valid),
            wrong.eq(self.error),
            byte.eq(now),
            starting.eq(now == _START),
            If(there,
               second.eq(~whole_byte),
               started.eq(started | start),
               bad.eq(bad | wrong)
               ).Else(second.eq(0), started.eq(0), bad.eq(0), holds.eq(0)),
            If(whole_byte, held.eq(byte), holds.eq(1)),
            If(holds & (whole_byte | ~there),
               source.valid.eq(1),
               source.data.eq(held),
               source.last.eq(~there),
               source.last_be.eq(~there),        # without it LiteEth checks no sequence
               source.error.eq(~there & bad)),
        ]
