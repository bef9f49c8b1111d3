"""The table of valid rows for a view: any row for each pixel."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, connect

from ncdc_hdl.frontend.signatures import SpansRequest, TableAccess
from ncdc_hdl.frontend.valid import ValidTable

__all__ = ["ViewTable"]


class ViewTable(wiring.Component):
    """A :class:`ValidTable` for the host, and a copy of it for each lane, which the host only
    writes: a lookup never waits.

    Parameters
    ----------
    valid, columns, rows : as for :class:`ValidTable`
    lanes : int
        Pixels per clock.

    Members
    -------
    bank : ``In(1)``
        The bank that the lanes read; constant during a frame.
    scan : ``In(SpansRequest()).array(lanes)``
        Spans follow the row after ``ValidTable.latency`` clocks.
    host : ``In(TableAccess())``
    """

    def __init__(self, valid, columns, rows, lanes):
        self.of_host = ValidTable(valid, columns, rows)
        self.of_lanes = [ValidTable(valid, columns, rows) for _ in range(lanes)]
        super().__init__({
            "bank": In(1), "scan": In(SpansRequest()).array(lanes), "host": In(TableAccess())})

    @property
    def largest(self):
        """Width and height of the largest picture whose spans the table holds."""
        return self.of_host.largest

    def elaborate(self, platform):
        m = Module()
        m.submodules.of_host = self.of_host
        connect(m, wiring.flipped(self.host), self.of_host.host)
        for k, table in enumerate(self.of_lanes):
            m.submodules[f"of_lane{k}"] = table
            connect(m, wiring.flipped(self.scan[k]), table.scan)
            m.d.comb += [table.bank.eq(self.bank),
                         *(getattr(table.host, name).eq(getattr(self.host, name))
                           for name in ("bank", "row", "span", "write", "start", "stop"))]
        return m
