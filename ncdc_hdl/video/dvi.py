"""A picture as the bits of a DVI link."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.video.scan_out import PICTURE
from ncdc_hdl.video.tmds import TmdsEncoder

__all__ = ["CLOCK_WORD", "Dvi", "Serialiser"]

CLOCK_WORD = 0b0000011111
"""The word of the clock lane: high in the first half of a pixel."""


class Serialiser(wiring.Component):
    """Sends words of ten bits, two bits a clock of ``shift``, the lowest bits first.

    ``shift`` has five clocks to one of ``pixel``, from the same source. A bit that toggles with
    each pixel shows, through two flip-flops, once after a reset, when words are constant. From
    then on a counter tracks that time, so that the two clocks may have any constant phase.

    Parameters
    ----------
    lanes : int

    Members
    -------
    words : ``In(10).array(lanes)``
        In the domain ``pixel``.
    pairs : ``Out(2).array(lanes)``
        In the domain ``shift``; bit 0 is sent first.
    """

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({"words": In(10).array(lanes), "pairs": Out(2).array(lanes)})

    def elaborate(self, platform):
        m = Module()
        turns, seen, before = Signal(), Signal(), Signal()
        m.d.pixel += turns.eq(~turns)
        m.submodules.turns = FFSynchronizer(turns, seen, o_domain="shift")
        m.d.shift += before.eq(seen)
        known = Signal()                # the counter is synchronised to the words
        count = Signal(range(5))
        load = Signal()
        m.d.comb += load.eq(Mux(known, count == 4, seen != before))
        with m.If(load):
            m.d.shift += [count.eq(0), known.eq(1)]
        with m.Else():
            m.d.shift += count.eq(count + 1)
        for lane in range(self.lanes):
            bits = Signal(10, name=f"bits{lane}")
            m.d.shift += bits.eq(Mux(load, self.words[lane], bits[2:]))
            m.d.comb += self.pairs[lane].eq(bits[:2])
        return m


class Dvi(wiring.Component):
    """The four lanes of a DVI link.

    Timing: the words follow ``picture`` after the encoders' latency, then the serialiser's.

    Members
    -------
    picture : ``In(PICTURE)``
        In the domain ``pixel``.
    pairs : ``Out(2).array(4)``
        Blue with the sync signals, green, red, clock, in the domain ``shift``; bit 0 first.
    """

    def __init__(self):
        super().__init__({"picture": In(PICTURE), "pairs": Out(2).array(4)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.serialiser = serialiser = Serialiser(4)
        picture = self.picture
        for lane, name in enumerate("bgr"):
            m.submodules[name] = encoder = TmdsEncoder()
            m.d.comb += [encoder.colour.eq(picture[name]), encoder.visible.eq(picture.visible),
                         serialiser.words[lane].eq(encoder.word)]
            if name == "b":
                m.d.comb += encoder.control.eq(Cat(picture.hsync, picture.vsync))
        m.d.comb += [serialiser.words[3].eq(CLOCK_WORD),
                     *(self.pairs[k].eq(serialiser.pairs[k]) for k in range(4))]
        return m
