"""Frames in memory, sent as packets with headers that the host has written."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import Agent, ReadHost
from ncdc_hdl.link.builder import TEMPLATE_ADDRESS_BITS, Builder
from ncdc_hdl.link.engine import Engine
from ncdc_hdl.link.layouts import BEAT, Template
from ncdc_hdl.link.packet_queue import PacketQueue
from ncdc_hdl.link.words import WordReader
from ncdc_spec.registers.link_map import (
    CONTROL_ABORT,
    CONTROL_SEND,
    LINK,
    LINK_SETTINGS,
    LINK_WORDS_BITS,
    NUMBER_BITS,
    RESEND_BEFORE,
    STATUS_DONE,
    STATUS_REFUSED,
    STATUS_RESENT,
    TEMPLATE_WORDS,
)

__all__ = ["Packetiser"]

_BURST = 16         # words of a read
_PACKETS = 2        # most packets being built or waiting
_DEFAULT = 1456     # bytes of a payload, after a reset
_FIRST_TIME = -4096 % (1 << 32)     # any will do: the counter wraps soon, within each simulation
_AT = {register.name: register.address for register in LINK}
_STATE = data.StructLayout({
    "sending": 1, "resending": 1,       # packets wait or are being sent
    "busy": 1, "ranging": 1,            # there are packets to build
    "bank": 1, "range_bank": 1,         # set of headers of the last frame, and of the range
    "frames": 2,                        # frames begun, at most two
    "done": 1, "resent": 1, "rejected": 1,      # flags of LINK_STATUS until cleared
})


class Packetiser(wiring.Component):
    """Sends frames from memory as packets, and any of them again.

    A packet is a header that the host has written, with the packet's number in it, and a
    part of the frame after it. The hardware does not interpret the header. There are four:
    leader, payload packets, the last of these, trailer; one without bytes is
    not sent. There are two sets, and two bases, so that packets of the frame before can be sent
    again while a frame is sent. The host writes the set of the next frame.

    The frame in memory is not protected: the host releases its buffer when neither it nor a resend
    needs it. Registers: :mod:`ncdc_spec.registers.link_map`.

    Timing: an access to a register takes some 25 clocks, and up to 150 during other work; to
    LINK_STATUS and to headers 3. A burst is requested every 18 clocks. A packet of 64 bytes of
    payload takes 242, if the memory answers after 60.

    Parameters
    ----------
    data_width : int
        Bits of a word of the memory: 32, 64 or 128.
    capacity : int
        Bytes of payload that a packet may have, a multiple of 4. The queue has space for them and
        the longest header; if it has space for two packets, there is no pause between them.

    Members
    -------
    csr : ``In(Agent(LINK_WORDS_BITS))``
    o : ``Out(stream.Signature(BEAT))``
        Ethernet frames without their check sequence; without pauses in them.
    memory_rst, bus :
        As in :class:`ncdc_hdl.avalon.read_commands.ReadCommands`.
    irq : ``Out(1)``
        A frame or a range has been sent; high until its bit in LINK_STATUS is cleared.

    Raises
    ------
    ValueError
        If a word is longer than the unit of payloads.
    """

    def __init__(self, data_width, *, capacity=3840):
        if data_width not in (32, 64, 128):
            raise ValueError(f"data_width is {data_width}, it must be 32, 64 or 128")
        self.data_width, self.capacity = data_width, capacity
        self.depth = capacity // 4 + TEMPLATE_WORDS     # beats
        super().__init__({
            "csr": In(Agent(LINK_WORDS_BITS)), "o": Out(stream.Signature(BEAT)),
            "memory_rst": In(1), "bus": Out(ReadHost(data_width, _BURST)), "irq": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        word_bytes = self.data_width // 8
        m.submodules.engine = engine = Engine({
            "ONE": 1, "TWO": 2, "BURST": _BURST * word_bytes, "ABOVE": self.capacity + 1,
            "PAIR": self._pair() + 1, "DEFAULT": _DEFAULT})
        m.submodules.words = words = WordReader(self.data_width, _BURST, limit=self.depth)
        m.submodules.builder = builder = Builder()
        m.submodules.queue = queue = PacketQueue(self.depth, _PACKETS)
        connect(m, words.bus, flipped(self.bus))
        connect(m, queue.o, flipped(self.o))
        m.d.comb += [
            words.memory_rst.eq(self.memory_rst), words.last.eq(builder.last),
            builder.valid.eq(words.valid), builder.word.eq(words.word),
            queue.put.eq(builder.put), queue.entry.eq(builder.entry),
        ]
        state = Signal(_STATE)
        self._bus(m, engine, builder, state)
        self._packets(m, engine, builder, queue, state)
        self._commands(m, engine, builder, words)
        self._times(m, engine, builder, queue)
        return m

    def _pair(self):
        """Most bytes of payload with which two packets with the longest headers fit into the queue.

        A method of its own only so that tests can break it.
        """
        return 4 * max(0, self.depth // _PACKETS - TEMPLATE_WORDS)

    def _bus(self, m, engine, builder, state):
        """Accesses to registers, answered by the program except for the status, and to headers."""
        csr, conditions, orders = self.csr, engine.conditions, engine.orders
        register = csr.address[:4]
        page = csr.address[4:] == 0
        header = csr.address[-1] & csr.write
        status = page & (register == _AT["LINK_STATUS"])
        taken, status_read = Signal(), Signal()     # without the program; the status was read
        settings = [_AT[name] for name in LINK_SETTINGS]
        written, read = ([r.address for r in LINK if r.access in kinds]
                         for kinds in (("rw",), ("rw", "ro")))
        m.d.sync += [taken.eq((header | status & csr.read) & ~taken),
                     status_read.eq(taken & csr.read)]
        m.d.comb += [
            csr.waitrequest.eq(~(orders.accept | taken)),
            csr.readdata.eq(Mux(status_read, Cat(
                state.sending, state.done, state.resending, state.resent,
                                          state.rejected), engine.sum)),
            csr.readdatavalid.eq(status_read | orders.answer),
            engine.word.eq(csr.writedata), engine.host.eq(register),
            conditions.host.eq(csr.read & ~status | csr.write & ~header),
            conditions.reads.eq(csr.read),
            conditions.stored.eq(page & Mux(csr.read, _any(register, read),
                                          _any(register, written))),
            conditions.locked.eq(page & _any(register, settings)
                                 & (state.sending | state.resending)),
            conditions.status.eq(status),
            conditions.control.eq(page & (register == _AT["LINK_CONTROL"])),
            conditions.range.eq(page & (register == _AT["LINK_RESEND_LAST"])),
            conditions.send.eq((csr.writedata & CONTROL_SEND).any()),
            # The set of the next frame.
            builder.address.eq(Cat(csr.address[:TEMPLATE_ADDRESS_BITS - 1], ~state.bank)),
            builder.data.eq(csr.writedata),
            builder.write.eq(taken & header & self._header_free(state)),
        ]
        with m.If(orders.set & (register == _AT["LINK_NUMBER_FIELD"])):
            m.d.sync += Cat(builder.field_byte, builder.field_bytes).eq(engine.sum)
        # Bits of the registers that are written.
        low = {"LINK_BASE": exact_log2(self.data_width // 8)}
        wide = {r.name: r.shape.width for r in LINK if r.access == "rw"} | {
            "LINK_RESEND_LAST": NUMBER_BITS}
        m.d.comb += engine.mask.eq(~Cat(
            _any(register, [_AT[name] for name in wide if not low.get(name, 0) <= k < wide[name]])
            for k in range(32)))

    @staticmethod
    def _header_free(state):
        """Whether the set of the next frame is that of the one before."""
        return ~(state.resending & (state.range_bank != state.bank))

    def _packets(self, m, engine, builder, queue, state):
        """Choose the packets to build, and count those sent."""
        conditions, orders, word = engine.conditions, engine.orders, self.csr.writedata
        job = builder.i.p
        flying, gone = ([Signal(range(_PACKETS + 1), name=f"{name}{kind}") for kind in range(2)]
                        for name in ("flying", "gone"))     # counts for frames, for ranges
        pair = Signal()                     # the queue holds two packets
        steps = Signal(5, init=16)          # steps of the product, or of the program's beginning
        ranging = state.ranging & (steps == 0)              # the next packet belongs to a range
        for kind in range(2):
            counted = orders.counted & (engine.again == kind)
            m.d.sync += [
                flying[kind].eq(flying[kind] + (orders.take_job & (ranging == kind)) - counted
                                - (builder.skipped & (job.again == kind))),
                gone[kind].eq(gone[kind] + (queue.ended & (queue.ended_again == kind)) - counted),
            ]
        uncounted = (gone[0] != 0) | (gone[1] != 0)
        some = [(count != 0) for count in flying]
        space = ~some[0] & ~some[1] | pair & (flying[0] + flying[1] == 1)
        m.d.comb += [
            engine.steps.eq(steps), engine.bank.eq(Mux(engine.again, state.range_bank, state.bank)),
            conditions.steps.eq(steps != 0), conditions.again.eq(engine.again),
            conditions.gone.eq(uncounted), conditions.held.eq(queue.held & ~uncounted),
            conditions.job.eq(~builder.i.valid & space & (ranging | state.busy)),
            conditions.resending.eq(state.resending),
            conditions.active.eq(state.sending | state.resending),
            conditions.unknown.eq(Mux((word & RESEND_BEFORE).any(), state.frames != 2,
                                      state.frames == 0)),
        ]
        with m.If(orders.step):
            m.d.sync += steps.eq(steps - (steps != 0))
        with m.If(orders.multiply):
            m.d.sync += steps.eq(31)
        with m.If(orders.pair):
            m.d.sync += pair.eq(engine.sum[-1])
        for order, again in ((orders.begin, 0), (orders.range, 1), (orders.take_job, ranging),
                             (orders.count, gone[0] == 0)):
            with m.If(order):
                m.d.sync += engine.again.eq(again)
        self._jobs(m, engine, builder)
        self._frames(m, engine, state, some)

    def _jobs(self, m, engine, builder):
        """The packet being built."""
        orders, job = engine.orders, builder.i
        m.d.comb += [engine.conditions.short.eq(job.p.template == Template.LAST),
                     engine.conditions.bare.eq(builder.bare)]
        for template in Template:
            with m.If(orders[template.name.lower()]):
                m.d.sync += job.p.template.eq(template)
        with m.If(orders.bytes):
            m.d.sync += job.p.last.eq(engine.sum)
        with m.If(orders.make):
            m.d.sync += [job.valid.eq(1), job.p.number.eq(engine.sum), job.p.bank.eq(engine.bank),
                         job.p.again.eq(engine.again)]
        with m.Elif(job.ready):
            m.d.sync += job.valid.eq(0)

    def _frames(self, m, engine, state, some):
        """Frames and ranges begin and end."""
        orders, word = engine.orders, self.csr.writedata
        with m.If(orders.begin):
            m.d.sync += [state.sending.eq(1), state.busy.eq(1), state.bank.eq(~state.bank),
                         state.frames.eq(Mux(state.frames == 2, 2, state.frames + 1))]
        with m.If(orders.range):
            m.d.sync += [state.resending.eq(1), state.ranging.eq(1),
                         state.range_bank.eq(state.bank ^ (word & RESEND_BEFORE).any())]
        with m.If(orders.finish):
            with m.If(engine.again):
                m.d.sync += state.ranging.eq(0)
            with m.Else():
                m.d.sync += state.busy.eq(0)
        with m.If(orders.abort & (word & CONTROL_ABORT).any()):
            m.d.sync += state.busy.eq(0)
        sent = state.sending & ~state.busy & ~some[0]
        resent = state.resending & ~state.ranging & ~some[1]
        with m.If(sent):
            m.d.sync += state.sending.eq(0)
        with m.If(resent):
            m.d.sync += state.resending.eq(0)
        self._status(m, engine, state, sent, resent)

    def _commands(self, m, engine, builder, words):
        """Reads of the payload, after its header."""
        orders, i, word_bits = engine.orders, words.i, exact_log2(self.data_width // 8)
        asking = Signal()                       # words remain to be requested
        final = Signal()                        # all of them, by this command
        count = Signal(range(_BURST))           # words of the command, less one
        left = engine.sum[word_bits:len(builder.i.p.last)]
        m.d.comb += [
            engine.conditions.more.eq(asking & builder.open & i.ready), i.valid.eq(orders.ask),
            i.p.address.eq(engine.sum), i.p.words.eq(count + 1),
        ]
        with m.If(orders.size | orders.bytes):
            m.d.sync += [final.eq(left < _BURST),
                         count.eq(Mux(left < _BURST, left, _BURST - 1))]
        with m.If(orders.bytes):
            m.d.sync += asking.eq(1)
        with m.If(orders.ask & final):
            m.d.sync += asking.eq(0)

    def _status(self, m, engine, state, sent, resent):
        """LINK_STATUS and the interrupt."""
        orders, word = engine.orders, self.csr.writedata
        rejected = orders.reject | (~self.csr.waitrequest & self.csr.address[-1] & self.csr.write
                                   & ~self._header_free(state))
        for event, mask, happens in ((state.done, STATUS_DONE, sent),
                                     (state.resent, STATUS_RESENT, resent),
                                     (state.rejected, STATUS_REFUSED, rejected)):
            with m.If(orders.clear_status & (word & mask).any()):
                m.d.sync += event.eq(0)
            with m.If(happens):
                m.d.sync += event.eq(1)
        m.d.comb += self.irq.eq(state.done | state.resent)

    def _times(self, m, engine, builder, queue):
        """The time counter, the pause between packets, and the waiting time of packets."""
        conditions, orders = engine.conditions, engine.orders
        now = Signal(32, init=_FIRST_TIME)
        delayed = Signal()                  # LINK_DELAY != 0
        held = Signal()                     # the pause is not over
        waits = builder.open & queue.idle & ~held
        waited = Signal(8)                  # clocks not yet counted
        m.d.sync += [now.eq(now + 1), waited.eq(Mux(orders.take_waited, 0, waited) + waits)]
        m.d.comb += [
            queue.held.eq(held), engine.waited.eq(waited),
            # Often enough, but not in each clock.
            conditions.waited.eq(waited[6] | ~waits & (waited != 0)),
        ]
        with m.If(queue.ended | orders.begin | orders.look):
            m.d.sync += engine.stamp.eq(now)
        with m.If(orders.set & (self.csr.address[:4] == _AT["LINK_DELAY"])):
            m.d.sync += delayed.eq(engine.sum != 0)
        with m.If(queue.ended):
            m.d.sync += held.eq(delayed)
        with m.Elif(orders.release):
            m.d.sync += held.eq(0)


def _any(register, addresses):
    """Whether the register is one of ``addresses``."""
    return register.matches(*addresses) if addresses else Const(0)
