"""Fills of the tile cache: credits, the order of tiles, and when a slot is written."""

from amaranth import *
from amaranth.lib.wiring import In

from formal.avalon import MEMORY, check_read_host, taken_away
from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.backend.cache.fills import Fills
from ncdc_hdl.backend.cache.layouts import banks_for, tile_layout
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST

__all__ = ["FillOrder", "FillSpace"]


class _Fills(Wrapper):
    """``Fills`` with any claims that the credit allows."""

    def __init__(self, dut):
        self.dut = dut
        self.rows = dut.options.tile_height
        self.beats = self.rows * dut.burst
        self.limit = dut.options.outstanding * self.beats
        super().__init__({
            "claim": In(1), "tile": In(tile_layout(dut.options)), "data": In(dut.data_width)}
            | MEMORY | self.more())

    def more(self):
        """Further inputs."""
        return {}

    def start(self, m):
        """The design with its claims and any memory; the design's parts, words owed."""
        dut = self.dut
        fragment = self.design(m, dut)
        owed = check_read_host(m, dut.bus, self, limit=self.limit)
        given(m, ~self.claim | dut.credit)
        # A buffer of 64 kbytes; what is outside is moved to its begin.
        m.d.comb += [dut.limit.eq(1 << 16), dut.height.eq(64)]
        m.d.comb += [dut.memory_rst.eq(self.memory_rst),
                     dut.claim.eq(self.claim), dut.tile.eq(self.tile)]
        return fragment, owed


class FillSpace(_Fills):
    """Reset at any time, the memory too or not: no more tiles than allowed, and space for all.

    Asserts that no queue overflows, that each word comes for a tile that was claimed, and that
    the memory never owes more than ``outstanding`` tiles.
    """

    def __init__(self, data_width=128, outstanding=2, kind=Fills, needs=FAST):
        options = CacheOptions(tiles=16, pending=4, outstanding=outstanding, sequence_bits=4,
                               interpolation=needs)
        super().__init__(kind(options, data_width, banks_for(data_width, 1, needs)))

    def elaborate(self, platform):
        m = Module()
        dut, most, beats = self.dut, self.dut.options.outstanding, self.beats
        fragment, owed = self.start(m)
        claimed, slots = self.queues
        read, words = dut.bus.read, dut.bus.burstcount
        due, some, stale = (inner(fragment, "commands", name) for name in ("due", "some", "stale"))
        coming, outstanding = inner(fragment, "coming"), inner(fragment, "outstanding")
        claim, came, complete = (inner(fragment, name) for name in ("claim", "came", "complete"))
        a_valid, row, o_valid, known, step = (
            inner(fragment, "requests", name)
            for name in ("a_valid", "row", "o__valid", "known", "step"))
        relayed, free, full, offered, aside = (
            inner(fragment, "fence", "relay", name)
            for name in ("o__valid", "free", "full", "o", "aside"))
        always(m, full == ~free, "full_flag")
        # Words that will come: of tiles claimed and in the queue, in the stages of the requests,
        # of commands in the relay, of the command on the bus, owed by the memory.
        asked = Signal(range(16 * self.limit))
        m.d.comb += asked.eq(
            (claim + claimed.level + sum(known) + a_valid) * beats
            + Mux(o_valid, (self.rows - row) * dut.burst, 0)
            + (relayed + ~free) * dut.burst
            + Mux(stale, 0, Mux(read, words, 0) + owed))
        always(m, (due == owed) & (some == (due != 0)), "owed_is_known")
        always(m, owed + Mux(read, words, 0) <= self.limit, "space_for_command")
        always(m, words <= dut.burst, "burst")
        always(m, ~read | (words == dut.burst), "burst_constant")
        always(m, ~relayed | (offered[ADDRESS_BITS:-1] == dut.burst), "burst_relayed")
        always(m, free | (relayed & (aside[ADDRESS_BITS:-1] == dut.burst)), "burst_aside")
        always(m, o_valid | (row == 0), "row")
        lost = taken_away(m, self.memory_rst, (asked != 0) | self.claim)
        always(m, lost | (asked + coming + complete * beats == (claim + slots.level) * beats),
               "a_word_for_each_beat")
        always(m, ~lost | stale, "lost_is_stale")
        always(m, claimed.level <= slots.level, "a_slot_for_each_claim")
        always(m, (outstanding == claim + slots.level) & (outstanding <= most), "outstanding")
        always(m, dut.credit == (outstanding != most), "credit_flag")
        always(m, step == ~(known[-1] & a_valid), "step")
        always(m, ~complete | (came & (coming == 0)), "complete_with_its_last_word")
        # Slots are as far as tiles, or as far as they can be.
        (claimed_ready, _), (claimed_read, _) = claimed.output
        (slot_ready, _), (slot_read, _) = slots.output
        always(m, (slot_ready & slot_read) | (slots.level - slot_ready - slot_read
                                              <= claimed.level - claimed_ready - claimed_read),
               "slots_keep_up")
        always(m, slot_ready | ((slots.level == claimed.level) & ~claimed_ready), "slot_first")
        always(m, ~came | (slots.level != 0), "claimed_before")
        always(m, ~came | slots.r_rdy, "slot_known")
        reached(m, (outstanding == most) & (owed == self.limit), "all_owed")
        reached(m, dut.filled & self.claim & ~stale, "claim_while_filled")
        return m


