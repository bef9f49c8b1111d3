"""The queue in block RAM."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from block_ram import undefined_collisions
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.lib.memory import Fifo, block_memory
from pipelines import run_bench

ITEMS = [k * 40503 & 0xFFFF for k in range(600)]


def run(depth, write_rate, read_rate):
    """Items taken, clocks in which items were written and taken, levels: of a queue between ends
    that are ready in some clocks."""
    rng = np.random.default_rng(depth)
    out, written, taken, levels = [], [], [], []

    async def bench(ctx):
        for clock in range(20 * len(ITEMS)):
            # Never while it is full.
            offers = (len(written) < len(ITEMS) and len(written) - len(taken) < depth
                      and rng.random() < write_rate)
            takes = rng.random() < read_rate
            ctx.set(dut.w_data, ITEMS[len(written) % len(ITEMS)])
            ctx.set(dut.w_en, int(offers))
            ctx.set(dut.r_en, int(takes))
            _, _, space, there, item, level = await ctx.tick().sample(
                dut.w_rdy, dut.r_rdy, dut.r_data, dut.level)
            levels.append(level)
            assert level == len(written) - len(taken)
            assert space == (level < depth)
            if takes and there:
                out.append(item)
                taken.append(clock)
            if offers:
                written.append(clock)
            if len(out) == len(ITEMS):
                break

    with undefined_collisions() as made:
        dut = Fifo(width=16, depth=depth)
        run_bench(dut, bench)
    assert len(made) == 1
    return out, np.array(written), np.array(taken), levels


@pytest.mark.parametrize("depth", [2, 3, 8, 13])
@pytest.mark.parametrize("write_rate, read_rate", [(1, 1), (.5, 1), (1, .5), (.5, .5), (.2, .9)])
def test_order_and_levels(depth, write_rate, read_rate):
    out, _, _, levels = run(depth, write_rate, read_rate)
    assert out == ITEMS
    if write_rate > read_rate:
        assert max(levels) == depth


def test_latency_and_rate():
    _, written, taken, _ = run(8, 1, 1)
    assert np.array_equal(taken, written + 3)
    assert np.array_equal(np.diff(taken), np.ones(len(ITEMS) - 1))


def test_too_small():
    with pytest.raises(ValueError, match="depth is 1, the limit is 2"):
        Fifo(width=8, depth=1)


class Late(wiring.Component):
    """Reads a word in the clock of its write, which it must not."""
    i: In(8)
    o: Out(8)

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = block_memory(8, 4)
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [write.data.eq(self.i), write.en.eq(1), self.o.eq(read.data)]
        return m


def test_collisions_are_undefined():
    with undefined_collisions():
        dut = Late()
        seen = []

        async def bench(ctx):
            for k in (5, 9, 7):
                ctx.set(dut.i, k)
                await ctx.tick()
                seen.append(ctx.get(dut.o))
        run_bench(dut, bench)
    assert seen == [0xFF, 5 ^ 0xFF, 9 ^ 0xFF]


def test_promise_is_in_the_verilog():
    verilog = module_verilog(Fifo(width=16, depth=8), "fifo")
    assert "(* no_rw_check = 1 *)" in verilog
    assert '(* ramstyle = "no_rw_check" *)' in verilog
