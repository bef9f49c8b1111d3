"""The table of valid rows: marks the corrected pixels with a source."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In
from amaranth.utils import ceil_log2

from ncdc_hdl.frontend.signatures import SpansRequest, TableAccess
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.geometry import SPANS as SPANS_PER_ROW

__all__ = ["FixedValidTable", "ValidTable"]


class _Rows:
    """What both kinds of table have: how many rows and columns, and their contents."""

    latency = 3
    """Clocks from a request of either side to its answer: its address, which goes to block RAMs all
    over a device, the memory, its output register."""

    def __init__(self, valid, columns, rows, members):
        self.valid, self.row_bits = valid, ceil_log2(rows)
        self.column_bits = columns.bit_length()
        super().__init__({"scan": In(SpansRequest())} | members)

    @property
    def max_column(self):
        """The largest start or stop that a span can have."""
        return (1 << self.column_bits) - 1

    @property
    def largest(self):
        """Width and height of the largest picture whose spans the table holds."""
        return min(self.max_column, MAX_SIZE), min(1 << self.row_bits, MAX_SIZE)

    def _entries(self, k):
        """Words of span k of each row: start, and stop above it."""
        entries = [start | stop << self.column_bits
                   for start, stop in self.valid.spans[:, 2 * k:2 * k + 2].tolist()]
        return entries + [0] * ((1 << self.row_bits) - len(entries))


class ValidTable(_Rows, wiring.Component):
    """Two banks of valid spans, one entry per corrected row, for the scan and for the host.

    Memory layout: entry ``bank * rows + row`` of memory k holds start and stop of span k, with as
    many bits as ``columns`` needs. Further bits are dropped. One read port serves
    both sides, the host first, so that each memory is a simple dual-port RAM of one write enable,
    which the narrow and deep shapes of block RAMs need. Writes of the host to a row that the
    table does not have are ignored.

    Timing: ``scan.spans`` follow ``scan.row`` after ``latency`` clocks if the host does not read;
    ``host.read_start`` and ``host.read_stop`` follow ``host.read`` likewise.

    Parameters
    ----------
    valid : ncdc_spec.geometry.ValidRows
        Content of both banks after configuration.
    columns : int
        Pixels of a row, at least those of ``valid``; the largest value is ``max_column``.
    rows : int
        Rows of one bank, at least those of ``valid``; rounded up to a power of two.

    Members
    -------
    bank : ``In(1)``
        The bank that the scan reads; constant during a frame.
    scan : ``In(SpansRequest())``
        ``fresh`` is high if the answer is that of this ``bank`` and ``row``.
    host : ``In(TableAccess())``
    """

    def __init__(self, valid, columns, rows):
        super().__init__(valid, columns, rows, {"bank": In(1), "host": In(TableAccess())})

    def elaborate(self, platform):
        m = Module()
        scan, host = self.scan, self.host
        rows, bits = 1 << self.row_bits, self.column_bits
        wanted = Cat(scan.row[:self.row_bits], self.bank)
        host_address = Cat(host.row[:self.row_bits], host.bank)
        host_row_exists = host.row[self.row_bits:] == 0
        # A: the addresses of a read and of a write, and its word.
        address = register(m, "address", Mux(host.read, host_address, wanted))
        written = register(m, "written", host_address)
        word = register(m, "word", Cat(host.start[:bits], host.stop[:bits]))
        # M: a memory for each span of a row; followed by its output register.
        starts, stops = [], []
        for k in range(SPANS_PER_ROW):
            # A frame's bank is not written, and the host does one access at a time. No word is used
            # that was read in the clock of its write.
            m.submodules[f"memory{k}"] = memory = block_memory(
                2 * bits, 2 * rows, self._entries(k) * 2)
            write, read = memory.write_port(), memory.read_port()
            m.d.comb += [read.addr.eq(address), write.addr.eq(written), write.data.eq(word)]
            m.d.sync += write.en.eq(host.write & host_row_exists & (host.span == k))
            entry = register(m, f"entry{k}", read.data)
            starts.append(entry[:bits])
            stops.append(entry[bits:])
        # Request in the output registers: whether the scan's, its row, the host's span.
        by_scan = delay(m, ~host.read, self.latency, "by_scan", reset_less=False)
        asked = delay(m, wanted, self.latency, "asked")
        host_span = delay(m, host.span, self.latency, "host_span")
        m.d.comb += [
            scan.fresh.eq(by_scan & (asked == wanted)),
            scan.spans.start0.eq(starts[0]), scan.spans.stop0.eq(stops[0]),
            scan.spans.start1.eq(starts[1]), scan.spans.stop1.eq(stops[1]),
            host.read_start.eq(Mux(host_span, *starts[::-1])),
            host.read_stop.eq(Mux(host_span, *stops[::-1])),
        ]
        return m


class FixedValidTable(_Rows, wiring.Component):
    """One bank of valid spans that is never written, for the scan alone.

    Timing: ``scan.spans`` follow ``scan.row`` after ``latency`` clocks.

    Parameters
    ----------
    valid, columns, rows : as for :class:`ValidTable`

    Members
    -------
    scan : ``In(SpansRequest())``
    """

    def __init__(self, valid, columns, rows):
        super().__init__(valid, columns, rows, {})

    def elaborate(self, platform):
        m = Module()
        row, spans = self.scan.row[:self.row_bits], self.scan.spans
        asked = delay(m, row, self.latency, "asked")
        m.d.comb += self.scan.fresh.eq(asked == row)
        address = register(m, "address", row)
        for k in range(SPANS_PER_ROW):
            m.submodules[f"memory{k}"] = memory = block_memory(
                2 * self.column_bits, 1 << self.row_bits, self._entries(k))
            read = memory.read_port()
            m.d.comb += read.addr.eq(address)
            entry = register(m, f"entry{k}", read.data)
            m.d.comb += [spans[f"start{k}"].eq(entry[:self.column_bits]),
                         spans[f"stop{k}"].eq(entry[self.column_bits:])]
        return m
