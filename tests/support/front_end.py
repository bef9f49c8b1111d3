"""The front end as the corrector joins it, its frames, and those of the golden model."""

from dataclasses import replace
from itertools import zip_longest

import numpy as np
from amaranth import *
from amaranth.lib import wiring

from banks import bank_words, take_bank, write_bank
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.frontend.node_backmap import NodeBackMap
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_hdl.frontend.view_table import ViewTable
from ncdc_hdl.lib.groups import lanes_of
from ncdc_model.correction import frame_coordinates
from ncdc_model.golden.view import view_coordinates
from ncdc_spec.geometry import scan_order
from ncdc_spec.hardware import Hardware
from ncdc_spec.view_rows import STEPS
from pipelines import get, run_bench

__all__ = ["FrontEnd", "aborted_frame", "assert_equal", "expected", "extreme", "fields", "frames",
           "load", "load_rows", "prepare", "words_of"]


class FrontEnd(Elaboratable):
    """Front end and table of valid rows, as the corrector joins them."""

    def __init__(self, d, lanes=1, **options):
        hardware = Hardware(lanes=lanes, **options)
        self.backmap = (BackMap(d.hidden_neurons, d.formats, hardware=hardware) if d.nodes == 1
                        else NodeBackMap(d.hidden_neurons, d.formats, d.nodes, hardware=hardware))
        self.table = (ViewTable(d.valid, *d.geometry.corrected, lanes) if hardware.view else
                      ValidTable(d.valid, *d.geometry.corrected))

    def elaborate(self, platform):
        m = Module()
        m.submodules.backmap, m.submodules.table = self.backmap, self.table
        if isinstance(self.table, ViewTable):
            for lane, table in zip(self.backmap.table, self.table.scan):
                wiring.connect(m, lane, table)
        else:
            wiring.connect(m, self.backmap.table, self.table.scan)
        return m


def words_of(d):
    """The words of descriptor ``d`` that may lie in memories, see :func:`bank_words`."""
    return bank_words(d.hidden_weights, d.hidden_biases, d.output_weights)


async def prepare(ctx, backmap, d):
    """Write the weights of ``d`` that lie in memories, if any do, to the bank not in use."""
    if "writes" in backmap.signature.members:
        await write_bank(ctx, backmap.writes, words_of(d))


def load(ctx, backmap, d, strip=0, view=None):
    """Set the parameters of descriptor ``d``, for which the memories are prepared, and a view."""
    g = d.geometry
    origin_x, step_x, origin_y, step_y = g.scan()
    width, height = view.size if view else g.corrected
    if view:
        ctx.set(backmap.view, {"matrix": np.reshape(view.matrix, (3, 3)).tolist(),
                               "plane_height": g.corrected_height})
    ctx.set(backmap.scan, {"width": width, "height": height, "strip": strip,
                            "origin_x": origin_x, "step_x": step_x,
                           "origin_y": origin_y, "step_y": step_y})
    network = backmap.network
    if "hidden" in network.shape().members:
        for j in range(d.hidden_neurons):
            ctx.set(network.hidden[j], {"weights": d.hidden_weights[j].tolist(),
                                        "bias": int(d.hidden_biases[j])})
    shared = "writes" in backmap.signature.members
    for k in range(2):
        skip = {} if d.skip_weights is None else {"skip": d.skip_weights[k].tolist()}
        weights = {} if shared else {"weights": d.output_weights[k].tolist()}
        ctx.set(network.output[k], {"bias": int(d.output_biases[k]), **weights, **skip})
    if shared:
        take_bank(ctx, backmap.writes)


async def load_rows(ctx, rows, writes, view, bank=0):
    """Write the table of a ``view``, if it has one, to a ``bank``, and choose it."""
    table = view.rows
    ctx.set(rows, {"count": len(table.matrices) if table else 0, "bank": bank,
                   "step": STEPS.index(table.step) if table else 0})
    for k, matrix in enumerate(table.matrices if table else ()):
        for number, word in enumerate(matrix):
            row, column = divmod(number, 3)
            for name, value in (("write", 1), ("bank", bank), ("matrix", k), ("row", row),
                                ("column", column), ("word", word)):
                ctx.set(getattr(writes, name), value)
            await ctx.tick()
    ctx.set(writes.write, 0)


