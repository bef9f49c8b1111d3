"""Frames that begin before the camera's is complete: Verilog, bench and the planner's bound."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main, simulate
from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.backend.row_gate import RowGate
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.correction import correct
from ncdc_model.images import write_image
from ncdc_model.planner.follow import camera_line, follow_bound, rows_needed
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Camera, Program, simulate_frame
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, registers

SIZE = 48, 64


def noise(geometry, seed=1):
    return np.random.default_rng(seed).integers(0, 256, geometry.distorted[::-1], dtype=np.uint8)


@pytest.fixture(scope="module")
def small():
    return barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4)


@pytest.fixture(scope="module")
def verilog(small):
    return corrector_verilog(small, Hardware(output="stream"))


def followed(descriptor, hardware=Hardware(output="stream"), *, memory="sdram", line=None,
             **options):
    """A simulated frame, and the planner's bound on it."""
    geometry = descriptor.geometry
    simulation = simulate_correction(descriptor, noise(geometry), hardware, memory=memory,
                                     follow_line=camera_line(line, geometry), **options)
    hardware = hardware.made_for(descriptor)
    bound = follow_bound(descriptor, hardware, memory_timing(memory),
                         Corrector(descriptor, hardware).timing, camera=line)
    return simulation, bound


def test_rows_needed_are_those_of_whole_tiles():
    y0, used = np.array([0, 1, 2, 5, 6, 27, 3]), np.array([1, 1, 1, 1, 1, 1, 0], bool)
    assert rows_needed(y0, used, 30).tolist() == [4, 4, 8, 8, 12, 30, 0]
    assert rows_needed(y0, used, 30, GRADIENT).tolist() == [4, 6, 6, 10, 10, 30, 0]


@pytest.mark.longer
def test_a_frame_follows_its_camera(small, verilog):
    simulation, bound = followed(small, verilog=verilog, simulator="icarus")
    assert simulation.differing == []
    assert simulation.follow["follow_early_reads"] == 0
    # It begins with the camera, and ends soon after it.
    latency = simulation.follow["follow_latency_clocks"]
    assert 0 < latency <= bound.clocks < bound.camera_clocks / 2
    assert simulation.counters["CLOCKS"] < bound.camera_clocks + bound.clocks
    assert bound.camera_clocks == 48 * 64


@pytest.mark.longer
def test_a_gate_that_opens_a_row_early_is_caught(small, monkeypatch):
    monkeypatch.setattr(RowGate, "_after", staticmethod(lambda each: each.after - 1))
    simulation, _ = followed(small, verilog=corrector_verilog(small, Hardware(output="stream")))
    assert simulation.follow["follow_early_reads"] > 0


@pytest.mark.longer
def test_two_frames_in_two_buffers(small, verilog):
    """The camera begins its second frame, elsewhere, while the first one is being corrected."""
    rows = {r.name: r.address for r in registers(2, small.formats)}
    first, second = noise(small.geometry, 1), noise(small.geometry, 2)
    size = first.size
    program = Program().write(rows["IRQ_ENABLE"], 1).write(rows["FOLLOW"], 1)
    program.write(rows["SOURCE_BASE"], 0).camera(0).write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    program.wait(size).write(rows["SOURCE_BASE"], size)
    program.write(rows["SOURCE_LIMIT"], 2 * size).camera(size)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    program.wait_irq().write(rows["STATUS"], 2).wait_irq()
    result = simulate_frame(
        verilog, first.tobytes() + second.tobytes(), program, source_base=0, output_base=1 << 16,
        output_bytes=6 * size, memory="sdram",
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
    def bound(strip=0, line=None, output="stream"):
        hardware = Hardware(cache=CacheOptions(tiles=64), split=1, strip=strip, output=output)
        return follow_bound(small, hardware, memory_timing("ideal"),
                            Corrector(small, hardware).timing, camera=line)
    usual = bound()
    assert bound(line=4 * 48).clocks < usual.clocks
    assert bound(line=4 * 48).camera_clocks == 63 * 4 * 48 + 48
    assert bound(32, output="memory").clocks > bound(output="memory").clocks + 32 * 64 / 4
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
            (["--line-clocks", "90"], "the camera's line is 90 clocks, which needs --follow"),
            (["--follow", "--line-clocks", "47"],
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
    hardware = Hardware(data_width=data_width, output=output, lanes=lanes)
    simulation, bound = followed(descriptor, hardware, memory=memory, line=line)
    assert simulation.differing == [] and simulation.follow["follow_early_reads"] == 0
    latency = simulation.follow["follow_latency_clocks"]
    assert bound.clocks - .02 * simulation.counters["CLOCKS"] < latency <= bound.clocks


@pytest.mark.regress
def test_the_command_fails_when_the_bound_is_exceeded(small, tmp_path, monkeypatch, capsys):
    small.save(tmp_path / "net.toml")
    write_image(tmp_path / "raw.png", noise(small.geometry))
    command = ["simulate", str(tmp_path / "net.toml"), str(tmp_path / "raw.png"), "-o",
               str(tmp_path / "out.png"), "--follow", "--to", "stream", "--simulator", "icarus"]
    assert main(command) == 0
    capsys.readouterr()
    true_bound = simulate.bound_of

    def half(*args):
        bound = true_bound(*args)
        return replace(bound, clocks=bound.clocks // 2)
    monkeypatch.setattr(simulate, "bound_of", half)
    assert main(command) == 1
    assert " are the planner's limit\n" in capsys.readouterr().err


@pytest.mark.longer
def test_the_bound_counts_pixels_that_wait_for_nodes():
    """Four pixels per clock at nodes of 8, and a camera as fast: nodes are what takes longest."""
    descriptor = replace(barrel_descriptor((96, 40), (96, 40), hidden_neurons=2), nodes=8)
    hardware = Hardware(data_width=64, output="stream", lanes=4)
    assert not hardware.keeps_rate(descriptor)
    simulation, bound = followed(descriptor, hardware, memory="ideal")
    assert simulation.differing == []
    assert simulation.follow["follow_latency_clocks"] <= bound.clocks


@pytest.mark.regress
@pytest.mark.parametrize("fetcher", ["cache", "multiport"])
def test_a_hostile_memory_makes_no_read_early(fetcher):
    descriptor = barrel_descriptor((45, 37), (45, 37), hidden_neurons=2, strength=.4)
    simulation = simulate_correction(descriptor, noise(descriptor.geometry),
                                     Hardware(fetcher=fetcher), memory="hostile", follow_line=45)
    assert simulation.differing == [] and simulation.follow["follow_early_reads"] == 0


@pytest.mark.many_clocks
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
