"""The PHY of an ECP5's cells at the wires of a CSI-2 sensor: it finds the eyes of its lanes."""

import re

import pytest

from ncdc_sim.csi2.phy import HEIGHT, run_phy, sent_row

regress = pytest.mark.regress

FRAMES = 100


def check(run, least):
    """At least so many frames came, one after the other, each of them right."""
    assert run.results["ready"] and len(run.frames) >= least
    numbers = []
    for rows, bad in run.frames:
        assert not bad and len(rows) == HEIGHT
        number = next(n for n in range(FRAMES) if sent_row(n, 0) == rows[0])
        assert rows == [sent_row(number, y) for y in range(HEIGHT)]
        numbers.append(number)
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


@pytest.mark.longer
@pytest.mark.parametrize("wires", [
    pytest.param({}, marks=regress),
    pytest.param({"csi2_skew_ps0": 300, "csi2_skew_ps1": 900, "csi2_jitter_ps": 200},
                 marks=regress),
    # The edges of the bits on those of the clock.
    {"csi2_skew_ps0": 1100},
    pytest.param({"csi2_skew_ps0": 2000, "csi2_skew_ps1": 1600, "csi2_jitter_ps": 250},
                 marks=regress)])
def test_each_lane_finds_its_eye(wires):
    """Of 2193 ps of a bit, 640 must be stable: steps of 200 ps find some 7 of them, or the part
    that their range covers. One more may pass at random. The first search succeeds."""
    run = run_phy(FRAMES, **wires)
    check(run, FRAMES - 20)
    assert run.results["failures"] == 0
    assert all(4 <= run.results[f"width{k}"] <= 9 for k in range(2))


@regress
def test_a_clock_that_starts_late():
    check(run_phy(FRAMES, csi2_clock_us=150), FRAMES // 2)


@pytest.mark.longer
def test_no_eye_no_frame():
    """Jitter of nearly a bit leaves no delay at which sync bytes are right: no frame comes."""
    run = run_phy(FRAMES // 4, csi2_jitter_ps=1900)
    assert not run.results["ready"] and run.results["failures"] and not run.frames


def swapped(text):
    """The Verilog with the first and the last bit of each word exchanged."""
    changed = re.sub(r"\.Q([03])\(", lambda found: f".Q{3 - int(found[1])}(", text)
    assert changed != text
    return changed


@pytest.mark.longer
def test_bits_in_the_wrong_order_are_found():
    run = run_phy(FRAMES // 4, edit=swapped)
    assert not run.results["ready"] and not run.frames