def expected(d, strip=0, lanes=1, view=None):
    """(x, y, blank, first, last) of every pixel in order; the flags are those of its group."""
    if view:
        v, u = np.indices(view.size[::-1])
        *source, valid = view_coordinates(d, view, u, v)
    else:
        source, valid = frame_coordinates(d), d.valid.mask(d.geometry.corrected_width)
    x, y, blank = (scan_order(a, strip) for a in (*source, ~valid))
    flags = np.zeros((2, x.size), int)
    flags[0, :lanes] = flags[1, -lanes:] = 1
    return np.stack([x, y, blank.astype(int), *flags], axis=1)


def fields(items):
    return np.array([[c.x, c.y, c.blank, item.first, item.last]
                     for item in items for c in lanes_of(item)])


async def aborted_frame(ctx, backmap, rng, moment, taken, each_clock=lambda: None):
    """(fields, whether it is cut) of a frame that ``abort`` ends.

    ``moment``: clocks from its start to the abort, None for a whole frame; ``taken``: part of the
    clocks in which the output is taken; ``each_clock()`` is called before each clock.
    """
    frame, clock = [], 0
    ctx.set(backmap.start, 1)
    await ctx.tick()
    ctx.set(backmap.start, 0)
    while not (frame and frame[-1][4]):
        each_clock()
        ctx.set(backmap.abort, moment is not None and clock >= moment)
        ready = rng.random() < taken
        ctx.set(backmap.o.ready, ready)
        _, _, valid, c = await ctx.tick().sample(backmap.o.valid, backmap.o.payload)
        if valid and ready:
            frame.extend(fields([c]).tolist())
        clock += 1
        assert clock < 20000, "the frame does not end"
    ctx.set(backmap.abort, 0)
    return np.array(frame), ctx.get(backmap.cut)


def assert_equal(frame, golden):
    """A frame equals the golden one; coordinates of blank pixels do not count."""
    np.testing.assert_array_equal(frame[:, 2:], golden[:, 2:])
    used = golden[:, 2] == 0
    np.testing.assert_array_equal(frame[used], golden[used])


def frames(dut, descriptors, stall, seed=5, strip=0, views=()):
    """The fields of one frame of each of ``descriptors``, one after the other; ``views``: one for
    each, or none."""
    rng, results = np.random.default_rng(seed), []

    async def bench(ctx):
        for k, (d, view) in enumerate(zip_longest(descriptors, views)):
            await prepare(ctx, dut.backmap, d)
            load(ctx, dut.backmap, d, strip, view)
            if "rows" in dut.backmap.signature.members:
                await load_rows(ctx, dut.backmap.rows, dut.backmap.row_writes, view, k % 2)
            ctx.set(dut.backmap.start, 1)
            await ctx.tick()
            ctx.set(dut.backmap.start, 0)
            width, height = view.size if view else d.geometry.corrected
            groups = width * height // dut.backmap.lanes
            results.append(fields(await get(ctx, dut.backmap.o, groups,
                                            lambda: rng.random() < stall)))

    run_bench(dut, bench)
    return results


def extreme(d, seed):
    """``d`` with every weight and bias at a limit of its format."""
    rng, f = np.random.default_rng(seed), d.formats

    def limits(q, raw):
        return rng.choice([q.lo, q.hi], raw.shape)

    return replace(d, hidden_weights=limits(f.hidden_weight, d.hidden_weights),
                   hidden_biases=limits(f.hidden_bias, d.hidden_biases),
                   output_weights=limits(f.output_weight, d.output_weights),
                   output_biases=limits(f.output_bias, d.output_biases))
