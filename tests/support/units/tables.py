"""The table of valid rows: what a host writes, it reads, and a lane gets."""

import numpy as np

from ncdc_hdl.frontend.valid import ValidTable
from pipelines import run_bench

__all__ = ["check_view_table"]


def _words(dut, rng, count):
    """(bank, row, span, start, stop): rows anywhere, among them pairs that differ in one bit."""
    rows, bits = dut.of_host.row_bits, dut.of_host.column_bits
    for k in range(count):
        row = int(rng.integers(1 << rows))
        for number in (row, row ^ 1 << k % rows):
            yield (int(rng.integers(2)), number, int(rng.integers(2)),
                   int(rng.integers(1 << bits)), int(rng.integers(1 << bits)))


async def _write(ctx, dut, words, stored):
    """Write ``words``; further rows are ignored, and so is all without ``write``."""
    host, beyond = dut.host, 1 << dut.of_host.row_bits
    for bank, row, span, start, stop in words:
        for name, value in (("bank", bank), ("span", span), ("start", start), ("stop", stop)):
            ctx.set(getattr(host, name), value)
        ctx.set(host.row, row)
        ctx.set(host.write, 1)
        await ctx.tick()
        stored[bank, row, span] = start, stop
        ctx.set(host.start, ~start)
        if beyond < 1 << len(host.row):
            ctx.set(host.row, row | beyond)     # of a row that the table does not have
            await ctx.tick()
        ctx.set(host.row, row)
        ctx.set(host.write, 0)
        await ctx.tick()


async def _reads(ctx, dut, keys, stored):
    """A host's reads, each of one clock, while the lane asks for other rows."""
    host, scan = dut.host, dut.scan[0]
    for k, key in enumerate(keys):
        bank, row, span = key
        other = keys[k - 1][1]
        ctx.set(scan.row, other)
        ctx.set(host.bank, bank)
        ctx.set(host.row, row)
        ctx.set(host.span, span)
        ctx.set(host.read, 1)
        await ctx.tick()
        ctx.set(host.read, 0)
        ctx.set(host.span, 1 - span)
        await ctx.tick().repeat(ValidTable.latency - 1)
        assert (ctx.get(host.read_start), ctx.get(host.read_stop)) == stored[key], key
        await ctx.tick()


async def _scans(ctx, dut, keys, stored):
    """A lane's lookups of both spans, with ``fresh`` while they are those of the row."""
    scan = dut.scan[0]
    for bank, row, _ in keys:
        ctx.set(dut.bank, bank)
        ctx.set(scan.row, row)
        await ctx.tick().repeat(ValidTable.latency)
        assert ctx.get(scan.fresh)
        found = [tuple(ctx.get(scan.spans[f"{end}{span}"]) for end in ("start", "stop"))
                 for span in range(2)]
        for span in range(2):
            assert found[span] == stored.get((bank, row, span), found[span]), (bank, row, span)
        ctx.set(scan.row, row ^ 1 << row % dut.of_host.row_bits)
        await ctx.delay(1e-9)
        assert not ctx.get(scan.fresh)


def check_view_table(dut, count=120, seed=1):
    """``dut``: a :class:`ncdc_hdl.frontend.view_table.ViewTable` of one lane."""
    async def bench(ctx):
        rng, stored = np.random.default_rng(seed), {}
        for _ in range(2):
            await _write(ctx, dut, _words(dut, rng, count), stored)
            keys = [list(stored)[k] for k in rng.permutation(len(stored))]
            await _reads(ctx, dut, keys, stored)
            await _scans(ctx, dut, keys, stored)

    run_bench(dut, bench)
