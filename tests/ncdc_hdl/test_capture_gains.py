"""Gains before interpolation at capture: which sample has which gain, and from which frame on."""

from itertools import product

import numpy as np
import pytest
from amaranth import *
from amaranth.lib.cdc import ResetSynchronizer
from amaranth.sim import Simulator

from ncdc_hdl.lib.gains import BALANCE
from ncdc_hdl.lib.word_crossing import WordCrossing
from ncdc_spec.raw_gains import sample_gains
from ncdc_spec.registers.register_map import BAYER_MONO
from ncdc_spec.sensors.grid import grid_size, gridded
from ncdc_spec.sensors.level import levelled
from sensor_ports import CLEAN, Port, pins_of, random_frames

GAINS = 512, 256, 397
PHASES = [(0, 0), (1, 0), (0, 1), (1, 1), None]


def balance(phase, gains=GAINS):
    """Of the layout ``BALANCE``."""
    number = BAYER_MONO if phase is None else phase[0] | phase[1] << 1
    return {"gains": list(gains), "phase": number}


def whole(port, samples, phase, gains=GAINS):
    """The window of a frame as the golden model has it; the phase is the window's."""
    (left, top), (width, height) = port.corner, port.window
    if port.mode is not None:
        samples = gridded(samples, *port.mode)
    return levelled(samples[top:top + height, left:left + width],
                    gains=sample_gains(port.window, phase, gains)).tolist()


@pytest.mark.parametrize("corner", list(product((2, 3), (0, 1))))
@pytest.mark.parametrize("phase", PHASES)
def test_each_sample_has_the_gain_of_its_filter(phase, corner):
    """By the phase of the window, whatever its corner: mirrored readout only changes the phase."""
    port = Port((17, 9), (11, 7), corner, None, balance=balance(phase))
    frames = random_frames((17, 9), 2)
    clocks = [*pins_of(frames[0], (0, 1, 0)), *pins_of(frames[1], (3, 7, 5))]
    assert port.run(clocks) == [(whole(port, frame, phase), CLEAN) for frame in frames]


@pytest.mark.parametrize("phase", [(1, 0), (0, 1)])
@pytest.mark.parametrize("mode", [(3, 0), (0, 1), (2, 1)])
def test_with_a_sensor_that_skips_or_bins(mode, phase):
    size = 26, 14
    window = tuple(length - 3 for length in grid_size(size, *mode))
    port = Port(size, window, (2, 1), mode, balance=balance(phase))
    frames = random_frames(size, 2)
    clocks = [*pins_of(frames[0], (0, 1, 0)), *pins_of(frames[1], (3, 7, 5))]
    assert port.run(clocks) == [(whole(port, frame, phase), CLEAN) for frame in frames]


@pytest.mark.parametrize("mode", [None, pytest.param((3, 1), marks=pytest.mark.longer)])
def test_a_frame_has_the_gains_of_its_beginning(mode):
    """Written in mid-frame and around its end, with FRAME_VALID low for two clocks only."""
    size = 20, 10
    frames = random_frames(size, 3)
    clocks = [clock for frame in frames for clock in pins_of(frame, (0, 1, 0))[:-2]]
    end = len(clocks) // 3                  # of the first frame, with its clocks between two
    assert [frame for frame, *_ in clocks[end - 3:end + 1]] == [1, 0, 0, 1]
    window = grid_size(size, *(mode or (0, 0)))
    other = (256, 1023, 100)
    changes = {}
    for at in (end // 2, *range(end - 3, end + 30, 3), 2 * end - 20):
        port = Port(size, window, (0, 0), mode, balance=balance((0, 0)))
        found = port.run(clocks, [(at, "balance", balance((0, 0), other))])
        changes[at] = [[whole(port, frame, (0, 0), gains) for gains in (GAINS, other)].index(got)
                       for frame, (got, _) in zip(frames, found)]
    assert all(change in ([0, 1, 1], [0, 0, 1]) for change in changes.values()), changes
    assert changes[end // 2] == [0, 1, 1] and changes[2 * end - 20] == [0, 0, 1]


class Slow(WordCrossing):
    """Half of the wires take a clock of the other domain longer."""

    @staticmethod
    def _wires(m, offered):
        late = Signal(4)
        m.d.there += late.eq(offered[4:])
        return Cat(offered[:4], late)


@pytest.mark.parametrize("period", [.1, .77, 1, 1.3, 9])
def test_a_word_crosses_as_a_whole(period):
    """Words that change at random: the other clock sees only words that were there, in order, and
    the last one, though bits of a word take longer than others."""
    dut = Slow(8, init=9)
    m = Module()
    m.domains.there = ClockDomain()
    m.submodules.reset = ResetSynchronizer(ResetSignal(), domain="there")
    m.submodules.dut = dut
    rng = np.random.default_rng(int(10 * period))
    given, seen = [9], []

    async def give(ctx):
        for word in rng.integers(0, 256, 300):
            ctx.set(dut.i, int(word))
            given.append(int(word))
            await ctx.tick().repeat(int(rng.choice((1, 1, 2, 5, 30))))
        await ctx.tick().repeat(20 + int(20 * period))
        assert ctx.get(dut.o) == given[-1]

    async def see(ctx):
        async for *_, word in ctx.tick("there").sample(dut.o):
            seen.append(word)

    simulator = Simulator(m)
    simulator.add_clock(1e-8)
    simulator.add_clock(period * 1e-8, domain="there", phase=3e-9)
    simulator.add_testbench(give)
    simulator.add_testbench(see, background=True)
    simulator.run()
    order = iter(given)
    changes = [word for before, word in zip([None, *seen], seen) if word != before]
    assert all(word in order for word in changes) and len(changes) > 10


def test_layout_fits_its_register():
    """Gains are written as one word, so that no frame has gains of two sets."""
    assert BALANCE["gains"].shape.size == 30
