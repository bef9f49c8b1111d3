"""The frame store: one writer, readers, and no buffer that two of them have."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.camera.frame_store import FrameStore

__all__ = ["Store"]


class Store(Wrapper):
    """``FrameStore`` with any writer and any readers, reset at any time.

    Asserts that the writer's buffer is no reader's and not the newest one's; that what a reader
    holds, and the newest, is a frame that was ended as good and not begun anew; that there is a
    buffer for the writer whenever it wants one. What the first reader has claimed while it was
    written may be the writer's, and bad, but is not begun anew either.
    """

    LIMIT = 3

    def __init__(self, readers=2, kind=FrameStore, buffers_missing=0):
        self.dut = kind(readers)
        self.dut.buffers -= buffers_missing
        super().__init__({"begin": In(1), "end": In(1), "good": In(1), "limit": In(2),
                          "follow": In(1),
                          "claim": In(readers), "release": In(readers)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        fragment = self.design(m, dut)
        constant(m, self.limit)
        m.d.comb += [dut.begins.eq(self.begin), dut.ends.eq(self.end), dut.good.eq(self.good),
                     dut.limit.eq(self.limit), dut.follow.eq(self.follow)]
        for k, one in enumerate(dut.readers):
            m.d.comb += [one.claim.eq(self.claim[k]), one.release.eq(self.release[k])]

        whole = Array(Signal(name=f"whole{k}") for k in range(dut.buffers))
        with m.If(self.begin & ~dut.busy):
            m.d.sync += whole[inner(fragment, "first")].eq(0)
        with m.If(self.end & dut.busy):
            m.d.sync += whole[dut.buffer].eq(self.good)
        # What the first reader holds it has followed from the writer.
        followed = Signal()
        with m.If(self.claim[0]):
            m.d.sync += followed.eq(self.follow)
        first = inner(fragment, "first")
        always(m, ~dut.busy | ~dut.some | (dut.buffer != dut.newest), "newest_is_held")
        always(m, ~dut.some | whole[dut.newest], "newest_is_whole")
        always(m, dut.busy | inner(fragment, "free").any(), "space")
        always(m, dut.buffer < dut.buffers, "buffer")
        for k, one in enumerate(dut.readers):
            follows = followed if k == 0 else 0
            always(m, ~(self.begin & ~dut.busy) | ~one.held | (first != one.buffer),
                   f"unchanged{k}")
            always(m, ~dut.busy | ~one.held | (dut.buffer != one.buffer) | follows, f"alone{k}")
            always(m, ~one.held | whole[one.buffer] | follows, f"whole{k}")
            always(m, ~(one.held & one.lost), f"lost{k}")
            always(m, ~one.held | (one.buffer < dut.buffers), f"index{k}")
        always(m, ~dut.some | (dut.newest < dut.buffers), "index")
        given(m, ~self.begin | ~self.end)
        others = reduce(or_, (one.held & (one.buffer != dut.newest) for one in dut.readers))
        reached(m, dut.busy & others & dut.readers[0].held & dut.readers[1].held
                & (dut.readers[0].buffer != dut.readers[1].buffer), "all_in_use")
        reached(m, followed & dut.readers[0].held & dut.busy
                & (dut.readers[0].buffer != dut.buffer), "followed")
        reached(m, dut.readers[0].lost & dut.readers[1].held, "lost")
        return m
