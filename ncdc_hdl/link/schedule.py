"""Which packets are sent, and in which order."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.link.layouts import JOB, PLAN, Template
from ncdc_model.interface.link_map import NUMBER_BITS

__all__ = ["Schedule"]


class Schedule(wiring.Component):
    """Makes a job of each packet of a frame, and of each that is to be sent again.

    A frame is a leader, ``plan.packets`` payload packets and a trailer. A range of the same numbers
    may be asked for again, of this frame or of the one before; it comes before the frame's next
    packet. What lies outside the frame's numbers is left out of the range.

    The place of a payload packet in memory is its number times the bytes of a packet: a sum that
    grows from packet to packet, and that a range begins with by ``NUMBER_BITS`` steps of doubling
    and adding.

    Timing: a job of a frame in every second clock, at most.

    Members
    -------
    plan : ``In(PLAN)``
        Constant while ``busy`` or ``resending``.
    base : ``In(32)``
        Of the frame that ``send`` begins, in bytes.
    send : ``In(1)``
        For one clock, not while ``busy``: begin a frame.
    abort : ``In(1)``
        For one clock: make no more jobs of the frame.
    resend, resend_first, resend_last, resend_before : ``In(1)``, ``In(24)``, ``In(24)``, ``In(1)``
        ``resend`` for one clock, not while ``resending``: the range, with both ends, of the frame
        begun last or of the one before.
    bank : ``Out(1)``
        Of the headers of the frame begun last.
    busy, resending : ``Out(1)``
        There are jobs to be made.
    resending_bank : ``Out(1)``
        That of the range.
    o : ``Out(stream.Signature(JOB))``
    """
    def __init__(self):
        super().__init__({
            "plan": In(PLAN), "base": In(ADDRESS_BITS), "send": In(1), "abort": In(1),
            "resend": In(1), "resend_first": In(NUMBER_BITS), "resend_last": In(NUMBER_BITS),
            "resend_before": In(1),
            "bank": Out(1), "busy": Out(1), "resending": Out(1),
            "resending_bank": Out(1),
            "o": Out(stream.Signature(JOB)),
        })

    def elaborate(self, platform):
        m = Module()
        plan, o = self.plan, self.o
        bases = Array(Signal(ADDRESS_BITS, name=f"base{k}") for k in range(2))      # of each bank
        # Place in the frame, 0 for the leader, and bytes of the frame before the packet there.
        place, offset = Signal(NUMBER_BITS + 1), Signal(ADDRESS_BITS)
        again_place, again_offset = Signal(NUMBER_BITS + 1), Signal(ADDRESS_BITS)
        again_last = Signal(NUMBER_BITS + 1)    # place of the range's last packet
        trailer = Signal(NUMBER_BITS + 1)       # its place
        free = Signal()                         # a job may be made
        m.d.sync += trailer.eq(plan.packets + 1)
        m.d.comb += free.eq(~o.valid)
        with m.If(o.ready):
            m.d.sync += o.valid.eq(0)
        with m.If(self.send):
            m.d.sync += [self.busy.eq(1), self.bank.eq(~self.bank), place.eq(0), offset.eq(0),
                         bases[~self.bank].eq(self.base)]
        # Packets that are sent again come first.
        now, before = Signal.like(place), Signal.like(offset)
        bank = Signal()
        m.d.comb += [now.eq(Mux(self.resending, again_place, place)),
                     before.eq(Mux(self.resending, again_offset, offset)),
                     bank.eq(Mux(self.resending, self.resending_bank, self.bank))]
        job = self._job(m, now, trailer)
        m.d.comb += [job.bank.eq(bank), job.address.eq(bases[bank] + before),
                     job.again.eq(self.resending)]
        grown = before + Mux((now != 0) & (now != trailer), plan.payload, 0)
        with m.FSM():
            with m.State("JOBS"):
                with m.If(self.resend):
                    m.d.sync += [self.resending.eq(1),
                                 self.resending_bank.eq(self.bank ^ self.resend_before)]
                    m.next = "RANGE"
                with m.If(free & self.resending):
                    m.d.sync += [o.valid.eq(1), o.p.eq(job), again_place.eq(now + 1),
                                 again_offset.eq(grown),
                                 self.resending.eq(now != again_last)]
                with m.Elif(free & self.busy & ~self.abort):
                    m.d.sync += [o.valid.eq(1), o.p.eq(job), place.eq(now + 1), offset.eq(grown),
                                 self.busy.eq(now != trailer)]
            with m.State("RANGE"):
                self._range(m, again_place, again_last, trailer)
                m.next = "CHECK"
            self._begin(m, again_place, again_last, again_offset)
        with m.If(self.abort):
            m.d.sync += self.busy.eq(0)
        return m

    def _begin(self, m, first, last, offset):
        """States that leave an empty range, and multiply for the others: bytes of the frame before
        the first packet."""
        factor = Signal(NUMBER_BITS)            # bits of the factor, from the highest on
        steps = Signal(range(NUMBER_BITS + 1))  # steps of the product to come
        with m.State("CHECK"):
            m.d.sync += [factor.eq(Mux(first == 0, 0, first - 1)), steps.eq(NUMBER_BITS),
                         offset.eq(0)]
            m.next = "PRODUCT"
            with m.If(first > last):
                m.d.sync += self.resending.eq(0)
                m.next = "JOBS"
        with m.State("PRODUCT"):
            m.d.sync += [offset.eq((offset << 1) + Mux(factor[-1], self.plan.payload, 0)),
                         factor.eq(factor << 1), steps.eq(steps - 1)]
            with m.If(steps == 1):
                m.next = "JOBS"

    def _range(self, m, first, last, trailer):
        """Places of the range, as far as the frame has them."""
        numbers = [self.resend_first, self.resend_last]
        leader = self.plan.first - 1            # its number; -1 where packets are counted from 0
        places = [Signal(signed(NUMBER_BITS + 2), name=f"place_of_{name}")
                  for name in ("first", "last")]
        m.d.comb += [place.eq(number - leader) for place, number in zip(places, numbers)]
        m.d.sync += [first.eq(Mux(places[0] < 0, 0, places[0])),
                     last.eq(Mux(places[1] > trailer, trailer, places[1]))]
        # Before the leader there is none.
        with m.If(places[1] < 0):
            m.d.sync += [first.eq(1), last.eq(0)]

    def _job(self, m, place, trailer):
        """The packet at a place, but for its bank and address."""
        plan, job = self.plan, Signal(JOB)
        m.d.comb += [job.number.eq(plan.first - 1 + place), job.template.eq(Template.PAYLOAD),
                     job.bytes.eq(plan.payload)]
        with m.If(place == 0):
            m.d.comb += [job.template.eq(Template.LEADER), job.bytes.eq(0)]
        with m.Elif(place == trailer):
            m.d.comb += [job.template.eq(Template.TRAILER), job.bytes.eq(0)]
        with m.Elif(place == plan.packets):
            m.d.comb += [job.template.eq(Template.LAST), job.bytes.eq(plan.last)]
        return job
