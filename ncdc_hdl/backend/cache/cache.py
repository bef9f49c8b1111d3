"""The prefetching tile cache: a fetcher that reads nearly every sample once."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost
from ncdc_hdl.backend.cache.boxes import Boxes
from ncdc_hdl.backend.cache.fills import Fills
from ncdc_hdl.backend.cache.layouts import banks_for, lanes_set_to, set_bits, stalls_layout
from ncdc_hdl.backend.cache.locate import Locate
from ncdc_hdl.backend.cache.retire import Retire
from ncdc_hdl.backend.cache.tags import Tags
from ncdc_hdl.backend.cache.tiles import Tiles
from ncdc_hdl.backend.layouts import request_layout, window_layout
from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.credits import Credited
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_hdl.lib.pipeline import register
from ncdc_hdl.lib.relay import Relay
from ncdc_spec.cache_options import TILE_MEMORIES, CacheOptions

__all__ = ["Cache"]


class Cache(wiring.Component):
    """Fetch of windows through a cache with prefetched misses.

    Each window is looked up as soon as its position is known. Missing tiles are claimed and
    requested at once, and the window waits in a queue for them. Windows leave in order; a
    blank request reads nothing. Byte (x, y) of the raw frame is at ``base + y pitch + x``; tiles
    are 16 bytes by 4 rows, or 2. Those at the frame's edges reach up to 15 bytes and 3
    rows beyond it; their parts outside the frame's memory area are not read.

    Timing: one group per clock, for any memory latency that ``pending`` windows and
    ``outstanding`` tiles hide it; stalls: see ``Tags``. With "shared" tiles no group is read in the
    clocks in which words from memory are written. Requests marked ``last`` end
    a frame: after it the cache is cleared, in as many clocks as it has sets.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the position in the window.
    data_width : int
        Bits of a memory word: 32, 64 or 128.
    options : CacheOptions
        Sizes, and the interpolation whose windows are fetched.
    lanes : int
        Windows of a group, 1, 2 or 4. A group is looked up in one clock if its samples fit a box,
        see ``Boxes``, and else in two or more.
    raw_balance : bool
        Whether samples have gains before they are stored.
    tile_memory : str
        As of :class:`~ncdc_hdl.backend.cache.tiles.Tiles`.

    Members
    -------
    base, limit, pitch, height : ``In``
        Area of the raw frame, see :class:`Fills`; constant during a frame.
    balance : ``In(BALANCE)``
        Gains of the raw samples, constant during a frame; only with ``raw_balance``.
    split : ``In``
        log2 Kx of the index rule, constant during a frame.
    phase : ``In(2)``
        (column, row) parity of the red samples, constant during a frame and ``lanes`` + 1 clocks
        before it, for windows with a margin.
    memory_rst : ``In(1)``
        As in :class:`ncdc_hdl.avalon.read_commands.ReadCommands`.
    i : ``In(stream.Signature(request_layout(f_bits, lanes, options.interpolation)))``
    o : ``Out(Credited(window_layout(f_bits, lanes, options.interpolation)))``
        A window comes ``window_latency`` clocks after its ``issue``.
    bus0 : ``Out(ReadHost(...))``
    outside, empty : ``Out(1)``
        As in :class:`Fills`.
    fetched : ``Out(1)``
        High for one clock per tile requested.
    waiting : ``Out(1)``
        The oldest window waits for a tile.
    stalls : ``Out(stalls_layout())``
        Reason why the tag stage does not move, see :class:`Tags`.
    """

    ports = 1

    def __init__(self, f_bits, data_width, options=CacheOptions(), lanes=1, raw_balance=False,
                 tile_memory=TILE_MEMORIES[0]):
        self.f_bits, self.data_width, self.options, self.lanes = f_bits, data_width, options, lanes
        needs = options.interpolation
        banks = banks_for(data_width, lanes, needs, tile_memory == "shared")
        # The tag stage's stalls end here, and not in the stages that compute the windows.
        self.entry = Relay(request_layout(f_bits, lanes, needs))
        self.boxes = Boxes(f_bits, lanes, needs)
        self.locate = Locate(f_bits, options, lanes)
        self.tags = Tags(f_bits, options, lanes)
        self.raw_balance = raw_balance
        self.fills = Fills(options, data_width, banks, raw_balance)
        self.tiles = Tiles(options, banks, tile_memory)
        # Each box belongs to one group: so many groups at most are on their way to the queue.
        before = self.boxes.latency + self.locate.capacity + self.tags.latency
        self.retire = Retire(f_bits, options, banks, lanes, before, self.tiles.shared)
        super().__init__({
            "base": In(ADDRESS_BITS), "limit": In(ADDRESS_BITS), "pitch": In(SIZE),
            "height": In(SIZE), "memory_rst": In(1), "outside": Out(1), "empty": Out(1),
            **({"balance": In(BALANCE, init=NO_BALANCE)} if raw_balance else {}),
            "split": In(range(set_bits(options) + 1)),
            "i": In(stream.Signature(request_layout(f_bits, lanes, needs))),
            "o": Out(Credited(window_layout(f_bits, lanes, needs))),
            "bus0": Out(ReadHost(data_width, self.fills.burst)),
            "fetched": Out(1), "waiting": Out(1), "stalls": Out(stalls_layout()),
        } | ({"phase": In(2)} if needs.margin else {}))

    @property
    def start_latency(self):
        """Clocks from a group at ``i`` to its first look-up in the act stage."""
        return (self.entry.latency + self.boxes.latency + self.locate.latency
                + self.tags.latency)

    @property
    def window_latency(self):
        """Clocks from ``o.issue`` to the window."""
        return self.retire.latency

    def elaborate(self, platform):
        m = Module()
        for name in ("entry", "boxes", "locate", "tags", "fills", "tiles", "retire"):
            m.submodules[name] = getattr(self, name)
        locate, tags, fills, tiles, retire = (self.locate, self.tags, self.fills, self.tiles,
                                              self.retire)
        wiring.connect(m, wiring.flipped(self.i), self.entry.i)
        wiring.connect(m, self.entry.o, self.boxes.i)
        wiring.connect(m, self.boxes.o, locate.i)
        wiring.connect(m, locate.o, tags.i)
        wiring.connect(m, retire.o, wiring.flipped(self.o))
        wiring.connect(m, fills.bus, wiring.flipped(self.bus0))
        if self.raw_balance:
            m.d.comb += fills.balance.eq(self.balance)
        m.d.comb += [
            locate.split.eq(self.split), tiles.split.eq(self.split),
            fills.base.eq(self.base), fills.pitch.eq(self.pitch),
            fills.limit.eq(self.limit), fills.height.eq(self.height),
            fills.memory_rst.eq(self.memory_rst),
            self.outside.eq(fills.outside), self.empty.eq(fills.empty),
            fills.claim.eq(tags.claim), fills.tile.eq(tags.tile), tags.credit.eq(fills.credit),
            tiles.fill.eq(fills.fill), retire.filled.eq(fills.filled),
            retire.push.eq(tags.push), retire.position.eq(tags.position),
            retire.missing.eq(tags.missing),
            tags.retire.eq(retire.retire),
            tiles.load.eq(retire.load), tiles.box.eq(retire.box),
            retire.samples.eq(tiles.samples),
            self.fetched.eq(tags.claim), self.waiting.eq(retire.waiting),
            self.stalls.eq(tags.stalls),
        ]
        if tiles.shared:
            m.d.comb += retire.written.eq(fills.fill.enable.any())
        if self.lanes > 1:
            group = self.boxes.i
            m.d.comb += [retire.enters.eq(group.valid & group.ready),
                         *lanes_set_to(retire.group, group.p)]
        if self.options.interpolation.margin:
            # So the windows' even columns and even rows meet in green samples.
            odd_rows = register(m, "odd_rows", ~self.phase.xor())
            m.d.comb += [tiles.odd_rows.eq(odd_rows), retire.odd_rows.eq(odd_rows)]
        return m
