"""Registers over a line of bytes, and over a serial one."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.crc import Algorithm
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.uart import UartReceiver, UartTransmitter
from ncdc_hdl.registers.access import Access
from ncdc_spec.protocols.serial_link import BAD, CRC, READ, READ_DONE, WRITE, WRITE_DONE

__all__ = ["ByteBridge", "SerialBridge"]

_READ_BYTES, _WRITE_BYTES = 4, 8        # of a request, with the check
_GAP_BYTES = 100                        # byte times of silence after which a request ends


def _check():
    """A generator of checks as in :mod:`ncdc_spec.protocols.serial_link`."""
    return Algorithm(crc_width=8, polynomial=CRC["polynomial"], initial_crc=CRC["initial"],
                     reflect_input=False, reflect_output=False, xor_output=0)(8).create()


class ByteBridge(wiring.Component):
    """Answers requests of :mod:`ncdc_spec.protocols.serial_link`.

    A request whose check is wrong is answered by ``BAD``. A byte that is no letter of a request is
    dropped between requests. A request that stops for ``gap`` clocks is dropped, so that a host
    is synchronised again after a pause.

    Parameters
    ----------
    gap : int
        Clocks.
    address_bits : int
        Bits of a word address, at most 16.

    Members
    -------
    i : ``In(stream.Signature(8))``
        Not ready from the end of a request to the end of its answer.
    o, last : ``Out(stream.Signature(8))``, ``Out(1)``
        ``last``: the byte is the last one of an answer.
    rests : ``Out(1)``
        No request is under way; one may begin in this clock.
    access : ``Out(Access(address_bits))``
    """

    def __init__(self, gap, address_bits):
        self.gap = gap
        super().__init__({"i": In(stream.Signature(8)), "o": Out(stream.Signature(8)),
                          "last": Out(1), "rests": Out(1), "access": Out(Access(address_bits))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.check = check = _check()
        gap = self.gap
        request = Signal(8 * (_WRITE_BYTES - 1))    # bytes received after the letter
        writes = Signal()                           # it is a write
        left = Signal(range(_WRITE_BYTES))          # bytes to come, or to be sent
        idle = Signal(range(gap + 1))               # clocks since the last byte
        answer = Signal(8 * 5)                      # to be sent, its first byte on top
        byte, came = self.i.payload, self.i.valid
        access = self.access
        m.d.comb += [
            access.write.eq(writes), access.word.eq(request[8:40]),
            access.address.eq(Mux(writes, request[40:], request[8:24])),
        ]
        with m.FSM():
            with m.State("LETTER"):
                m.d.comb += [self.i.ready.eq(1), self.rests.eq(1)]
                m.d.comb += [check.start.eq(~came), check.data.eq(byte), check.valid.eq(came)]
                m.d.sync += [writes.eq(byte == WRITE), idle.eq(0),
                             left.eq(Mux(byte == WRITE, _WRITE_BYTES - 1, _READ_BYTES - 1))]
                with m.If(came & ((byte == READ) | (byte == WRITE))):
                    m.next = "REQUEST"
                with m.Elif(came):
                    m.next = "DROP"
            with m.State("DROP"):
                m.d.comb += check.start.eq(1)
                m.next = "LETTER"
            with m.State("REQUEST"):
                m.d.comb += [self.i.ready.eq(1), check.data.eq(byte), check.valid.eq(came)]
                m.d.sync += idle.eq(idle + 1)
                with m.If(came):
                    m.d.sync += [request.eq(Cat(byte, request)), left.eq(left - 1), idle.eq(0)]
                    with m.If(left == 1):
                        m.next = "CHECK"
                with m.Elif(idle == gap):
                    m.next = "DROP"
            with m.State("CHECK"):
                # The check of a message followed by its check is zero.
                m.d.sync += [left.eq(1), answer[-8:].eq(BAD)]
                m.next = "ACCESS"
                with m.If(check.crc != 0):
                    m.next = "BEGIN"
            with m.State("ACCESS"):
                m.d.comb += access.valid.eq(1)
                with m.If(access.done):
                    m.d.sync += [left.eq(Mux(writes, 1, 5)),
                                 answer.eq(Cat(access.answer,
                                               Mux(writes, WRITE_DONE, READ_DONE)[:8]))]
                    m.next = "BEGIN"
            with m.State("BEGIN"):
                m.d.comb += check.start.eq(1)
                m.next = "ANSWER"
            with m.State("ANSWER"):
                self._answer(m, answer, left, check)
        return m

    def _answer(self, m, answer, left, check):
        """Send ``left`` bytes of ``answer``, and then their check."""
        m.d.comb += [self.o.valid.eq(1), self.last.eq(left == 0),
                     self.o.payload.eq(Mux(left == 0, check.crc, answer[-8:]))]
        with m.If(self.o.ready):
            m.d.comb += [check.data.eq(answer[-8:]), check.valid.eq(left != 0)]
            m.d.sync += [answer.eq(Cat(Const(0, 8), answer)), left.eq(left - 1)]
            with m.If(left == 0):
                m.next = "DROP"


class SerialBridge(wiring.Component):
    """A :class:`ByteBridge` at a serial line; a request ends after the time of a hundred bytes.

    Parameters
    ----------
    divisor : int
        Clocks of a bit.
    address_bits : int
        Bits of a word address, at most 16.

    Members
    -------
    receive, send : ``In(1)``, ``Out(1)``
        The lines.
    access : ``Out(Access(address_bits))``
    """

    def __init__(self, divisor, address_bits):
        self.divisor, self.address_bits = divisor, address_bits
        super().__init__({"receive": In(1), "send": Out(1, init=1),
                          "access": Out(Access(address_bits))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.receiver = receiver = UartReceiver(self.divisor)
        m.submodules.transmitter = transmitter = UartTransmitter(self.divisor)
        m.submodules.bridge = bridge = ByteBridge(_GAP_BYTES * 10 * self.divisor,
                                                  self.address_bits)
        wiring.connect(m, bridge.o, transmitter.i)
        wiring.connect(m, bridge.access, wiring.flipped(self.access))
        # A byte that comes while a request is answered is lost: hosts have one request at a time.
        m.d.comb += [receiver.line.eq(self.receive), self.send.eq(transmitter.line),
                     bridge.i.payload.eq(receiver.byte), bridge.i.valid.eq(receiver.valid)]
        return m
