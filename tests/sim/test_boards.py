"""Whole boards in simulation: what the monitor at the connector sees, of what the sensor sends."""

from dataclasses import replace

import numpy as np
import pytest

import ncdc_boards.camera_board.core as core
from board_bench import HEIGHT, SMALL, WIDTH, Bench, PatternBench
from ncdc_boards.camera_board.design import hardware_for
from ncdc_boards.catalogue import board
from ncdc_boards.quartus import top as quartus_top
from ncdc_hdl.export.drivers.host.ncdc_backends import Serial
from ncdc_hdl.video.modes import mode_named
from ncdc_sim.board.run import request_at, scans_at
from ncdc_sim.tools import SimulationError
from ncdc_spec.protocols.jtag_link import READ, WRITE, jtag_message

ID, ID_OFFSET = int.from_bytes(b"NCDC", "big"), 0
QUARTUS = ("de1-soc", "de2-115", "de0-cv")


def check(bench, run):
    """What holds for every run: sync times, rules of the SDRAM, and no frame too late."""
    mode = bench.mode
    assert run.screen.horizontal == {mode.horizontal} and run.screen.vertical == {mode.vertical}
    assert run.screen.high == (mode.high, mode.high)
    assert run.pixel_clock_ps == pytest.approx(1e6 / mode.pixel_mhz, rel=.005)
    results = run.results
    assert not any(results[name] for name in (
        "violations", "monitor_errors", "underruns", "failures"))
    assert results["refreshes"] > 0 and results["beats_written"] > 0


class Host:
    """The driver's serial port: what it sends, and what it makes of an answer."""

    def __init__(self):
        self.sent, self.come = b"", b""

    def write(self, data):
        self.sent += data

    def read(self, size):
        data, self.come = self.come[:size], self.come[size:]
        return data

    def request(self, offset):
        self.offset = offset
        with pytest.raises(OSError):
            Serial(self, tries=1, pause=0).read(offset)
        return self.sent

    def answer(self, data):
        self.come = data
        return Serial(self, tries=1, pause=0).read(self.offset)


@pytest.fixture(scope="module")
def small():
    return Bench("ulx3s", SMALL, (WIDTH, HEIGHT))


@pytest.mark.longer
@pytest.mark.parametrize("name", [
    "ulx3s", *(pytest.param(name, marks=pytest.mark.regress) for name in QUARTUS)])
def test_the_screen_shows_the_golden_models_frames(name, request):
    bench = request.getfixturevalue("small") if name == "ulx3s" else \
        Bench(name, SMALL, (WIDTH, HEIGHT))
    host = Host()
    events = request_at(7500, host.request(ID_OFFSET))
    enable = next(r.address for r in bench.design.system.table if r.name == "CAMERA_IRQ_ENABLE")
    accesses = ((READ, 0, 0, ID), (WRITE, enable, 0x15, 0x15), (READ, enable, 0, 0x15))
    if name in QUARTUS:     # and a host at the JTAG port, which writes one too
        events |= scans_at(7500, [scan for tag, (kind, address, word, _) in enumerate(accesses)
                                  for scan in (jtag_message(kind, tag, address, word), 0, 0)])
    run = bench.run(9000, optimise="-O1", events=events)
    check(bench, run)
    assert host.answer(run.serial) == ID
    if name in QUARTUS:
        assert [out for out in run.scans if out] == [
            jtag_message(kind, tag, address, word)
            for tag, (kind, address, _, word) in enumerate(accesses)]
    numbers = bench.shown(run)
    first = next(k for k, number in enumerate(numbers) if number is not None)
    assert None not in numbers[first:], "black after the first frame"
    assert numbers[first:] == sorted(numbers[first:])
    assert len(set(numbers[first:])) >= 3


@pytest.mark.regress
def test_the_screen_shows_the_frames_of_a_csi2_sensor():
    """Registers over I2C, skewed lanes at the pins, the search of their eyes, the monitor."""
    bench = Bench("ulx3s", SMALL, (WIDTH, HEIGHT), "imx219", frames=24,
                  asked={"lane_hz": 456_000_000})
    run = bench.run(24_000, optimise="-O1", events={
        "csi2_skew_ps0": 400, "csi2_skew_ps1": 1200, "csi2_jitter_ps": 150})
    check(bench, run)
    numbers = bench.shown(run)
    first = next(k for k, number in enumerate(numbers) if number is not None)
    assert None not in numbers[first:] and len(set(numbers[first:])) >= 3


@pytest.mark.regress
def test_a_board_without_a_camera_shows_the_test_card():
    """The bench has no sensor, and the top no pins for one; buttons are as with a camera."""
    bench = PatternBench("ulx3s", SMALL, (WIDTH, HEIGHT), rate=1000)
    run = bench.run(30_000, optimise="-O1", events={"press_raw_us": 12_000, "hold_us": 15_000})
    check(bench, run)
    golden = {name: bench.golden(lens)[0] for name, lens in (("straight", 0), ("raw", -1))}
    shown = []
    for frame in run.screen.frames:
        inner = bench.inside(frame)
        shown += [name for name, one in golden.items() if np.array_equal(inner, one)] or [
            "other" if inner.any() else "black"]
    assert [name for name, before in zip(shown, [None, *shown]) if name != before] == [
        "black", "straight", "raw"]


