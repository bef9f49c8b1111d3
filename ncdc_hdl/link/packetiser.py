"""Frames in memory, sent as packets with headers that the host has written."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import Agent, ReadHost
from ncdc_hdl.link.joiner import Joiner
from ncdc_hdl.link.layouts import BEAT, JOB
from ncdc_hdl.link.payload import PayloadReader
from ncdc_hdl.link.schedule import Schedule
from ncdc_hdl.link.sender import TEMPLATE_ADDRESS_BITS, Sender
from ncdc_hdl.registers.page import Page
from ncdc_model.interface.link_map import (
    CONTROL_ABORT,
    CONTROL_SEND,
    LINK,
    LINK_SETTINGS,
    LINK_WORDS_BITS,
    RESEND_BEFORE,
    STATUS_DONE,
    STATUS_REFUSED,
    STATUS_RESENT,
)

__all__ = ["Packetiser"]

_BURST = 16         # words of a read
_JOBS = 4           # packets that wait for the sender


class Packetiser(wiring.Component):
    """Sends frames from memory as packets, and any of them again.

    A packet is a header that the host has written, with the packet's number put into it, and a
    part of the frame behind it; what the header says is nothing to the hardware. There are four:
    of the leader, of payload packets, of the last of them, and of the trailer; one without bytes is
    not sent. There are two sets, and two bases, so that packets of the frame before can be sent
    again while a frame is sent: the host writes the set of the next frame.

    Nobody protects the frame in memory: the host releases its buffer when neither it nor a resend
    needs it. Registers: :mod:`ncdc_model.interface.link_map`.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory, at most 128.
    capacity : int
        Bytes of payload that are read ahead, a multiple of the word; a packet must fit, and two
        leave no pause.

    Members
    -------
    csr : ``In(Agent(LINK_WORDS_BITS))``
    o : ``Out(stream.Signature(BEAT))``
        Ethernet frames without their check sequence; none has a pause in it.
    memory_rst, bus :
        As of :class:`PayloadReader`.
    irq : ``Out(1)``
        A frame or a range has been sent, until its bit in LINK_STATUS is cleared.

    Raises
    ------
    ValueError
        If a word is longer than the multiples of which payloads are.
    """

    def __init__(self, data_width, *, capacity=4096):
        if data_width not in (32, 64, 128):
            raise ValueError(f"data_width is {data_width}, it must be 32, 64 or 128")
        self.data_width, self.capacity = data_width, capacity
        self.depth = capacity // (data_width // 8)
        super().__init__({
            "csr": In(Agent(LINK_WORDS_BITS)), "o": Out(stream.Signature(BEAT)),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, _BURST)), "irq": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        word_bits = exact_log2(self.data_width // 8)
        m.submodules.page = page = Page(LINK, LINK_WORDS_BITS, {"LINK_PAYLOAD": 1456},
                                        LINK_SETTINGS, {"LINK_BASE": word_bits})
        m.submodules.schedule = schedule = Schedule()
        m.submodules.jobs = jobs = SyncFIFOBuffered(width=JOB.size, depth=_JOBS)
        m.submodules.payload = payload = PayloadReader(self.data_width, depth=self.depth,
                                                       burst=_BURST)
        m.submodules.sender = sender = Sender(self.data_width, self.depth)
        m.submodules.joiner = joiner = Joiner()
        connect(m, schedule.o, payload.i)
        connect(m, payload.words, sender.words)
        connect(m, payload.bus, flipped(self.bus))
        connect(m, sender.o, joiner.i)
        connect(m, joiner.o, flipped(self.o))
        values = page.values
        m.d.comb += [
            jobs.w_data.eq(payload.o.payload), jobs.w_en.eq(payload.o.valid),
            payload.o.ready.eq(jobs.w_rdy), sender.i.payload.eq(jobs.r_data),
            sender.i.valid.eq(jobs.r_rdy), jobs.r_en.eq(sender.i.ready),
            sender.level.eq(payload.level), payload.memory_rst.eq(self.memory_rst),
            schedule.plan.payload.eq(values.LINK_PAYLOAD),
            schedule.plan.packets.eq(values.LINK_PACKETS), schedule.plan.last.eq(values.LINK_LAST),
            schedule.plan.first.eq(values.LINK_FIRST_NUMBER), schedule.base.eq(values.LINK_BASE),
            schedule.resend_first.eq(values.LINK_RESEND_FIRST),
            sender.field_byte.eq(values.LINK_NUMBER_FIELD[:8]),
            sender.field_bytes.eq(values.LINK_NUMBER_FIELD[8:]),
            joiner.again.eq(sender.again), joiner.delay.eq(values.LINK_DELAY),
        ]
        self._bus(m, page, sender, schedule)
        self._ask(m, page, schedule, joiner, sender)
        return m

    def _bus(self, m, page, sender, schedule):
        """Registers, and behind them the headers, which are written only."""
        csr, bus = self.csr, page.bus
        there = csr.address[-1]                 # it is a header's
        taken = Signal()                        # the access to a header is accepted
        read = Signal()                         # what is read of a header is zero
        m.d.sync += [taken.eq(there & (csr.read | csr.write) & ~taken), read.eq(taken & csr.read)]
        m.d.comb += [
            bus.address.eq(csr.address), bus.writedata.eq(csr.writedata),
            bus.read.eq(csr.read & ~there), bus.write.eq(csr.write & ~there),
            csr.waitrequest.eq(Mux(there, ~taken, bus.waitrequest)),
            csr.readdatavalid.eq(bus.readdatavalid | read),
            csr.readdata.eq(Mux(bus.readdatavalid, bus.readdata, 0)),
            # The set of the next frame.
            sender.address.eq(Cat(csr.address[:TEMPLATE_ADDRESS_BITS - 1], ~schedule.bank)),
            sender.data.eq(csr.writedata),
        ]

    def _ask(self, m, page, schedule, joiner, sender):
        """What is asked for by registers, what is refused, and what they tell."""
        values, word = page.values, page.word
        frame, again = (self._flight(m, name, *events) for name, events in (
            ("frame", (schedule.o.valid & ~schedule.o.p.again, schedule.o.ready,
                       joiner.ended & ~joiner.ended_again, sender.skipped & ~sender.again)),
            ("again", (schedule.o.valid & schedule.o.p.again, schedule.o.ready,
                       joiner.ended_again, sender.skipped & sender.again))))
        sending, resending = Signal(), Signal()     # packets are to be sent, or on their way
        sent, resent = Signal(), Signal()           # the last one has gone, for one clock
        frames = Signal(2)                          # that were begun, at most two
        fits = Signal()                             # the queue holds the packets
        payload, last = values.LINK_PAYLOAD, values.LINK_LAST
        m.d.sync += fits.eq((payload != 0) & (payload[:4] == 0) & (payload <= self.capacity)
                            & (values.LINK_PACKETS != 0) & (last != 0) & (last <= payload))
        control, range_ = page.written.LINK_CONTROL, page.written.LINK_RESEND_LAST
        asked = control & (word & CONTROL_SEND).any()
        wanted = Mux((word & RESEND_BEFORE).any(), frames == 2, frames != 0)
        header = self.csr.address[-1] & self.csr.write & ~self.csr.waitrequest
        # The set of the next frame is that of the one before.
        header_free = ~(resending & (schedule.resending_bank != schedule.bank))
        m.d.comb += [
            schedule.send.eq(asked & ~sending & fits & ~resending),
            schedule.abort.eq(control & (word & CONTROL_ABORT).any()),
            schedule.resend.eq(range_ & ~resending & wanted),
            schedule.resend_last.eq(word), schedule.resend_before.eq(word[-1]),
            sender.write.eq(header & header_free),
            sent.eq(sending & ~schedule.busy & ~frame), resent.eq(resending & ~schedule.resending
                                                                  & ~again),
            page.lock.eq(sending | resending),
        ]
        with m.If(schedule.send):
            m.d.sync += [sending.eq(1), frames.eq(Mux(frames == 2, 2, frames + 1))]
        with m.Elif(sent):
            m.d.sync += sending.eq(0)
        with m.If(schedule.resend):
            m.d.sync += resending.eq(1)
        with m.Elif(resent):
            m.d.sync += resending.eq(0)
        refused = (page.refused | asked & ~schedule.send | range_ & ~schedule.resend
                   | header & ~header_free)
        self._tell(m, page, (sending, sent, resending, resent, refused))
        self._count(m, page, schedule, joiner, sender, sending)

    @staticmethod
    def _flight(m, name, offered, taken, sent, skipped):
        """High while jobs of a kind are on their way, from the offer of the first one on."""
        # Waiting for their payload, in the queue, with the sender and in the joiner's beats.
        count = Signal(range(1 + _JOBS + 1 + Joiner.depth + 1), name=f"{name}_jobs")
        m.d.sync += count.eq(count + (offered & taken) - sent - skipped)
        return (count != 0) | offered

    def _tell(self, m, page, states):
        """LINK_STATUS and the interrupt."""
        sending, sent, resending, resent, refused = states
        events = []
        for mask, happens in ((STATUS_DONE, sent), (STATUS_RESENT, resent),
                              (STATUS_REFUSED, refused)):
            event = Signal(name=f"event{mask}")
            with m.If(page.written.LINK_STATUS & (page.word & mask).any()):
                m.d.sync += event.eq(0)
            with m.If(happens):
                m.d.sync += event.eq(1)
            events.append(event)
        done, resent_event, refused_event = events
        m.d.comb += [
            page.read.LINK_STATUS.eq(Cat(sending, done, resending, resent_event, refused_event)),
            page.read.LINK_CONTROL.eq(0), page.read.LINK_RESEND_LAST.eq(0),
            self.irq.eq(done | resent_event),
        ]

    def _count(self, m, page, schedule, joiner, sender, sending):
        """The counters."""
        clocks, counts = Signal(32), page.read
        for name, step in (("LINK_SENT", joiner.ended & ~joiner.ended_again),
                           ("LINK_RESENT", joiner.ended_again),
                           ("LINK_STALLS", sender.waiting & joiner.quiet)):
            count = Signal(32, name=name.lower())
            m.d.sync += count.eq(count + step)
            m.d.comb += counts[name].eq(count)
        with m.If(schedule.send):
            m.d.sync += clocks.eq(1)
        with m.Elif(sending):
            m.d.sync += clocks.eq(clocks + 1)
        m.d.comb += counts.LINK_CLOCKS.eq(clocks)
