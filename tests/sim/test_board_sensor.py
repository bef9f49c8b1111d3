"""A board and its sensor: its data sheet's times, and a sensor that goes and comes back."""

from dataclasses import replace

import pytest

from board_bench import HEIGHT, SMALL, WIDTH, Bench
from ncdc_boards.camera_board.waking import Times
from ncdc_sim.board.run import unplugged_at

pytestmark = pytest.mark.regress

READY, SET_UP, TROUBLE = 1, 2, 4
SECOND_US = 4000            # of the watch: 250 times shorter than a second, as are the times below


@pytest.fixture(scope="module")
def bench():
    made = Bench("ulx3s", SMALL, (WIDTH, HEIGHT))
    made.design = replace(made.design, times=Times(5000, 40_000, SECOND_US))
    return made


def lit_at(run, us):
    """The LEDs at a microsecond."""
    return [leds for at, leds in run.leds if at <= us][-1]


def test_an_unplugged_sensor_comes_back_by_itself(bench):
    """Gone for two seconds, as the watch counts them: an LED meanwhile, and a picture again within
    two seconds."""
    gone, back = 8000, 8000 + 2 * SECOND_US
    run = bench.run(back + 2 * SECOND_US, optimise="-O1", events=unplugged_at(
        gone, 2 * SECOND_US))
    assert lit_at(run, gone) & 7 == READY | SET_UP
    # A second without a frame, and a bit: the initialisation runs and gets no answer.
    assert lit_at(run, back) & 7 == READY | TROUBLE
    assert lit_at(run, back + 2 * SECOND_US) & 7 == READY | SET_UP
    # The sensor began its frames anew, and the screen shows a golden one of those at the end.
    restarts = [k for k, number in enumerate(run.sensor_frames) if number == 0]
    numbers = bench.shown(run)
    assert len(restarts) >= 2 and numbers[-1] is not None
    late = numbers[len(numbers) * back // (back + 2 * SECOND_US):]
    assert len(set(late)) >= 3, "the screen stands still"
    # One that is plugged in between a reset and a try cannot be known to want another reset.
    assert run.early <= 1


def test_without_a_watch_the_screen_stands_still(bench):
    """The old fault: nothing configures the sensor again."""
    gone, back = 8000, 8000 + 2 * SECOND_US
    unchanged = bench.design
    bench.design = replace(unchanged, times=replace(unchanged.times, watch_us=1_000_000))
    run = bench.run(back + 2 * SECOND_US, optimise="-O1", events=unplugged_at(
        gone, 2 * SECOND_US))
    bench.design = unchanged
    numbers = bench.shown(run)
    assert len(set(numbers[len(numbers) // 2:])) == 1


def test_a_button_sets_the_sensor_up_anew(bench):
    run = bench.run(14_000, optimise="-O1", events={"press_again_us": 6000, "hold_us": 2000})
    dark = [at for at, leds in run.leds if at >= 6000 and not leds & SET_UP]
    assert len(dark) == 1 and lit_at(run, 13_999) & 7 == READY | SET_UP
    assert not any(leds & TROUBLE for _, leds in run.leds)
    assert run.early == 0 and bench.shown(run)[-1] is not None


@pytest.fixture(scope="module")
def true():
    """Reset, rest and bus as on a board."""
    made = Bench("ulx3s", SMALL, (WIDTH, HEIGHT), time_scale=1, i2c_hz=100_000)
    assert made.design.times == Times(5000, 40_000, 1_000_000)
    return made


@pytest.mark.many_clocks
def test_not_one_access_comes_before_the_data_sheets_time(true):
    run = true.run(62_000, optimise="-O2")
    assert run.early == 0 and run.results["failures"] == 0
    assert not any(leds & TROUBLE for _, leds in run.leds)
    assert run.leds[-1][1] & 7 == READY | SET_UP
    assert true.shown(run)[-1] is not None


def test_the_times_that_boards_had_are_too_short(true):
    """2 ms and 2 ms: the model rejects, and counts."""
    true.design = replace(true.design, times=Times(2000, 2000))
    run = true.run(10_000, optimise="-O1")
    assert run.early > 0
    assert run.leds[-1][1] & 7 == READY | TROUBLE
