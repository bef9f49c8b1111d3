"""From tiles to read commands."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.backend.cache.layouts import tile_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["TileRequests"]


class TileRequests(wiring.Component):
    """Makes one read command per row of a tile, top down::

        address = base + (H y + row) pitch + 16 x       H rows per tile

    Some rows of the lowest tiles may be below the frame: ``beyond``.

    Timing: at least ``latency`` clocks from a tile to its first address. While tiles wait
    and ``o`` is taken in each clock, an address leaves in each clock, also from tile to tile.

    Parameters
    ----------
    options : CacheOptions

    Members
    -------
    base, pitch : ``In``
        Address and row pitch of the raw frame in bytes, constant while tiles are under way.
    height : ``In(SIZE)``
        Rows of the raw frame, constant while tiles are under way.
    i : ``In(stream.Signature(tile_layout(options)))``
    o : ``Out(stream.Signature(32))``
        Byte address of 16 bytes.
    beyond : ``Out(1)``
        The row at ``o`` is below the frame.
    """

    latency = 5
    """Clocks from a tile to its first address: factors, product 2, address, row."""

    def __init__(self, options):
        self.options = options
        super().__init__({
            "base": In(ADDRESS_BITS), "pitch": In(SIZE), "height": In(SIZE),
            "i": In(stream.Signature(tile_layout(options))),
            "o": Out(stream.Signature(ADDRESS_BITS)), "beyond": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        tile_height = self.options.tile_height
        # F, P and M take a step together, so that a multiplier's registers have one enable, also
        # a register. They wait only while M and A both hold a tile. A is empty in one of two clocks
        # or more, and the rows of the tile that it passed on take as long.
        step = Signal(init=1)
        # F: the factors of the product, and the tile's column.
        f_x = Signal.like(self.i.p.x, reset_less=True)
        f_y = Signal.like(self.i.p.y, reset_less=True)
        f_pitch = Signal.like(self.pitch, reset_less=True)
        product = f_y * f_pitch
        # P: the product, in a register within the multiplier.
        p_x = Signal.like(f_x, reset_less=True)
        p_product = Signal(product.shape(), reset_less=True)
        # M: the product, and the address of the tile's column in the frame's first row.
        m_product = Signal.like(p_product, reset_less=True)
        m_start = Signal(ADDRESS_BITS, reset_less=True)
        with m.If(step):
            m.d.sync += [f_x.eq(self.i.p.x), f_y.eq(self.i.p.y), f_pitch.eq(self.pitch),
                         p_x.eq(f_x), p_product.eq(product),
                         m_product.eq(p_product), m_start.eq(self.base + p_x * TILE_WIDTH)]
        known = Signal(3)               # flags: there is a tile in F, P, M
        # A: the address of a tile's first row. O: those of its rows, one after the other.
        a_valid = Signal()                                  # there is a tile in stage A
        a_address = Signal(ADDRESS_BITS, reset_less=True)   # the address of its first row
        row = Signal(range(tile_height))                       # the row whose address is at ``o``
        done = Signal()                                     # ``o`` takes the address in stage A
        m.d.comb += [self.i.ready.eq(step),
                     done.eq(~self.o.valid | (self.o.ready & (row == tile_height - 1)))]
        m.d.sync += step.eq(~(Mux(step, known[1], known[2]) & Mux(a_valid, ~done, known[2])))
        with m.If(step):
            m.d.sync += known.eq(Cat(self.i.valid, known))
        with m.If(~a_valid):
            m.d.sync += [a_valid.eq(known[-1]), a_address.eq(m_start + m_product * tile_height)]
        with m.Elif(done):
            m.d.sync += a_valid.eq(0)
        # Flags of the lowest tiles, and the number of their rows in the frame, less one.
        last_row = Signal.like(self.height, reset_less=True)
        m.d.sync += last_row.eq(self.height - 1)
        p_lowest, m_lowest, a_lowest, o_lowest = (Signal(name=f"{stage}_lowest", reset_less=True)
                                                  for stage in "pmao")
        with m.If(step):
            m.d.sync += [p_lowest.eq(f_y == last_row[exact_log2(tile_height):]),
                         m_lowest.eq(p_lowest)]
        with m.If(~a_valid):
            m.d.sync += a_lowest.eq(m_lowest)
        with m.If(done):
            m.d.sync += o_lowest.eq(a_lowest)
        m.d.comb += self.beyond.eq(o_lowest & (row > last_row[:exact_log2(tile_height)]))
        with m.If(done):
            m.d.sync += [self.o.valid.eq(a_valid), self.o.payload.eq(a_address), row.eq(0)]
        with m.Elif(self.o.ready):
            m.d.sync += [self.o.payload.eq(self.o.payload + self.pitch), row.eq(row + 1)]
        return m
