"""Frames that begin before the camera's is complete: Verilog, bench and the planner's bound."""

import json

import numpy as np
import pytest
from cameras import barrel_descriptor

from ncdc_hdl.avalon.register_table import CTRL_COMMIT, CTRL_START, host_values, registers
from ncdc_hdl.backend import row_gate
from ncdc_hdl.bench.lenses import Lens, trained
from ncdc_hdl.cli import main
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_hdl.options import FetchOptions, FrontEndOptions
from ncdc_model.corrector import correct
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.follow import follow_bound, rows_needed
from ncdc_model.images import write_image
from ncdc_model.memory_timing import memory_timing
from ncdc_sim.corrector import simulate_correction
from ncdc_sim.frame import Camera, Program, simulate_frame

SIZE = 48, 64


def noise(geometry, seed=1):
    return np.random.default_rng(seed).integers(0, 256, geometry.distorted[::-1], dtype=np.uint8)


@pytest.fixture(scope="module")
def small():
    return barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4)


@pytest.fixture(scope="module")
def verilog(small):
    return corrector_verilog(small, output="stream")


def followed(descriptor, *, output="stream", memory="sdram", lanes=1, data_width=32, line=None,
             fetch=FetchOptions(), simulator="verilator", **options):
    """A simulated frame, and the planner's bound on it."""
    simulation = simulate_correction(
        descriptor, noise(descriptor.geometry), output=output, memory=memory, fetch=fetch,
        data_width=data_width, front_end=FrontEndOptions(lanes=lanes), follow=True, line=line,
        simulator=simulator, **options)
    geometry = descriptor.geometry
    values, split = host_values(descriptor, data_width), fetch.split_for(geometry)
    bound = follow_bound(
        descriptor, fetch.cache_for(geometry), split, memory_timing(memory), data_width,
        strip=fetch.strip, lanes=lanes, stream=output == "stream", line=line,
        base=values["SOURCE_BASE"], pitch=values["SOURCE_PITCH"], target=values["TARGET_BASE"])
    return simulation, bound


def test_rows_needed_are_those_of_whole_tiles():
    y0, used = np.array([0, 1, 2, 5, 6, 27, 3]), np.array([1, 1, 1, 1, 1, 1, 0], bool)
    assert rows_needed(y0, used, 30).tolist() == [4, 4, 8, 8, 12, 30, 0]


def test_a_frame_follows_its_camera(small, verilog):
    simulation, bound = followed(small, verilog=verilog, simulator="icarus")
    assert simulation.differing == []
    assert simulation.follow["follow_early_reads"] == 0
    # It begins with the camera, and ends soon after it.
    latency = simulation.follow["follow_latency_clocks"]
    assert 0 < latency <= bound.clocks < bound.camera_clocks / 2
    assert simulation.counters["CLOCKS"] < bound.camera_clocks + bound.clocks
    assert bound.camera_clocks == 48 * 64


def test_a_gate_that_opens_a_row_early_is_caught(small, monkeypatch):
    monkeypatch.setattr(row_gate, "WINDOW", row_gate.WINDOW - 1)
    simulation, _ = followed(small, verilog=corrector_verilog(small, output="stream"),
                             simulator="icarus")
    assert simulation.follow["follow_early_reads"] > 0


def test_two_frames_in_two_buffers(small, verilog):
    """The camera begins its second frame, elsewhere, while the first one is being corrected."""
    rows = {r.name: r.address for r in registers(2, small.formats)}
    first, second = noise(small.geometry, 1), noise(small.geometry, 2)
    size = first.size
    program = Program().write(rows["IRQ_ENABLE"], 1).write(rows["FOLLOW"], 1)
    program.write(rows["SOURCE_BASE"], 0).camera(0).write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    program.wait(size).write(rows["SOURCE_BASE"], size).camera(size)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    program.wait_irq().write(rows["STATUS"], 2).wait_irq()
    result = simulate_frame(
        verilog, first.tobytes() + second.tobytes(), program, source_base=0, output_base=1 << 16,
        output_bytes=6 * size, memory="sdram", simulator="icarus",
        camera=Camera(*SIZE, SIZE[0], SIZE[0]))
    pictures = np.frombuffer(result.output, np.uint8).reshape(2, SIZE[1], SIZE[0], 3)
    for raw, picture in zip((first, second), pictures):
        np.testing.assert_array_equal(picture, correct(small, raw).picture)
    assert result.counters["early_reads"] == 0
    # The first frame ended after the second one of the camera had begun.
    assert result.ends[0] > result.counters["camera_end"] - size


