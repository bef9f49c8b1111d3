"""Requests of a host as bytes, and their answers."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.link.layouts import BEAT
from ncdc_hdl.registers.access import Access
from ncdc_hdl.registers.serial_bridge import ByteBridge
from ncdc_hdl.usb.joiner import PIECE, Joiner
from ncdc_hdl.usb.mraw import MrawSender
from ncdc_hdl.usb.table_one import TableOne
from ncdc_spec.protocols import serial_link, table_one

__all__ = ["ByteCommands"]

_GAP_US = 100_000       # longest time between two bytes of a request


class ByteCommands(wiring.Component):
    """Table I and II, and registers, over one stream of bytes and without a processor.

    The first byte selects the request: those of :mod:`ncdc_spec.protocols.table_one`, or the
    letters of :mod:`ncdc_spec.protocols.serial_link`, which differ. Any other byte is
    answered by 0xFF and itself; there is no connection to close. Requests are answered
    one after the other. One that stops for 100 ms is dropped, so that a host
    is synchronised again after a pause.

    Parameters
    ----------
    view : SystemView
    sensor : Sensor
    data_width, burst : int
        Parameters of the memory port.
    address_bits : int
        Bits of a word address.
    gap_us : int
        Microseconds between two bytes of a request after which it is dropped.

    Members
    -------
    i : ``In(stream.Signature(8))``
    o : ``Out(stream.Signature(BEAT))``
        ``last``: the end of an answer.
    accesses : ``Out(Access(address_bits)).array(3)``
    memory_rst, bus :
        As in :class:`MrawSender`.
    """

    def __init__(self, view, sensor, data_width, burst, address_bits, gap_us=_GAP_US):
        self.gap = gap_us * view.clock_mhz
        self.mraw = MrawSender(view, data_width, burst, address_bits)
        self.table = TableOne(view, sensor, address_bits)
        self.bridge = ByteBridge(self.gap, address_bits)
        super().__init__({
            "i": In(stream.Signature(8)), "o": Out(stream.Signature(BEAT)),
            "accesses": Out(Access(address_bits)).array(3), "memory_rst": In(1),
            "bus": Out(ReadHost(data_width, burst))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.mraw, m.submodules.table = self.mraw, self.table
        m.submodules.bridge = bridge = self.bridge
        m.submodules.joiner = joiner = Joiner()
        mraw, table, i = self.mraw, self.table, self.i
        for access, one in zip(self.accesses, (bridge, table, mraw)):
            connect(m, one.access, flipped(access))
        connect(m, mraw.bus, flipped(self.bus))
        connect(m, joiner.o, flipped(self.o))
        request, left = Signal(40), Signal(range(5))    # bytes so far, and number of bytes to come
        idle = Signal(range(self.gap + 1))              # clocks since the last byte
        m.d.comb += [mraw.memory_rst.eq(self.memory_rst), mraw.corrected.eq(table.source),
                     table.number.eq(mraw.number), table.request.eq(request),
                     bridge.i.payload.eq(i.payload)]
        m.d.sync += idle.eq(idle + 1)
        with m.FSM():
            with m.State("CODE"):
                self._code(m, request, left)
                m.d.sync += idle.eq(0)
            with m.State("REQUEST"):
                m.d.comb += i.ready.eq(1)
                with m.If(i.valid):
                    m.d.sync += [request.eq(Cat(i.payload, request)), left.eq(left - 1),
                                 idle.eq(0)]
                    with m.If(left == 1):
                        m.next = "TABLE"
                with m.Elif(idle == self.gap):
                    m.next = "CODE"
            with m.State("TABLE"):
                m.d.comb += table.start.eq(1)
                m.next = "TABLE-BUSY"
            with m.State("TABLE-BUSY"):
                self._give(m, joiner, table.o)
                with m.If(~table.busy):
                    m.next = "CODE"
            with m.State("PICTURE"):
                m.d.comb += mraw.start.eq(1)
                m.next = "PICTURE-BUSY"
            with m.State("PICTURE-BUSY"):
                self._give(m, joiner, mraw.o)
                m.d.comb += mraw.give_up.eq(i.valid)
                with m.If(~mraw.busy):
                    m.next = "CODE"
            with m.State("BRIDGE"):
                # It has taken its letter, and is idle again after its answer.
                m.d.comb += [bridge.i.valid.eq(i.valid & ~bridge.rests),
                             i.ready.eq(bridge.i.ready & ~bridge.rests)]
                self._give(m, joiner, self._pieces(m))
                with m.If(bridge.rests):
                    m.next = "CODE"
            with m.State("UNKNOWN"):
                m.d.comb += [joiner.i.valid.eq(1), joiner.i.p.bytes.eq(2), joiner.i.p.last.eq(1),
                             joiner.i.p.data.eq(Cat(Const(table_one.UNKNOWN, 8), request[:8]))]
                with m.If(joiner.i.ready):
                    m.next = "CODE"
        return m

    def _code(self, m, request, left):
        """Decode the first byte of a request."""
        i, bridge = self.i, self.bridge
        m.d.comb += i.ready.eq(1)
        m.d.sync += [request.eq(i.payload), left.eq(4)]
        with m.If(i.valid):
            with m.Switch(i.payload):
                with m.Case(table_one.READ, table_one.WRITE):
                    m.next = "REQUEST"
                with m.Case(table_one.RESERVED):
                    m.next = "CODE"
                with m.Case(table_one.MRAW):
                    m.next = "PICTURE"
                with m.Case(serial_link.READ, serial_link.WRITE):
                    m.d.comb += bridge.i.valid.eq(1)
                    m.next = "BRIDGE"
                with m.Default():
                    m.next = "UNKNOWN"

    def _pieces(self, m):
        """The bridge's bytes as pieces."""
        pieces = stream.Signature(PIECE).create()
        bridge = self.bridge
        m.d.comb += [pieces.valid.eq(bridge.o.valid), pieces.p.data.eq(bridge.o.payload),
                     pieces.p.bytes.eq(1), pieces.p.last.eq(bridge.last),
                     bridge.o.ready.eq(pieces.ready)]
        return pieces

    @staticmethod
    def _give(m, joiner, pieces):
        """Connect pieces to the joiner."""
        m.d.comb += [joiner.i.valid.eq(pieces.valid), joiner.i.payload.eq(pieces.payload),
                     pieces.ready.eq(joiner.i.ready)]