@pytest.mark.regress
def test_a_whole_screen_without_a_camera():
    mode = mode_named("640x480")
    bench = PatternBench("ulx3s", mode, mode.size, rate=60,
                         hardware=replace(hardware_for(board("ulx3s")), strip=256))
    run = bench.run(110_000, optimise="-O2")
    check(bench, run)
    numbers = bench.shown(run)
    assert set(numbers[numbers.index(0):]) == {0}, "black after the first frame"


@pytest.mark.regress
def test_the_screen_shows_the_whole_field():
    """The initialisation program has the sensor skip and bin, and capture even the grid."""
    bench = Bench("ulx3s", SMALL, (WIDTH, HEIGHT), field="full")
    plan, crop = bench.sensor
    assert plan.settings.skip == 7 and plan.settings.bins > 1 and crop.weight
    run = bench.run(25_000, optimise="-O1")
    check(bench, run)
    shown = [number for number in bench.shown(run) if number is not None]
    assert shown == sorted(shown) and len(set(shown)) >= 3


@pytest.mark.regress
def test_buttons_choose_lens_and_raw_picture(small):
    """The next frame after a press has another lens, whole; frames before are the first lens's."""
    run = small.run(60_000, events={"press_following_us": 12_000, "press_raw_us": 36_000,
                                    "hold_us": 15_000})
    check(small, run)
    golden = [small.golden(lens) for lens in range(3)]
    lenses = []
    for frame in run.screen.frames:
        inner = small.inside(frame)
        if inner.any():
            same = [k for k in range(3) if any(np.array_equal(inner, g) for g in golden[k])]
            assert same, "a frame of two lenses"
            lenses.append(same[0])
    assert [k for k, before in zip(lenses, [None, *lenses]) if k != before] == [0, 1, 2]


@pytest.mark.regress
def test_data_taken_a_clock_too_early_are_seen(small, monkeypatch):
    """As if a register in the pins' cells had been forgotten: no golden picture comes."""
    monkeypatch.setattr(core, "_WIRES_LATE", 1)
    with pytest.raises(AssertionError):
        run = small.run(9000, optimise="-O1")
        check(small, run)
        small.shown(run)


@pytest.mark.regress
@pytest.mark.parametrize("fault,said", [
    ("memory", "a frame of the screen is no frame of the sensor"),
    ("screen", "inputs change")])
def test_a_clock_at_the_wrong_time_is_seen(fault, said, monkeypatch):
    """The SDRAM's clock in phase with the core's; the converter's with the colours."""
    rising = quartus_top.clock_out
    if fault == "screen":
        monkeypatch.setattr(quartus_top, "clock_out", lambda m, domain, port, falling=False: rising(
            m, domain, port))
    bench = Bench("de1-soc", SMALL, (WIDTH, HEIGHT))
    with pytest.raises((AssertionError, SimulationError), match=said):
        run = bench.run(9000, optimise="-O1", edit=in_phase if fault == "memory" else None)
        check(bench, run)
        bench.shown(run)


def in_phase(verilog):
    """The top with an SDRAM's clock that is not late."""
    late = f'.phase_shift1("{board("de1-soc").clock_plan(SMALL).phase_ps} ps")'
    assert verilog.count(late) == 1
    return verilog.replace(late, '.phase_shift1("0 ps")')


@pytest.mark.regress
@pytest.mark.parametrize("out_ps,back_ps", [(1000, 500), (5000, 2500)])
def test_pins_may_be_fast_or_slow(out_ps, back_ps):
    """Voltage, temperature and the piece decide: the SDRAM's words are taken right at each end."""
    bench = Bench("de1-soc", SMALL, (WIDTH, HEIGHT))
    run = bench.run(9000, optimise="-O1", edit=lambda verilog: (
        f"`define NCDC_FLIGHT {out_ps}\n`define NCDC_BACK {back_ps}\n{verilog}"))
    check(bench, run)
    assert any(number is not None for number in bench.shown(run))


@pytest.mark.regress
@pytest.mark.parametrize("name,mode,run_ms", [
    *((name, "640x480", 190) for name in ("ulx3s", *QUARTUS[:2])), ("de2-115", "1280x720", 350),
    ("ulx3s", "1280x720@20", 700)])
def test_a_whole_screen(name, mode, run_ms):
    """As large as the mode, with a camera and a corrector at work."""
    mode = mode_named(mode)
    bench = Bench(name, mode, mode.size, frames=4,
                  hardware=replace(hardware_for(board(name)), strip=256))
    run = bench.run(1000 * run_ms, optimise="-O2")
    check(bench, run)
    numbers = bench.shown(run)
    first = next(k for k, number in enumerate(numbers) if number is not None)
    assert None not in numbers[first:], "black after the first frame"
    assert len(set(numbers[first:])) >= 3