def test_the_bound_counts_the_rows_that_come_late(small):
    """A camera that takes four times as long per row leaves only what its last rows are needed for;
    one pixel per clock in strips leaves nearly everything."""
    def bound(**options):
        values = host_values(small, 32)
        return follow_bound(small, CacheOptions(tiles=64), 1, memory_timing("ideal"), 32,
                            stream=True, pitch=values["SOURCE_PITCH"], target=0, **options)
    usual = bound()
    assert bound(line=4 * 48).clocks < usual.clocks
    assert bound(line=4 * 48).camera_clocks == 63 * 4 * 48 + 48
    assert bound(strip=32).clocks > usual.clocks + 32 * 64 / 4
    assert usual.share == usual.clocks / (48 * 64)


def test_the_commands_report_the_bound(small, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    small.save("net.toml")
    assert main(["plan", "net.toml", "--memory", "sdram", "--to", "stream", "--follow", "--json",
                 "plan.json"]) == 0
    report = json.loads((tmp_path / "plan.json").read_text())
    assert report["strip"] == 0
    assert f"out at most {report['follow_bound_clocks']} clocks after its last byte" in \
        capsys.readouterr().out
    for options, message in (
            (["--camera-line", "90"], "the camera's line is 90 clocks, which needs --follow"),
            (["--follow", "--camera-line", "47"],
             "a row of the camera takes 47 clocks, the limits are 48 and 65535")):
        assert main(["plan", "net.toml", *options]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.regress
@pytest.mark.parametrize("memory,data_width,output,lanes,line", [
    ("sdram", 32, "memory", 1, None), ("ddr3", 128, "memory", 1, None),
    ("ddr3", 128, "stream", 2, None), ("fixed:100:4", 32, "stream", 1, None),
    ("sdram", 32, "stream", 1, 300), ("ideal", 32, "stream", 1, None)])
def test_bounds_hold(memory, data_width, output, lanes, line):
    descriptor = barrel_descriptor((160, 120), (160, 120), hidden_neurons=4, strength=.5)
    simulation, bound = followed(descriptor, memory=memory, data_width=data_width, output=output,
                                 lanes=lanes, line=line)
    assert simulation.differing == [] and simulation.follow["follow_early_reads"] == 0
    latency = simulation.follow["follow_latency_clocks"]
    assert bound.clocks - .02 * simulation.counters["CLOCKS"] < latency <= bound.clocks


@pytest.mark.regress
@pytest.mark.parametrize("fetcher", ["cache", "multiport"])
def test_a_hostile_memory_makes_no_read_early(fetcher):
    descriptor = barrel_descriptor((45, 37), (45, 37), hidden_neurons=2, strength=.4)
    simulation = simulate_correction(descriptor, noise(descriptor.geometry), memory="hostile",
                                     fetch=FetchOptions(fetcher), follow=True)
    assert simulation.differing == [] and simulation.follow["follow_early_reads"] == 0


@pytest.mark.regress
def test_a_wide_lens_at_full_size(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    descriptor = trained(Lens(105, (1280, 1024)))
    descriptor.save("net.toml")
    write_image("raw.png", noise(descriptor.geometry))
    assert main(["simulate", "net.toml", "raw.png", "-o", "out.png", "--to", "stream", "--follow",
                 "--json", "report.json"]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["pixels_different"] == report["follow_early_reads"] == 0
    assert report["follow_latency_clocks"] <= report["follow_bound_clocks"]
    assert report["follow_latency_clocks"] < report["camera_clocks"] / 4
