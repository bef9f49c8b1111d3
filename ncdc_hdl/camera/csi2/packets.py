"""Packets: headers, and the payloads of the rows."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.camera.csi2.checksum import Checksum
from ncdc_hdl.camera.csi2.header import HeaderDecoder
from ncdc_hdl.camera.csi2.layouts import FAULTS, SETTINGS, payload, rest_shape, words
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.sensors.csi2 import DataType

__all__ = ["Packets"]

_HEADER_BYTES = 4
_CHECKSUM_BYTES = 2


class Packets(wiring.Component):
    """Takes bursts apart: one packet each, whatever follows it is ignored.

    Packets of other virtual channels or data types are ignored; so is the checksum of their
    payload.

    Timing: free-running; a row's words leave ``latency`` clocks after they came, and so do the
    events of a short packet after its last byte.

    Parameters
    ----------
    lanes : int

    Members
    -------
    settings : ``In(SETTINGS)``
    i : ``In(words(lanes))``
    open : ``In(1)``
        A frame is under way. Rows are dropped otherwise.
    begins, ends : ``Out(1)``
        Start and end of a frame.
    o : ``Out(payload(lanes))``
        Rows.
    faults : ``Out(FAULTS)``
        Those of packets; ``order`` is that of rows, ``length`` that of empty ones.
    """

    latency = HeaderDecoder.latency + 1
    """The header, and what it is."""

    def __init__(self, lanes):
        self.lanes = lanes
        super().__init__({
            "settings": In(SETTINGS), "i": In(words(lanes)), "open": In(1), "begins": Out(1),
            "ends": Out(1), "o": Out(payload(lanes)), "faults": Out(FAULTS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.header = header = HeaderDecoder()
        complete, header_cut = self._gather(m, header)
        decoded = delay(m, complete, header.latency, "complete", reset_less=False)
        known = Signal()                # a header of the own channel
        m.d.comb += known.eq(decoded & ~header.wrong
                             & (header.o.channel == self.settings.channel))
        begins, ends, row = (
            register(m, name, known & (header.o.type == kind), reset_less=False)
            for name, kind in (("begins_", DataType.FRAME_START), ("ends_", DataType.FRAME_END),
                               ("row", self.settings.type)))
        count = register(m, "count", header.o.count)
        some = register(m, "some", header.o.count.any())
        row_cut, wrong = self._payload(m, row & self.open & some, count)
        m.d.comb += [
            self.begins.eq(begins), self.ends.eq(ends),
            self.faults.corrected.eq(register(m, "corrected", decoded & header.corrected,
                                              reset_less=False)),
            self.faults.header.eq(register(m, "wrong", decoded & header.wrong,
                                           reset_less=False)),
            self.faults.order.eq(row & ~self.open),
            self.faults.length.eq(row & self.open & ~some),
            self.faults.checksum.eq(wrong),
            self.faults.cut.eq(row_cut | delay(m, header_cut, self.latency, "header_cut",
                                               reset_less=False))]
        return m

    def _gather(self, m, header):
        """Collect the bytes of a header. Returns (it is complete, its burst ended before that)."""
        count = _HEADER_BYTES // self.lanes         # words of a header
        before = []
        for k in range(count - 1):
            before.insert(0, register(m, f"word_d{k}", before[0] if before else self.i.data))
        m.d.comb += header.i.eq(Cat(*before, self.i.data))
        number = Signal(range(count + 1))           # of the word in its burst, `count` at most
        with m.If(~self.i.valid):
            m.d.sync += number.eq(0)
        with m.Elif(number != count):
            m.d.sync += number.eq(number + 1)
        partial = (number != 0) & (number != count)
        return self.i.valid & (number == count - 1), ~self.i.valid & partial

    def _payload(self, m, begin, count):
        """Hand on a row's words. Returns (its burst ended before it, its checksum is wrong)."""
        lanes = self.lanes
        data = delay(m, self.i.data, self.latency, "data")
        valid = delay(m, self.i.valid, self.latency, "valid", reset_less=False)
        left = Signal(16 - exact_log2(lanes))       # full words of payload that are to come
        rest = Signal(rest_shape(lanes))            # bytes of payload in a word after these
        inside = Signal()                           # in the payload
        alone = Signal(range(_CHECKSUM_BYTES + 1))  # words without payload that are to come
        alone_later = Array(_words_alone(number, lanes) for number in range(lanes))[rest]
        last = Signal()                             # of the payload's words, this one
        step, complete = Signal(), Signal()
        under_way = inside | alone.any()
        m.submodules.checksum = checksum = Checksum(lanes)
        m.d.comb += [
            step.eq(under_way & valid),
            complete.eq(step & Mux(inside, last & (alone_later == 0), alone == 1)),
            checksum.start.eq(begin), checksum.valid.eq(step), checksum.data.eq(data),
            checksum.rest.eq(Mux(complete, rest + _CHECKSUM_BYTES, 0)),
            self.o.start.eq(begin), self.o.valid.eq(inside & step), self.o.data.eq(data),
            self.o.last.eq(last), self.o.rest.eq(rest),
        ]
        with m.If(begin):
            m.d.sync += [rest.eq(count & lanes - 1), left.eq(count >> exact_log2(lanes)),
                         last.eq(count <= lanes), inside.eq(1), alone.eq(0)]
        with m.Elif(~step):
            m.d.sync += [inside.eq(0), alone.eq(0)]
        with m.Elif(inside):
            m.d.sync += [left.eq(left - 1), last.eq(left == 1 + (rest == 0)), inside.eq(~last),
                         alone.eq(Mux(last, alone_later, 0))]
        with m.Else():
            m.d.sync += alone.eq(alone - 1)
        completed = delay(m, complete, checksum.latency, "completed", reset_less=False)
        return under_way & ~step, completed & ~checksum.good


def _words_alone(rest, lanes):
    """Words that have bytes of the checksum alone, if ``rest`` bytes of payload are in the last
    word of the payload, or it is full for 0."""
    free = (lanes - rest) % lanes
    return -(-max(0, _CHECKSUM_BYTES - free) // lanes)
