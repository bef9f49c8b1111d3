"""The table of valid rows: which corrected pixels have a source."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.frontend.layouts import SPANS
from ncdc_model.geometry import SPANS as SPANS_PER_ROW

__all__ = ["ValidTable"]


class ValidTable(wiring.Component):
    """Two banks of valid spans, one entry per corrected row, for the scan and for the host.

    Memory layout: entry ``bank * rows + row`` of memory k holds start and stop of span k (13 bits
    each). One read port serves both sides, the host first, so that each is a simple dual-port RAM
    of one write enable, which the narrow and deep shapes of block RAMs need.
    The scan holds ``row`` until ``fresh``; the host may read every other clock at most.

    Timing: ``spans`` follow ``row`` after one clock if the host does not read; ``host_spans``
    follow ``host_read`` after one clock.

    Parameters
    ----------
    valid : ncdc_model.geometry.ValidRows
        Content of both banks after configuration.
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

    def __init__(self, valid, rows):
        self.valid, self.row_bits = valid, ceil_log2(rows)
        part = SPANS["start0"].shape
        super().__init__({
            "bank": In(1), "row": In(self.row_bits), "spans": Out(SPANS), "fresh": Out(1),
            "host_bank": In(1), "host_row": In(self.row_bits), "host_span": In(1),
            "host_write": In(1), "host_read": In(1),
            "host_start": In(part), "host_stop": In(part),
            "host_span_start": Out(part), "host_span_stop": Out(part),
        })

    def elaborate(self, platform):
        m = Module()
        rows = 1 << self.row_bits
        bits = SPANS["start0"].width
        asked, host_span = Signal(1 + self.row_bits), Signal()
        wanted, host_address = Cat(self.row, self.bank), Cat(self.host_row, self.host_bank)
        by_scan = Signal()
        reads = []
        for k in range(SPANS_PER_ROW):
            entries = [start | stop << bits
                       for start, stop in self.valid.spans[:, 2 * k:2 * k + 2].tolist()]
            entries += [0] * (rows - len(entries))
            memory = Memory(shape=2 * bits, depth=2 * rows, init=entries * 2)
            m.submodules[f"memory{k}"] = memory
            write, read = memory.write_port(), memory.read_port()
            m.d.comb += [
                read.addr.eq(Mux(self.host_read, host_address, wanted)),
                write.addr.eq(host_address),
                write.data.eq(Cat(self.host_start, self.host_stop)),
                write.en.eq(self.host_write & (self.host_span == k)),
            ]
            reads.append(read.data)
        m.d.comb += [
            self.spans.eq(Cat(reads)), self.fresh.eq(by_scan & (asked == wanted)),
            Cat(self.host_span_start, self.host_span_stop).eq(Mux(host_span, *reads[::-1])),
        ]
        m.d.sync += [asked.eq(wanted), by_scan.eq(~self.host_read), host_span.eq(self.host_span)]
        return m
