"""The front end of the corrector, alone: network at nodes, coordinates between them, the table of
valid rows. Each coordinate is seen with all its bits."""

from dataclasses import replace

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from banks import bank_words
from front_end import expected, extreme
from mutation.core import FOCAL, cameras, large_cameras, whole_view
from mutation.core import make as make_corrector
from mutation.nodes import any_network
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.frontend.signatures import TableAccess
from ncdc_spec.geometry import SPANS, ValidRows
from simulations.player import Player
from views import nonsense_view, random_view

__all__ = ["DESIGN"]


class Front(wiring.Component):
    """The front end joined to its table as in the corrector.

    Members: those of :class:`ncdc_hdl.frontend.node_backmap.NodeBackMap` but ``table``; ``bank``
    and the inputs of ``host`` of the table; ``quiet``: no frame is under way.
    """
    def __init__(self):
        corrector = make_corrector()
        self.backmap, self.valid = corrector.backmap, corrector.table
        members = self.backmap.signature.members
        host = {name: member for name, member in TableAccess().members.items()
                if member.flow is Out}
        super().__init__({name: member for name, member in members.items() if name != "table"} | {
            "bank": In(1), "host": In(wiring.Signature(host)), "quiet": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.backmap, m.submodules.table = backmap, table = self.backmap, self.valid
        wiring.connect(m, backmap.table[0], table.scan[0])
        for name in self.host.signature.members:
            m.d.comb += getattr(table.host, name).eq(getattr(self.host, name))
        wiring.connect(m, backmap.o, wiring.flipped(self.o))
        wiring.connect(m, wiring.flipped(self.writes), backmap.writes)
        m.d.comb += table.bank.eq(self.bank)
        for name in ("start", "abort", "scan", "view", "network"):
            m.d.comb += getattr(backmap, name).eq(getattr(self, name))
        for name in ("idle", "stalled", "cut"):
            m.d.comb += getattr(self, name).eq(getattr(backmap, name))
        with m.If(self.o.valid & self.o.ready & self.o.p.last):
            m.d.sync += self.quiet.eq(1)
        with m.If(self.start):
            m.d.sync += self.quiet.eq(0)
        return m


def _any(rng, number, small, reach):
    """A descriptor of any lens and valid rows; a view, of ``small`` frames mostly one that makes no
    sense; the strips' width. ``reach``: that of networks of any weights, or 0 for those of lenses.
    """
    large = number % 8 == 3 and not small
    descriptor = (large_cameras()[number // 8 % 2] if large else cameras()[number % 2])[0]
    width, height = descriptor.geometry.corrected
    spans = np.sort(rng.integers(0, width, (height, 2 * SPANS), endpoint=True), axis=1)
    spans[rng.random(height) < .3] = [0, width, 0, 0]
    if number % 5 == 4:
        descriptor = extreme(descriptor, number)
    elif reach:                                 # values that jump from node to node
        descriptor = any_network(rng, descriptor, reach * int(rng.integers(1, 5)))
    descriptor = replace(descriptor, valid=ValidRows(spans))
    size = tuple(int(side) for side in rng.integers(8, (40, 10) if small else (140, 24)))
    strip = int(rng.choice([0, 0, 32, 64]))
    if number % 8 == 7 and not small:
        size = [(2731, 8), (1365, 9), (8, 1365), (4096, 8)][number // 8 % 4]
    if large:
        long, short = int(rng.integers(24, 140)), int(rng.integers(8, 24))
        size = (long, short) if width > height else (short, long)
        return descriptor, whole_view(rng, descriptor.geometry, size), strip
    if number % 3 == 2 or small and number % 3:
        return descriptor, nonsense_view(rng, size), strip
    return descriptor, random_view(rng, descriptor.geometry, FOCAL, size, pan=50, roll=180,
                                   zoom=(.3, 4)), strip


def _load(player, descriptor, view, strip, bank, empty):
    """Write weights and valid rows to ``bank``, and set the rest of a frame, which may be
    ``empty``."""
    for position, word in bank_words(descriptor.hidden_weights, descriptor.hidden_biases,
                                     descriptor.output_weights):
        player.put(writes__write=1, writes__position=position, writes__word=word,
                   writes__bank=bank)
    player.put(writes__write=0)
    for row, spans in enumerate(descriptor.valid.spans.tolist()):
        for span in range(SPANS):
            start, stop = spans[2 * span:][:2]
            player.put(host__write=1, host__bank=bank, host__row=row, host__span=span,
                       host__start=start, host__stop=stop)
    for row in (0, descriptor.geometry.corrected_height // 2):     # without a write
        player.put(host__write=0, host__row=row, host__start=0, host__stop=row)
    origin_x, step_x, origin_y, step_y = descriptor.geometry.scan()
    (width, height), rows = view.size, descriptor.geometry.corrected_height
    player.put(
        8, host__write=0, writes__active=bank, bank=bank,
        scan={"width": width, "height": 0 if empty else height, "strip": strip,
              "origin_x": origin_x, "step_x": step_x, "origin_y": origin_y, "step_y": step_y},
        view={"matrix": np.reshape(view.matrix, (3, 3)).tolist(), "plane_height": rows},
        network={"output": [{"bias": int(one)} for one in descriptor.output_biases]})


def _play(verilog, transcripts, seed, count, *, aborts=False, small=False, reach=0,
          **plusargs):
    """Frames of any lenses and views; each must be the golden one, or its beginning. With
    ``aborts`` some are empty, which have one blank group."""
    rng = np.random.default_rng(seed)
    player, wanted = Player(Front(), ("blank", 1, ("x", "y"))), []
    for number in range(count):
        descriptor, view, strip = _any(rng, number, small, reach)
        empty = aborts and number % 10 == 9
        _load(player, descriptor, view, strip, number % 2, empty)
        player.put(start=1, abort=0)
        if aborts and number % 4:
            player.put(int(rng.integers(1, 700)), start=0)
            player.put(20, True, abort=1)
        else:
            player.put(20, True, start=0)
        wanted.append(np.array([[0, 0, 1, 1, 1]]) if empty
                      else expected(descriptor, strip, view=view))
    items = [(one.x, one.y, one.blank, one.first, one.last)
             for one in player.play(verilog, transcripts, **plusargs)]
    cuts = 0
    for frame in wanted:
        frame[frame[:, 2] == 1, :2] = 0
        length = 1 + next(k for k, item in enumerate(items) if item[4])
        found, items = items[:length], items[length:]
        if aborts and length < len(frame):
            cuts += 1
            assert found.pop() == (0, 0, 1, length == 1, 1)
            frame = frame[:length - 1]
        np.testing.assert_array_equal(np.reshape(found, (-1, 5)), frame)
    assert not items and (cuts > count // 4) == aborts


def frames(count, stall):
    """The bench of whole frames, with a consumer that stalls in so many of 256 clocks."""
    def bench(verilog, transcripts):
        _play(verilog, transcripts, 1 + stall, count, stall=stall, clock_limit=1_000_000)
    return bench


def aborts(verilog, transcripts):
    """Frames that an abort ends, and whole ones after them."""
    _play(verilog, transcripts, 7, 80, aborts=True, stall=60, clock_limit=400_000)


def small(verilog, transcripts):
    """Many small frames: overflows of all kinds."""
    _play(verilog, transcripts, 8, 120, small=True, clock_limit=400_000)


def jumps(verilog, transcripts):
    """Many small frames whose values jump from node to node, beyond all limits."""
    _play(verilog, transcripts, 9, 120, small=True, reach=2500, clock_limit=400_000)


DESIGN = Design("front", "dut", Front, (
    PlayedBench("frames", frames(33, 0)), PlayedBench("frames, stalls", frames(12, 150)),
    PlayedBench("aborts", aborts), PlayedBench("small frames", small),
    PlayedBench("jumps", jumps)), leaves=(
        "backmap.network_at_nodes", "backmap.scan.strips", "table"), bare=1)
