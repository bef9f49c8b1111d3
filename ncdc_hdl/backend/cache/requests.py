"""From tiles to read commands."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.backend.cache.layouts import tile_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_model.fetch.cache_options import TILE_HEIGHT, TILE_WIDTH

__all__ = ["TileRequests"]


class TileRequests(wiring.Component):
    """One read command per row of a tile, top down::

        address = base + (4 y + row) pitch + 16 x

    Timing: two clocks from a tile to its first address; tiles follow each other without a gap.

    Parameters
    ----------
    options : CacheOptions

    Members
    -------
    base, pitch : ``In``
        Of the raw frame in bytes, constant while tiles are under way.
    i : ``In(stream.Signature(tile_layout(options)))``
    o : ``Out(stream.Signature(32))``
        Byte address of 16 bytes.
    """

    def __init__(self, options):
        super().__init__({
            "base": In(ADDRESS_BITS), "pitch": In(SIZE),
            "i": In(stream.Signature(tile_layout(options))),
            "o": Out(stream.Signature(ADDRESS_BITS)),
        })

    def elaborate(self, platform):
        m = Module()
        # M: multiply. O: the four rows.
        m_valid = Signal()
        m_offset, m_start = Signal(ADDRESS_BITS), Signal(ADDRESS_BITS)
        row = Signal(range(TILE_HEIGHT))
        done = Signal()
        m.d.comb += done.eq(~self.o.valid | (self.o.ready & (row == TILE_HEIGHT - 1)))
        with m.If(~m_valid | done):
            m.d.comb += self.i.ready.eq(1)
            m.d.sync += [
                m_valid.eq(self.i.valid),
                m_offset.eq((self.i.p.y * self.pitch) * TILE_HEIGHT),
                m_start.eq(self.base + self.i.p.x * TILE_WIDTH),
            ]
        with m.If(done):
            m.d.sync += [self.o.valid.eq(m_valid), self.o.payload.eq(m_start + m_offset),
                         row.eq(0)]
        with m.Elif(self.o.ready):
            m.d.sync += [self.o.payload.eq(self.o.payload + self.pitch), row.eq(row + 1)]
        return m
