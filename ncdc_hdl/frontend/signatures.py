"""Interfaces of the table of valid rows: to the scan, and to the host's registers."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import SIZE, SPANS
from ncdc_spec.geometry import MAX_SIZE

__all__ = ["SpansRequest", "TableAccess"]


class SpansRequest(wiring.Signature):
    """The scan requests the valid spans of a row; directions are those of the scan.

    Members
    -------
    row : ``Out(SIZE)``
        The row requested; held until ``fresh``.
    spans : ``In(SPANS)``
        The answer, some clocks late.
    fresh : ``In(1)``
        High while ``spans`` belongs to this ``row``.
    """

    def __init__(self):
        super().__init__({"row": Out(SIZE), "spans": In(SPANS), "fresh": In(1)})


class TableAccess(wiring.Signature):
    """The host writes and reads one span of the table; directions are those of the registers.

    Members
    -------
    bank, row, span : ``Out``
        Bank and row of the span, and whether it is the row's first or second one.
    write : ``Out(1)``
        The span becomes ``start`` and ``stop``; nothing happens if the table has no such row.
    start, stop : ``Out(SIZE)``
        First column of the span to be written, and the one after its last column.
    read : ``Out(1)``
        The span is read; at most in every other clock.
    read_start, read_stop : ``In(SIZE)``
        The span, ``ValidTable.latency`` clocks after ``read``; any value at other times.
    """

    def __init__(self):
        super().__init__({
            "bank": Out(1), "row": Out(range(MAX_SIZE)), "span": Out(1),
            "write": Out(1), "start": Out(SIZE), "stop": Out(SIZE),
            "read": Out(1), "read_start": In(SIZE), "read_stop": In(SIZE),
        })
