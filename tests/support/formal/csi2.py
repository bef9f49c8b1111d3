"""Headers of CSI-2 with wrong bits, bursts of its lanes."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.camera.csi2.header import HeaderDecoder
from ncdc_hdl.camera.csi2.lane_aligner import LaneAligner

__all__ = ["Bursts", "Headers"]

# Bits of a header that each parity bit is the sum of, from the specification.
_PARITIES = ("0 1 2 4 5 7 10 11 13 16 20 21 22 23", "0 1 3 4 6 8 10 12 14 17 20 21 22 23",
             "0 2 3 5 6 9 11 12 15 18 20 21 22", "1 2 3 7 8 9 13 14 15 19 20 21 23",
             "4 5 6 7 8 9 16 17 18 19 20 22 23", "10 11 12 13 14 15 16 17 18 19 21 22 23")


class Headers(Wrapper):
    """``HeaderDecoder`` with any header, sent with its code, of which up to two bits are wrong.

    Asserts that a header without a wrong bit is handed on and not reported; that one wrong bit of
    the 32 is corrected and reported; that two of them, at any of the 496 pairs of positions, are
    reported as wrong, and not as corrected.
    """

    def __init__(self, kind=HeaderDecoder):
        self.dut = kind()
        super().__init__({"header": In(24), "one": In(5), "other": In(5), "wrong": In(2)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        self.design(m, dut)
        for signal in (self.header, self.one, self.other, self.wrong):
            constant(m, signal)
        given(m, ~ResetSignal())
        given(m, (self.wrong <= 2) & (self.one != self.other))
        parity = Cat(Cat(self.header[int(k)] for k in bits.split()).xor() for bits in _PARITIES)
        sent = Cat(self.header, parity, Const(0, 2))
        errors = (Mux(self.wrong >= 1, 1 << self.one, 0) | Mux(self.wrong == 2, 1 << self.other, 0))
        m.d.comb += dut.i.eq(sent ^ errors)
        clocks = Signal(range(dut.latency + 1))
        there = clocks == dut.latency
        m.d.sync += clocks.eq(clocks + ~there)
        always(m, ~there | (self.wrong != 0) | ~(dut.corrected | dut.wrong), "clean")
        always(m, ~there | (self.wrong != 1) | dut.corrected & ~dut.wrong, "one_is_corrected")
        always(m, ~there | (self.wrong == 2) | (Cat(dut.o.type, dut.o.channel, dut.o.count)
                                                == self.header), "handed_on")
        always(m, ~there | (self.wrong != 2) | dut.wrong & ~dut.corrected, "two_are_reported")
        for number, name in enumerate(("none", "one", "two")):
            reached(m, there & (self.wrong == number), f"{name}_wrong")
        return m


class Bursts(Wrapper):
    """``LaneAligner`` of two lanes that have bytes at any time while they are active.

    Between two bursts no lane is active for ``gap`` clocks. Asserts that the words of two bursts
    are apart; that each burst begins at most once, and is reported if it does not, at its end;
    that the lanes' delays do not change while words leave.
    """

    def __init__(self, gap=LaneAligner.min_gap):
        self.dut, self.gap = LaneAligner(2), gap
        super().__init__({"active": In(2), "valid": In(2), "data": In(16)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        given(m, ~ResetSignal())
        for k, lane in enumerate(dut.i):
            m.d.comb += [lane.active.eq(self.active[k]), lane.valid.eq(self.valid[k]),
                         lane.data.eq(self.data.word_select(k, 8))]
        given(m, (self.valid & ~self.active) == 0)
        # From the reset on lanes are inactive, and then between two bursts.
        active, quiet = self.active.any(), Signal(range(self.gap + 1))
        burst, begun = Signal(), Signal()
        with m.If(active):
            m.d.sync += quiet.eq(0)
        with m.Elif(quiet != self.gap):
            m.d.sync += quiet.eq(quiet + 1)
        given(m, ~active | burst | (quiet == self.gap))
        start, running, waits = (inner(fragment, "start"), inner(fragment, "running"),
                                 [inner(fragment, f"wait{k}") for k in range(2)])
        m.d.sync += [burst.eq(active), begun.eq(active & (begun | start))]
        over, before = burst & ~active, [Signal.like(wait, reset_less=True) for wait in waits]
        reports, ran = Signal(), Signal()
        m.d.sync += [reports.eq(over & ~begun), ran.eq((start | running) & active),
                     *(was.eq(wait) for was, wait in zip(before, waits))]
        always(m, ~start | ~running, "apart")
        always(m, ~start | ~begun, "once")
        always(m, dut.unaligned == reports, "reported")
        always(m, ~ran | (Cat(before) == Cat(waits)), "constant")
        reached(m, start & (waits[0] == 4), "skew")
        reached(m, dut.unaligned, "dropped")
        second = Signal()
        with m.If(over & begun):
            m.d.sync += second.eq(1)
        reached(m, second & start, "second_burst")
        return m
