"""MRAW packages: the newest frame of a store, with the header of Table II in front."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.link.layouts import PIECE
from ncdc_hdl.registers.access import Access
from ncdc_hdl.usb.area_reader import AreaReader
from ncdc_model.interface.table_two import HEADER_BYTES

__all__ = ["MrawSender"]

_CLAIM, _RELEASE, _HELD = (1, 2), 4, 0x100      # of READERk
_PART = 1024            # bytes of a corrected picture that are asked for at a time
_DEPTH = 256            # words that are read ahead


class MrawSender(wiring.Component):
    """Claims the newest frame, sends it behind its header, and releases it.

    All that it knows of the frame it reads from the system's registers, as a host does. If there is
    no frame as yet it waits for one, until ``give_up``.

    The header (Table II) says width, height, formation, size, address and port 0, and microseconds
    from the reset to the beginning of the raw frame, modulo 2**32.

    Parameters
    ----------
    view : SystemView
    data_width, burst : int
        Of the memory port.

    Members
    -------
    start, corrected : ``In(1)``
        Begin; ``corrected``: a corrected picture, else a raw one. Not taken while ``busy``.
    give_up : ``In(1)``
        End without an answer, if no frame is there.
    busy : ``Out(1)``
    number : ``Out(32)``
        Of the frame that was sent last.
    access : ``Out(Access(address_bits))``
    o : ``Out(stream.Signature(PIECE))``
    memory_rst, bus :
        As of :class:`AreaReader`.
    """

    def __init__(self, view, data_width, burst, address_bits):
        self.view, self.data_width, self.burst = view, data_width, burst
        super().__init__({
            "start": In(1), "corrected": In(1), "give_up": In(1), "busy": Out(1),
            "number": Out(32), "access": Out(Access(address_bits)),
            "o": Out(stream.Signature(PIECE)), "memory_rst": In(1),
            "bus": Out(ReadHost(data_width, burst))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.reader = reader = AreaReader(self.data_width, depth=_DEPTH, burst=self.burst)
        connect(m, reader.bus, flipped(self.bus))
        m.d.comb += reader.memory_rst.eq(self.memory_rst)
        view, at, access, area = self.view, self.view.addresses, self.access, reader.i.p
        corrected, buffer = Signal(), Signal(4)
        width, height, left, top = Signal(16), Signal(16), Signal(1), Signal(1)
        time, size = Signal(64), Signal(32)
        buffers = Mux(corrected, at.get("CORRECTED0_BASE", 0), at["RAW0_BASE"])
        asked = [   # what is read of a frame: word address, where to, only of a raw one
            (buffers + (buffer << 2), area.address, False),
            (buffers + (buffer << 2) + 1, self.number, False),
            (buffers + (buffer << 2) + 2, time[:32], False),
            (buffers + (buffer << 2) + 3, time[32:], False),
            (at["WINDOW_WIDTH"], width, True), (at["WINDOW_HEIGHT"], height, True),
            (at["WINDOW_LEFT"], left, True), (at["WINDOW_TOP"], top, True),
            (at["RAW_PITCH"], area.pitch, True)]
        reader_address = at[f"READER{view.reader}"]
        step = Signal(range(len(asked) + 1))
        pause = Signal(10)
        rest, bits = Signal(range(2 * view.clock_mhz)), Signal(range(65))    # of the division
        word = Signal(range(HEADER_BYTES // 4 + 1))
        m.d.comb += self.busy.eq(1)
        with m.FSM():
            with m.State("REST"):
                m.d.comb += self.busy.eq(0)
                m.d.sync += corrected.eq(self.corrected & view.has_corrected)
                with m.If(self.start):
                    m.next = "CLAIM"
            with m.State("CLAIM"):
                self._write(m, reader_address, Mux(corrected, _CLAIM[1], _CLAIM[0]), "LOOK")
            with m.State("LOOK"):
                m.d.comb += [access.valid.eq(1), access.address.eq(reader_address)]
                m.d.sync += [buffer.eq(access.answer[11:15]), step.eq(0), pause.eq(0)]
                with m.If(access.done):
                    m.next = "NONE"
                    with m.If((access.answer & _HELD).any()):
                        m.next = "ASK"
            with m.State("NONE"):
                m.d.sync += pause.eq(pause + 1)
                with m.If(self.give_up):
                    m.next = "REST"
                with m.Elif(pause.all()):
                    m.next = "CLAIM"
            with m.State("ASK"):
                self._corrected_size(m, corrected, width, height, area)
                m.d.comb += access.valid.eq(1)
                m.d.sync += [rest.eq(0), bits.eq(64), word.eq(0)]
                with m.Switch(step):
                    for k, (address, target, raw) in enumerate(asked):
                        with m.Case(k):
                            m.d.comb += access.address.eq(address)
                            with m.If(access.done & ~(raw & corrected)):
                                m.d.sync += target.eq(access.answer)
                with m.If(access.done):
                    m.d.sync += step.eq(step + 1)
                    with m.If(step == len(asked) - 1):
                        m.next = "DIVIDE"
            with m.State("DIVIDE"):
                # Clocks to microseconds, a bit of the quotient per clock.
                more = Cat(time[-1], rest)
                fits = more >= view.clock_mhz
                m.d.sync += [rest.eq(Mux(fits, more - view.clock_mhz, more)),
                             time.eq(Cat(fits, time)), bits.eq(bits - 1)]
                m.d.sync += size.eq(Mux(corrected,
                                        view.corrected_pixel * view.corrected[0]
                                        * view.corrected[1], width * height))
                with m.If(~corrected):
                    m.d.sync += [area.row.eq(width), area.last.eq(width), area.rows.eq(height)]
                with m.If(bits == 1):
                    m.next = "HEADER"
            with m.State("HEADER"):
                formation = Mux(corrected, view.corrected_formation,
                                view.raw_formation ^ Cat(left, top) if view.raw_formation < 4
                                else view.raw_formation)
                self._header(m, word, width, height, formation, size, time[:32])
                with m.If(self.o.ready):
                    m.d.sync += word.eq(word + 1)
                    with m.If(word == HEADER_BYTES // 4 - 1):
                        m.next = "PICTURE"
            with m.State("PICTURE"):
                m.d.comb += [reader.i.valid.eq(1), self.o.valid.eq(reader.o.valid),
                             self.o.payload.eq(reader.o.payload), reader.o.ready.eq(self.o.ready)]
                with m.If(reader.i.ready):
                    m.next = "RELEASE"
            with m.State("RELEASE"):
                self._write(m, reader_address, _RELEASE, "REST")
        return m

    def _write(self, m, address, word, following):
        """Write a register, and go on."""
        m.d.comb += [self.access.valid.eq(1), self.access.write.eq(1),
                     self.access.address.eq(address), self.access.word.eq(word)]
        with m.If(self.access.done):
            m.next = following

    def _corrected_size(self, m, corrected, width, height, area):
        """A corrected picture has no gaps between its rows."""
        view = self.view
        size = view.corrected_pixel * view.corrected[0] * view.corrected[1]
        parts = -(-size // _PART)
        with m.If(corrected):
            m.d.sync += [width.eq(view.corrected[0]), height.eq(view.corrected[1]),
                         area.pitch.eq(_PART), area.row.eq(_PART), area.rows.eq(parts),
                         area.last.eq(size - _PART * (parts - 1))]

    def _header(self, m, word, width, height, formation, size, time):
        """A word of the header, whose numbers are big endian."""
        # Width 4, height 4, formation 1, size 7, address 4, port 4, time 4 bytes.
        one = Signal(8)
        m.d.comb += one.eq(formation)
        header = Cat(time, Const(0, 64), size, Const(0, 24), one, height, Const(0, 16),
                     width, Const(0, 16))
        words = [header.word_select(HEADER_BYTES // 4 - 1 - k, 32)
                 for k in range(HEADER_BYTES // 4)]
        m.d.comb += [self.o.valid.eq(1), self.o.p.bytes.eq(4)]
        with m.Switch(word):
            for k, big in enumerate(words):
                with m.Case(k):
                    m.d.comb += self.o.p.data.eq(Cat(big.word_select(3 - j, 8)
                                                     for j in range(4)))