class FillOrder(_Fills):
    """Without resets: the words of each tile come from its rows and go to its slot, in order.

    One claim, any, is watched. Its words are asked for at its addresses only, one command per
    row; they are written to its slot, row by row, between the claim and ``filled``; its slot is
    not written between by words of another claim. Claims are filled in order.
    """

    PITCH = 64

    def __init__(self, data_width=128, kind=Fills, needs=FAST):
        options = CacheOptions(tiles=16, pending=4, outstanding=2, sequence_bits=4,
                               interpolation=needs)
        super().__init__(kind(options, data_width, banks_for(data_width, 1, needs)))

    def more(self):
        return {"watch": In(1)}

    def elaborate(self, platform):
        m = Module()
        dut, most, beats = self.dut, self.dut.options.outstanding, self.beats
        given(m, ~ResetSignal() & ~self.memory_rst)
        # The address names tile and row: row pitch 64, two bits of x and of y.
        given(m, (self.tile.x < 4) & (self.tile.y < 4))
        m.d.comb += dut.pitch.eq(self.PITCH)
        fragment, owed = self.start(m)
        # The watched claim and how many claims, commands and words are in front of it.
        watching = Signal()
        tile = Signal(self.tile.shape())
        total = Signal(range(8))
        ahead = Signal(range(most + 1))           # tiles to be filled until it is, itself included
        commands, arrivals = Signal(range(64)), Signal(range(256))   # since the start
        first = Signal(range(8))                  # claims in front of it
        accepted = dut.bus.read & ~self.waitrequest
        outstanding = Signal(range(most + 2))
        mark = self.watch & self.claim & ~watching
        m.d.sync += [outstanding.eq(outstanding + self.claim - dut.filled),
                     commands.eq(commands + accepted), arrivals.eq(arrivals + self.readdatavalid),
                     total.eq(total + self.claim)]
        with m.If(mark):
            m.d.sync += [watching.eq(1), tile.eq(self.tile), first.eq(total),
                         ahead.eq(outstanding + 1 - dut.filled)]
        with m.Elif(dut.filled & (ahead != 0)):
            m.d.sync += ahead.eq(ahead - 1)
        # The command for its row k is number 4 first + k, those before and after are not.
        row = (commands - self.rows * first)[:6]
        mine = watching & accepted & (row < self.rows)
        address = (tile.y * self.rows + row) * self.PITCH + (tile.x << 4)
        always(m, ~mine | (dut.bus.address == address),
               "address")
        # Writes follow the words.
        written, came = (delay(m, value, dut.filled_latency, name, reset_less=False)
                         for value, name in ((arrivals, "arrivals"), (self.readdatavalid, "came")))
        beat = (written - beats * first)[:8]
        writes = came & watching & (beat < beats)
        always(m, ~writes | ((dut.fill.slot == tile.slot) & (dut.fill.row == beat // dut.burst)),
               "slot")
        always(m, ~writes | (ahead == 1), "only_while_claimed")
        always(m, ~(dut.fill.enable.any()) | came, "nothing_else_written")
        always(m, ~(watching & dut.filled & (ahead == 1)) | (came & (beat == beats - 1)),
               "filled_with_the_last_word")
        reached(m, writes & (beat == beats - 1) & (first == 1), "second_tile")
        return m
