"""The table of valid rows: which corrected pixels have a source."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.frontend.layouts import SPANS
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_model.geometry import SPANS as SPANS_PER_ROW

__all__ = ["ValidTable"]


class ValidTable(wiring.Component):
    """Two banks of valid spans, one entry per corrected row, for the scan and for the host.

    Memory layout: entry ``bank * rows + row`` of memory k holds start and stop of span k, of as
    many bits as ``columns`` needs; of other values the bits above are lost. One read port serves both
    sides, the host first, so that each is a simple dual-port RAM of one write enable, which the
    narrow and deep shapes of block RAMs need.
    The scan holds ``row`` until ``fresh``; the host may read every other clock at most.

    Timing: ``spans`` follow ``row`` after ``latency`` clocks if the host does not read;
    ``host_span_start`` and ``host_span_stop`` follow ``host_read`` after as many.

    Parameters
    ----------
    valid : ncdc_model.geometry.ValidRows
        Content of both banks after configuration.
    columns : int
        Pixels of a row, at least those of ``valid``; the largest value is ``max_column``.
    rows : int
        Rows of one bank, at least those of ``valid``; rounded up to a power of two.

    Members
    -------
    bank, row : ``In``
        What the scan asks for.
    spans, fresh : ``Out(SPANS)``, ``Out(1)``
        The answer, and whether it is that of the current ``bank`` and ``row``.
    host_bank, host_row, host_span, host_write, host_read : ``In``
        Access to one of the spans of a row.
    host_start, host_stop, host_span_start, host_span_stop : ``In``, ``Out``
        Data to write and data read.
    """

    latency = 2     # the memory, and its output register

    def __init__(self, valid, columns, rows):
        self.valid, self.row_bits = valid, ceil_log2(rows)
        self.column_bits = columns.bit_length()
        part = SPANS["start0"].shape
        super().__init__({
            "bank": In(1), "row": In(self.row_bits), "spans": Out(SPANS), "fresh": Out(1),
            "host_bank": In(1), "host_row": In(self.row_bits), "host_span": In(1),
            "host_write": In(1), "host_read": In(1),
            "host_start": In(part), "host_stop": In(part),
            "host_span_start": Out(part), "host_span_stop": Out(part),
        })

    @property
    def max_column(self):
        """The largest start or stop that a span can have."""
        return (1 << self.column_bits) - 1

    def elaborate(self, platform):
        m = Module()
        rows, bits = 1 << self.row_bits, self.column_bits
        wanted, host_address = Cat(self.row, self.bank), Cat(self.host_row, self.host_bank)
        starts, stops = [], []
        for k in range(SPANS_PER_ROW):
            entries = [start | stop << bits
                       for start, stop in self.valid.spans[:, 2 * k:2 * k + 2].tolist()]
            entries += [0] * (rows - len(entries))
            # A frame's bank is not written, and the host does one thing at a time: no word is used
            # that was read in the clock of its write.
            m.submodules[f"memory{k}"] = memory = block_memory(2 * bits, 2 * rows, entries * 2)
            write, read = memory.write_port(), memory.read_port()
            m.d.comb += [
                read.addr.eq(Mux(self.host_read, host_address, wanted)),
                write.addr.eq(host_address),
                write.data.eq(Cat(self.host_start[:bits], self.host_stop[:bits])),
                write.en.eq(self.host_write & (self.host_span == k)),
            ]
            entry = register(m, f"entry{k}", read.data)
            starts.append(entry[:bits])
            stops.append(entry[bits:])
        by_scan = delay(m, ~self.host_read, self.latency, "by_scan", reset_less=False)
        asked = delay(m, wanted, self.latency, "asked")
        host_span = delay(m, self.host_span, self.latency, "host_span")
        m.d.comb += [
            self.fresh.eq(by_scan & (asked == wanted)),
            self.spans.start0.eq(starts[0]), self.spans.stop0.eq(stops[0]),
            self.spans.start1.eq(starts[1]), self.spans.stop1.eq(stops[1]),
            self.host_span_start.eq(Mux(host_span, *starts[::-1])),
            self.host_span_stop.eq(Mux(host_span, *stops[::-1])),
        ]
        return m
