"""MRAW packages: the newest frame of a store, after the header of Table II."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.avalon.bus import ReadHost
from ncdc_hdl.registers.access import Access
from ncdc_hdl.usb.area_reader import AreaReader
from ncdc_hdl.usb.joiner import PIECE
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.protocols.table_two import HEADER_BYTES

__all__ = ["MrawSender"]

_CLAIM, _RELEASE, _HELD = (1, 2), 4, 0x100      # bits of READERk
_PART = 1024            # bytes of a corrected picture requested at a time
_DEPTH = 256            # words that are prefetched
_FRAME = data.StructLayout({
    "corrected": 1, "buffer": 4,        # store and buffer of the frame
    "address": 32,                      # address of its first byte
    "width": 16, "height": 16,          # pixels
    "left": 1, "top": 1,                # lowest bits of the window's corner, for a raw frame
    "bytes": 32,
    "time": 64,                         # time of its beginning, in clocks, then microseconds
    "rest": 16,                         # remainder of the division
})


class MrawSender(wiring.Component):
    """Claims the newest frame, sends it after its header, and releases it.

    It reads all data on the frame from the system's registers, as a host does. If there is
    no frame yet it waits for one, until ``give_up``.

    The header (Table II) has width, height, formation, size, address and port 0, and microseconds
    from the reset to the beginning of the raw frame, modulo 2**32.

    Parameters
    ----------
    view : SystemView
    data_width, burst : int
        Parameters of the memory port.

    Members
    -------
    start, corrected : ``In(1)``
        Begin; ``corrected``: a corrected picture, else a raw one. Ignored while ``busy``.
    give_up : ``In(1)``
        End without an answer, if no frame is there.
    busy : ``Out(1)``
    number : ``Out(32)``
        Number of the frame that was sent last.
    access : ``Out(Access(address_bits))``
    o : ``Out(stream.Signature(PIECE))``
    memory_rst, bus :
        As in :class:`AreaReader`.
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
        m.d.comb += [reader.memory_rst.eq(self.memory_rst), self.busy.eq(1)]
        frame = Signal(_FRAME)
        m.d.comb += reader.i.p.address.eq(frame.address)
        step, word = Signal(range(16)), Signal(range(HEADER_BYTES // 4 + 1))
        bits = Signal(range(65))            # bits of the quotient left
        with m.FSM():
            with m.State("REST"):
                m.d.comb += self.busy.eq(0)
                m.d.sync += frame.corrected.eq(self.corrected & self.view.has_corrected)
                with m.If(self.start):
                    m.next = "CLAIM"
            self._claim(m, frame, step)
            with m.State("ASK"):
                m.d.sync += [bits.eq(64), word.eq(0)]
                self._ask(m, frame, reader.i.p, step)
            with m.State("DIVIDE"):
                self._divide(m, frame, bits)
                self._sizes(m, frame, reader.i.p)
            with m.State("HEADER"):
                self._header(m, frame, word)
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
                self._write(m, self._reader, _RELEASE, "REST")
        return m

    @property
    def _reader(self):
        """Word address of the reader's register."""
        return self.view.addresses[f"READER{self.view.reader}"]

    def _claim(self, m, frame, step):
        """Claim the newest frame, until there is one."""
        access, pause = self.access, Signal(10)
        with m.State("CLAIM"):
            self._write(m, self._reader, Mux(frame.corrected, _CLAIM[1], _CLAIM[0]), "LOOK")
        with m.State("LOOK"):
            m.d.comb += [access.valid.eq(1), access.address.eq(self._reader)]
            m.d.sync += [frame.buffer.eq(access.answer[11:15]), step.eq(0), pause.eq(0)]
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

    def _ask(self, m, frame, area, step):
        """Read the data on the frame."""
        at, access = self.view.addresses, self.access
        buffers = Mux(frame.corrected, at.get("CORRECTED0_BASE", 0), at["RAW0_BASE"])
        entry = buffers + (frame.buffer << 2)
        asked = [   # word address, target of the word
            (entry, frame.address), (entry + 1, self.number), (entry + 2, frame.time[:32]),
            (entry + 3, frame.time[32:]), (at["WINDOW_WIDTH"], frame.width),
            (at["WINDOW_HEIGHT"], frame.height), (at["WINDOW_LEFT"], frame.left),
            (at["WINDOW_TOP"], frame.top), (at["RAW_PITCH"], area.pitch)]
        m.d.comb += access.valid.eq(1)
        m.d.sync += frame.rest.eq(0)
        with m.Switch(step):
            for k, (address, target) in enumerate(asked):
                with m.Case(k):
                    m.d.comb += access.address.eq(address)
                    with m.If(access.done):
                        m.d.sync += target.eq(access.answer)
        with m.If(access.done):
            m.d.sync += step.eq(step + 1)
            with m.If(step == len(asked) - 1):
                m.next = "DIVIDE"

    def _divide(self, m, frame, bits):
        """Clocks to microseconds, a bit of the quotient per clock."""
        more = Cat(frame.time[-1], frame.rest)
        fits = more >= self.view.clock_mhz
        m.d.sync += [frame.rest.eq(Mux(fits, more - self.view.clock_mhz, more)),
                     frame.time.eq(Cat(fits, frame.time)), bits.eq(bits - 1)]
        with m.If(bits == 1):
            m.next = "HEADER"

    def _sizes(self, m, frame, area):
        """Layout of the frame in memory: a corrected one has no gaps between its rows."""
        view = self.view
        size = view.corrected_pixel * view.corrected[0] * view.corrected[1]
        parts = -(-size // _PART)
        with m.If(frame.corrected):
            m.d.sync += [
                frame.width.eq(view.corrected[0]), frame.height.eq(view.corrected[1]),
                frame.bytes.eq(size), area.pitch.eq(_PART), area.row.eq(_PART),
                area.rows.eq(parts), area.last.eq(size - _PART * (parts - 1))]
        with m.Else():
            m.d.sync += [frame.bytes.eq(frame.width * frame.height), area.row.eq(frame.width),
                         area.last.eq(frame.width), area.rows.eq(frame.height)]

    def _write(self, m, address, word, following):
        """Write a register, and continue."""
        m.d.comb += [self.access.valid.eq(1), self.access.write.eq(1),
                     self.access.address.eq(address), self.access.word.eq(word)]
        with m.If(self.access.done):
            m.next = following

    def _header(self, m, frame, word):
        """A word of the header, whose numbers are big endian."""
        view = self.view
        raw = view.raw_formation
        formation = Signal(8)
        m.d.comb += formation.eq(Mux(
            frame.corrected, view.corrected_formation,
            raw ^ Cat(frame.left, frame.top) if raw < len(BAYER_PHASE) else raw))
        # Width 4, height 4, formation 1, size 7, address 4, port 4, time 4 bytes.
        header = Cat(frame.time[:32], Const(0, 64), frame.bytes, Const(0, 24), formation,
                     frame.height, Const(0, 16), frame.width, Const(0, 16))
        words = [header.word_select(HEADER_BYTES // 4 - 1 - k, 32)
                 for k in range(HEADER_BYTES // 4)]
        m.d.comb += [self.o.valid.eq(1), self.o.p.bytes.eq(4)]
        with m.Switch(word):
            for k, big in enumerate(words):
                with m.Case(k):
                    m.d.comb += self.o.p.data.eq(Cat(big.word_select(3 - j, 8)
                                                     for j in range(4)))
