"""The sensor's reset and rest, and what sets it up anew."""

import pytest
from amaranth import *
from amaranth.sim import Simulator

from board_bench import SMALL
from cameras import barrel_descriptor
from ncdc_boards.camera_board.design import design_of, sensor_for, times_for
from ncdc_boards.camera_board.waking import Times, Waker
from ncdc_boards.catalogue import board

CLOCK_HZ = 1_000_000
TIMES = Times(reset_us=50, rest_us=120, watch_us=1000)
SET_UP = 40             # clocks of an initialisation that is answered
DEAD = 64               # clocks without an edge, instead of many more


class Bench:
    """A Waker, a sensor that may be there or not, and programs that set it up."""

    def __init__(self, monkeypatch):
        monkeypatch.setattr("ncdc_boards.camera_board.waking._DEAD_CLOCKS", DEAD)
        monkeypatch.setattr("ncdc_boards.camera_board.waking._MAX_WATCHES", 5)
        self.waker = Waker(TIMES, CLOCK_HZ)
        self.frame, self.frames_are, self.there = 200, "came", True     # clocks of a frame
        self.log, self.now, self.busy = [], 0, False    # (clock, name, value) of what changes

    def run(self, clocks, at=()):
        """Run for so many clocks; ``at``: {clock: function}."""
        waker, events = self.waker, dict(at)
        simulator = Simulator(waker)
        simulator.add_clock(1e-6)

        async def bench(ctx):
            left, was = SET_UP, {}
            ctx.set(waker.enabled, 1)
            for self.now in range(clocks):
                events.get(self.now, lambda ctx: None)(ctx)
                awake = ctx.get(waker.ready)
                left = (left - self.there if left else 0) if awake else SET_UP
                ctx.set(waker.busy, left > 0 or self.busy)
                ctx.set(waker.failed, bool(awake and left and not self.there))
                sends = self.there and ctx.get(waker.reset_n)
                ctx.set(waker.edge, sends and self.now // 8 % 2)
                ends = sends and not left and self.now % self.frame == 0
                for name in ("came", "bad"):
                    ctx.set(getattr(waker, name), ends and self.frames_are == name)
                for name in ("reset_n", "ready", "trouble"):
                    value = ctx.get(getattr(waker, name))
                    if was.get(name) != value:
                        self.log.append((self.now, name, value))
                    was[name] = value
                await ctx.tick()

        simulator.add_testbench(bench)
        simulator.run()

    def falls(self, name):
        return [at for at, what, value in self.log if what == name and not value and at]

    def rises(self, name):
        return [at for at, what, value in self.log if what == name and value]


@pytest.fixture
def bench(monkeypatch):
    return Bench(monkeypatch)


def test_reset_and_rest_are_as_long_as_asked(bench):
    bench.run(3000)
    assert bench.rises("reset_n") == [TIMES.reset_us + 1]
    assert bench.rises("ready") == [TIMES.reset_us + TIMES.rest_us]
    assert bench.falls("ready") == bench.rises("trouble") == []


@pytest.mark.longer
def test_unplugged_it_is_woken_before_each_try_and_the_led_is_lit_until_one_is_answered(bench):
    def gone(there):
        return lambda ctx: setattr(bench, "there", there)

    bench.run(9000, {1500: gone(False), 4700: gone(True)})
    pulses = bench.falls("reset_n")
    assert 2400 <= pulses[0] <= 2410 and 4700 - 180 <= pulses[-1] <= 4710
    assert all(0 <= after - before - TIMES.reset_us - TIMES.rest_us <= 5
               for before, after in zip(pulses, pulses[1:]))
    assert 0 <= bench.rises("trouble")[0] - pulses[0] <= 1 == len(bench.rises("trouble"))
    # It answers as soon as it is there: the initialisation ends, and the LED goes out.
    (out,) = bench.falls("trouble")
    assert 4700 + SET_UP <= out <= 4710 + SET_UP + TIMES.reset_us + TIMES.rest_us


def test_a_sensor_that_was_never_there_is_woken_again(bench):
    bench.there = False
    bench.run(4000)
    assert len(bench.falls("reset_n")) == 4000 // 171 and len(bench.rises("trouble")) == 1


def test_bad_frames_alone_are_not_enough(bench):
    """As after a brown-out: it sends, but not as it was configured."""
    bench.frames_are = "bad"
    bench.run(3000)
    assert len(bench.falls("reset_n")) == 2


@pytest.mark.longer
def test_a_long_exposure_is_no_fault_but_not_for_ever(bench):
    bench.frame = 100_000
    bench.run(4500)
    assert bench.falls("reset_n") == []
    bench.log.clear()
    bench.run(6500)
    assert len(bench.falls("reset_n")) == 1


@pytest.mark.longer
def test_nothing_is_watched_while_no_frame_is_asked_for(bench):
    def off(ctx):
        ctx.set(bench.waker.enabled, 0)
        bench.there = False

    bench.run(6000, {500: off})
    assert bench.falls("reset_n") == []


def test_a_program_is_not_cut_off(bench):
    """A lens that is being loaded when the sensor goes: the loading ends first."""
    def gone(ctx):
        bench.there, bench.busy = False, True

    bench.run(5000, {500: gone, 3000: lambda ctx: setattr(bench, "busy", False)})
    assert 3000 <= bench.falls("reset_n")[0] <= 3005


def test_a_button_wakes_it_once_a_press(bench):
    def press(value):
        return lambda ctx: ctx.set(bench.waker.again, value)

    bench.run(4000, {1000: press(1), 2500: press(0)})
    assert len(bench.falls("reset_n")) == 1 and bench.rises("trouble") == []


@pytest.mark.parametrize("name,mode", [("ulx3s", SMALL), ("de0-cv", SMALL), ("de1-soc", SMALL),
                                       ("de2-115", SMALL)])
@pytest.mark.parametrize("sensor", ["mt9p031", "ov5640"])
def test_a_design_has_the_sensors_times(name, mode, sensor):
    lens = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2,
                             bayer="BGGR" if sensor == "ov5640" else "GRBG")
    found = sensor_for(sensor, lens.geometry)
    design = design_of(board(name), [("a", lens)], found, mode)
    assert design.times == times_for(found[0]) == Times(5000, 40_000, 1_000_000)
    assert design.time_scale == 1
