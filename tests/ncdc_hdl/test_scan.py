"""The scan: normalised coordinates, blanking and frame marks of every pixel, in their order."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring

from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_model.golden.network import normalised_scan
from ncdc_spec.descriptor import Formats
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, Geometry, ValidRows, scan_order
from pipelines import run_bench


class Dut(Elaboratable):
    def __init__(self, valid, rows, lanes=1):
        self.scan, self.table = Scan(Formats(), lanes), ValidTable(valid, MAX_SIZE, rows)

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan, m.submodules.table = scan, table = self.scan, self.table
        wiring.connect(m, scan.table, table.scan)
        return m


def valid_rows(width, height):
    """Rows with two spans, whose distance grows downwards."""
    return ValidRows.of_mask(np.abs(np.indices((height, width))[1] - width // 2)
                             > np.arange(height)[:, None] // 2)


def load(ctx, scan, g, strip, **sizes):
    origin_x, step_x, origin_y, step_y = g.scan()
    ctx.set(scan.parameters, {
        "width": g.corrected_width, "height": g.corrected_height, "strip": strip,
        "origin_x": origin_x, "step_x": step_x, "origin_y": origin_y, "step_y": step_y} | sizes)


async def frame(ctx, dut, rng, pause=0.0, host=0.0, abort_at=None):
    """The groups of one frame, each [x and y of its pixels, blank, first, last].

    ``host``: how often the host takes the table's port, also just when a row ends.
    ``abort_at``: the number of the group before which the frame is aborted.
    """
    scan, got, shown, clocks = dut.scan, [], [], 0
    ctx.set(scan.start, 1)
    await ctx.tick()
    ctx.set(scan.start, 0)
    while True:
        ctx.set(scan.abort, abort_at is not None and len(got) >= abort_at)
        ctx.set(dut.table.host.read, int(rng.random() < host))
        ctx.set(dut.table.host.row, int(rng.integers(1 << dut.table.row_bits)))
        await ctx.delay(1e-10)
        ctx.set(scan.go, int(rng.random() >= pause))
        advance = ctx.get(scan.advance)
        assert not advance or ctx.get(scan.active)
        if advance:
            got.append([[(ctx.get(p.x), ctx.get(p.y)) for p in scan.pixels],
                        None, ctx.get(scan.first), ctx.get(scan.last)])
        shown.append(got[-1] if advance else None)
        ended = advance and got[-1][-1]
        await tick(ctx, scan, shown)
        clocks += 1
        assert clocks < 10000, "the frame does not end"
        if ended:
            break
    ctx.set(scan.abort, 0)
    ctx.set(scan.go, 0)
    await ctx.delay(1e-10)
    assert not ctx.get(scan.active)
    for _ in range(scan.blank_latency):
        shown.append(None)
        await tick(ctx, scan, shown)
    return got


async def tick(ctx, scan, shown):
    """A clock; then ``blank`` is that of the group taken so many clocks ago, if one was."""
    await ctx.tick()
    if len(shown) >= scan.blank_latency and shown[-scan.blank_latency]:
        shown[-scan.blank_latency][1] = ctx.get(scan.blank)


def expected(g, valid, strip, lanes):
    """What :func:`frame` gives, by the golden model."""
    width, height = g.corrected
    v, u = (scan_order(a, strip).reshape(-1, lanes) for a in np.indices((height, width)))
    x, y = normalised_scan(u, v, g, Formats())
    blank = (~valid.mask(width)[v, u] << np.arange(lanes)).sum(axis=1)
    return [[list(zip(*xy)), b, k == 0, k == len(blank) - 1]
            for k, (xy, b) in enumerate(zip(np.stack([x, y], axis=1).tolist(), blank.tolist()))]


@pytest.mark.parametrize("size,strip,lanes", [
    ((8, 8), 0, 1), ((37, 11), 0, 1), ((64, 9), 0, 1),
    ((37, 11), 32, 1),          # the last strip is narrower
    ((65, 9), 64, 1),           # it is a single column
    ((64, 8), 32, 1), ((64, 8), 64, 1), ((40, 8), 96, 1),
    ((8, 8), 0, 2), ((66, 9), 32, 2), ((8, 8), 0, 4), ((68, 8), 32, 4), ((100, 9), 0, 4)])
@pytest.mark.parametrize("pause,host", [
    (.4, .8), pytest.param(0, 0, marks=pytest.mark.regress)])
def test_every_pixel_equals_model(size, strip, lanes, pause, host):
    rng, g, valid = np.random.default_rng(size[0]), Geometry(*size, 40, 40), valid_rows(*size)
    dut, got = Dut(valid, size[1], lanes), []

    async def bench(ctx):
        load(ctx, dut.scan, g, strip)
        for _ in range(2):
            got.append(await frame(ctx, dut, rng, pause, host))
            assert not ctx.get(dut.scan.cut)

    run_bench(dut, bench)
    assert got == [expected(g, valid, strip, lanes)] * 2


def test_one_group_per_clock_from_strip_to_strip():
    """The rows of a strip that is wide enough follow each other without a gap."""
    g, dut = Geometry(72, 8, 40, 40), Dut(valid_rows(72, 8), 8)

    async def bench(ctx):
        load(ctx, dut.scan, g, 32)
        ctx.set(dut.scan.start, 1)
        await ctx.tick()
        ctx.set(dut.scan.start, 0)
        ctx.set(dut.scan.go, 1)
        await ctx.tick().until(dut.scan.advance)
        for k in range(1, 72 * 8):
            assert ctx.get(dut.scan.advance), f"a gap before pixel {k}"
            await ctx.tick()

    run_bench(dut, bench)


def test_bits_of_the_strip_that_the_hardware_has_not():
    """A strip width that is no multiple of 32 is taken as the next lower one that is."""
    g, valid, got = Geometry(70, 8, 40, 40), valid_rows(70, 8), []
    dut = Dut(valid, 8)

    async def bench(ctx):
        for strip in (31, 45):
            load(ctx, dut.scan, g, strip)
            got.append(await frame(ctx, dut, np.random.default_rng(1)))

    run_bench(dut, bench)
    assert got == [expected(g, valid, strip, 1) for strip in (0, 32)]


@pytest.mark.parametrize("strip,lanes", [(0, 1), (32, 1), (32, 2)])
@pytest.mark.parametrize("abort_at", [0, 1, 35, 400, 10000])
def test_abort_ends_the_frame_with_a_blank_group(strip, lanes, abort_at):
    """The frame keeps what was taken before and ends with one blank group; the next is whole."""
    rng, g, valid = np.random.default_rng(3), Geometry(72, 12, 40, 40), valid_rows(72, 12)
    dut, got, cut = Dut(valid, 12, lanes), [], []

    async def bench(ctx):
        load(ctx, dut.scan, g, strip)
        for at in (abort_at, None):
            got.append(await frame(ctx, dut, rng, pause=.2, abort_at=at))
            cut.append(ctx.get(dut.scan.cut))

    run_bench(dut, bench)
    whole = expected(g, valid, strip, lanes)
    assert got[1] == whole
    if abort_at >= len(whole):
        assert got[0] == whole and cut == [0, 0]
    else:
        taken = len(got[0]) - 1
        assert taken in (abort_at, abort_at + 1) and got[0][:-1] == whole[:taken]
        assert got[0][-1][1:] == [(1 << lanes) - 1, taken == 0, 1]
        assert cut == [1, 0]


@pytest.mark.parametrize("empty", [{"width": 0}, {"height": 0}, {"width": 0, "height": 0}])
@pytest.mark.parametrize("strip", [0, 32])
def test_a_picture_without_a_pixel_ends(empty, strip):
    g, valid, got = Geometry(40, 8, 40, 40), valid_rows(40, 8), []
    dut = Dut(valid, 8)

    async def bench(ctx):
        for sizes in (empty, {}):
            load(ctx, dut.scan, g, strip, **sizes)
            got.append(await frame(ctx, dut, np.random.default_rng(1)))
            assert ctx.get(dut.scan.cut) == bool(sizes)

    run_bench(dut, bench)
    assert [group[1:] for group in got[0]] == [[1, 1, 1]]
    assert got[1] == expected(g, valid, strip, 1)


@pytest.mark.parametrize("strip", [-32, 16, 100, 4128])
def test_strips_that_there_are_not(strip):
    with pytest.raises(InputError, match=f"the strip width is {strip}, 0 .raster. or a multiple of "
                                         "32 up to 4096 is needed"):
        scan_order(np.zeros((8, 8)), strip)


def test_scan_order():
    order = scan_order(np.arange(2 * 70).reshape(2, 70), 32)
    assert sorted(order) == list(range(140))
    assert order[[0, 31, 32, 63, 64, 127, 128, 133, 134, 139]].tolist() == [
        0, 31, 70, 101, 32, 133, 64, 69, 134, 139]


def test_model_scan_is_symmetric_and_below_one():
    for width, height in ((8, 9), (640, 480), (1281, 1023), (4096, 4096)):
        g, formats = Geometry(width, height, 8, 8), Formats()
        x, y = g.normalise(np.arange(width), 0)[0], g.normalise(0, np.arange(height))[1]
        for axis in (x, y):
            np.testing.assert_array_equal(axis, -axis[::-1])
            assert 0.999 < axis[-1] <= 0.9999
        raw, _ = normalised_scan(np.arange(width), 0, g, formats)
        assert np.abs(formats.input.real(raw) - x).max() <= 2.0**-(formats.input.f_bits + 1)
