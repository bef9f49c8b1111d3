"""Starts the corrector for raw frames of one store, with targets in another."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.camera.frame_store import FRAME
from ncdc_hdl.camera.layouts import RUN, SIZE_BITS

__all__ = ["RunControl"]

class RunControl(wiring.Component):
    """Corrects every new raw frame while ``run`` is high, or the newest one if it is too slow.

    Without ``follow`` it claims a raw frame when that is complete. With ``follow`` it claims the
    one that has just begun. The corrected frame is over when the raw frame has ended as well,
    which shows whether it was good. A frame that began while the corrector was busy is skipped.

    A corrected frame is good if the corrector completed it without a fault, and its raw frame
    was good and held to the end.

    Timing: the corrector starts ``latency`` clocks after the raw frame's end, or beginning.

    Members
    -------
    run, follow : ``In(1)``
    raw_pitch, raw_width, raw_height : ``In(SIZE_BITS)``
        Sizes of raw frames.
    raw_bytes, corrected_bytes : ``In(32)``
        Bytes of the area of each frame.

    came, begun : ``In(1)``
        From the raw store: its newest frame has changed; a frame has begun.
    ended, good : ``In(1)``
        The writer of raw frames ends one.
    claim, claim_follow, release : ``Out(1)``
        To the raw store, as its first reader.
    held : ``In(1)``
        From the raw store: this reader holds its buffer.
    raw_base, about : ``In(32)``, ``In(FRAME)``
        Base address of the claimed buffer; the store's data on its frame, one clock later.

    target_begins, target_ends, target_good : ``Out(1)``
        To the store of corrected frames, as its writer.
    target_base : ``In(32)``
        Base address of its writer's buffer.

    corrector : ``Out(RUN)``
    number : ``Out(32)``
        Number of the raw frame from which the last complete corrected frame was made.
    begun_count, bad_count, skipped : ``Out(32)``
        Corrected frames begun, and ended as bad; raw frames that were not corrected while ``run``
        was high.
    """

    latency = 4

    def __init__(self):
        super().__init__({
            "run": In(1), "follow": In(1), "raw_pitch": In(SIZE_BITS),
            "raw_width": In(SIZE_BITS), "raw_height": In(SIZE_BITS),
            "raw_bytes": In(ADDRESS_BITS), "corrected_bytes": In(ADDRESS_BITS),
            "came": In(1), "begun": In(1), "ended": In(1), "good": In(1),
            "claim": Out(1), "claim_follow": Out(1), "release": Out(1), "held": In(1),
            "raw_base": In(ADDRESS_BITS), "about": In(FRAME),
            "target_begins": Out(1), "target_ends": Out(1), "target_good": Out(1),
            "target_base": In(ADDRESS_BITS),
            "corrector": Out(RUN),
            "number": Out(32), "begun_count": Out(32), "bad_count": Out(32), "skipped": Out(32),
        })

    def elaborate(self, platform):
        m = Module()
        fresh = Signal()            # the newest raw frame has not been claimed
        bad = Signal()              # something was wrong with this frame
        written = Signal()          # its raw frame is complete
        corrected = Signal()        # the corrector has ended it
        waits = Signal()            # no frame is under way
        ready = Signal()            # one may begin
        new = Signal()              # a raw frame is there
        corrector, buffers = self.corrector, self.corrector.buffers
        m.d.comb += [
            ready.eq(waits & self.run & corrector.idle),
            new.eq(Mux(self.follow, self.begun, fresh | self.came)),
            self.claim.eq(ready & new), self.claim_follow.eq(self.follow),
            corrector.active.eq(self.run | ~waits), corrector.assigned.eq(~waits),
        ]
        self._count(m, fresh, ready)
        with m.If(self.claim):
            m.d.sync += fresh.eq(0)
        with m.Elif(self.came):
            m.d.sync += fresh.eq(1)
        with m.If(self.ended):
            m.d.sync += written.eq(1)
            with m.If(~written):
                m.d.sync += bad.eq(bad | ~self.good)
        with m.If(corrector.fault | ~self.held):
            m.d.sync += bad.eq(1)
        with m.FSM():
            with m.State("WAIT"):
                m.d.comb += waits.eq(1)
                m.d.sync += [bad.eq(0), corrected.eq(0), written.eq(~self.follow)]
                with m.If(self.claim):
                    m.d.sync += buffers.follow.eq(self.follow)
                    m.next = "CLAIMED"
            with m.State("CLAIMED"):
                m.d.sync += [buffers.pitch.eq(self.raw_pitch), buffers.width.eq(self.raw_width),
                             buffers.height.eq(self.raw_height),
                             buffers.source.eq(self.raw_base),
                             buffers.source_limit.eq(self.raw_base + self.raw_bytes)]
                m.next = "BEGIN"
            with m.State("BEGIN"):
                m.d.comb += self.target_begins.eq(1)
                m.next = "TARGET"
            with m.State("TARGET"):
                m.d.sync += [buffers.target.eq(self.target_base),
                             buffers.target_limit.eq(self.target_base + self.corrected_bytes)]
                m.next = "START"
            with m.State("START"):
                m.d.comb += corrector.start.eq(1)
                m.next = "CORRECT"
            with m.State("CORRECT"):
                with m.If(corrector.over):
                    m.d.sync += corrected.eq(1)
                    with m.If(corrector.cut):
                        m.d.sync += bad.eq(1)
                with m.If(corrected & written):
                    m.d.comb += [self.release.eq(1), self.target_ends.eq(1),
                                 self.target_good.eq(~bad)]
                    m.next = "WAIT"
        return m

    def _count(self, m, fresh, ready):
        """Count frames begun, bad and skipped; store the number of the last complete one."""
        number = Signal(32)             # number of the raw frame that is corrected
        with m.If(self.target_begins):
            m.d.sync += number.eq(self.about.number)
        with m.If(self.target_ends):
            m.d.sync += self.number.eq(number)
        # A newer frame replaces the one that waits; with `follow` none waits.
        missed = Mux(self.follow, self.begun & ~ready, self.came & fresh)
        m.d.sync += self.skipped.eq(self.skipped + (self.run & missed))
        m.d.sync += [self.begun_count.eq(self.begun_count + self.target_begins),
                     self.bad_count.eq(self.bad_count + (self.target_ends & ~self.target_good))]
