"""Whole frames of the Verilog with the network at nodes, in every way of making them."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.lenses import check_lens
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.planner.follow import camera_line, follow_bound
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import registers
from simulations.lens_change import simulate_lens_change


def at_nodes(nodes, size=(104, 30), neurons=4, **options):
    return replace(barrel_descriptor(size, (112, 36), neurons, fill=(200, 100, 50), **options),
                   nodes=nodes)


def noise(d, seed=1):
    return np.random.default_rng(seed).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


@pytest.mark.longer
@pytest.mark.parametrize("simulator,memory,nodes,hardware", [
    ("verilator", "hostile", 8, Hardware(data_width=64, strip=64, lanes=2, share=3)),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("verilator", "hostile", 8, Hardware(strip=32)),
        ("icarus", "sdram", 16, Hardware(output="stream", multiplier_bits=18)),
        ("verilator", "ddr3", 16, Hardware(data_width=64, output="stream", lanes=4)),
        ("verilator", "sdram", 16, Hardware(fetcher="multiport", share=2)),
        ("icarus", "ddr3", 8, Hardware(data_width=128, lanes=4))))])
def test_verilog_equals_golden(simulator, memory, nodes, hardware):
    d = at_nodes(nodes)
    result = simulate_correction(d, noise(d), hardware, memory=memory, simulator=simulator)
    assert result.differing == []
    assert result.counters["PIXELS"] == 104 * 30
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.blank.any() and not result.blank.all()


@pytest.mark.regress
def test_verilog_with_a_skip_path():
    plain = at_nodes(16)
    network = replace(plain.network, skip_weights=np.array([[3.25, -4.5], [1.0625, -7.75]]))
    d = Descriptor.quantise(network, plain.geometry, plain.valid, nodes=16)
    assert simulate_correction(d, noise(d), memory="sdram").differing == []


SXGA, FHD = (1280, 1024), (1920, 1080)


def of_real_size(size, neurons):
    return replace(barrel_descriptor(size, size, neurons, strength=.1), nodes=16)


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("size,neurons,settings", [
    (SXGA, 16, dict()), (SXGA, 12, dict(strip=128)), (SXGA, 12, dict(output="stream")),
    (FHD, 12, dict(output="stream")), (FHD, 16, dict(output="stream")),
    (FHD, 12, dict(output="stream", lanes=2)),
    (FHD, 16, dict(output="stream", lanes=4)), (FHD, 16, dict(strip=256, lanes=2))])
def test_whole_frames_of_real_size(size, neurons, settings):
    """And the cache's streams keep the rate: 0.5 % over a clock per pixel and lane."""
    d = of_real_size(size, neurons)
    hardware = Hardware(data_width=128, **settings)
    assert hardware.keeps_rate(d)
    result = simulate_correction(d, noise(d), hardware, memory="ddr3")
    assert result.differing == []
    assert result.counters["PIXELS"] == size[0] * size[1]
    if hardware.stream and hardware.cached:
        assert result.counters["CLOCKS"] * hardware.lanes / (size[0] * size[1]) <= 1.005


@pytest.mark.many_clocks
@pytest.mark.regress
def test_a_skip_path_at_real_size():
    plain = of_real_size(SXGA, 12)
    network = replace(plain.network, skip_weights=np.array([[3.25, -4.5], [1.0625, -7.75]]))
    d = Descriptor.quantise(network, plain.geometry, plain.valid, nodes=16)
    assert simulate_correction(d, noise(d), Hardware(output="stream"),
                               memory="sdram").differing == []


@pytest.mark.longer
@pytest.mark.parametrize("size,neurons", [
    ((104, 30), 4), pytest.param(SXGA, 12, marks=pytest.mark.regress)])
def test_a_frame_follows_its_camera(size, neurons):
    d, hardware = at_nodes(8, size, neurons), Hardware(output="stream")
    line = camera_line(None, d.geometry)
    result = simulate_correction(d, noise(d), hardware, memory="sdram", follow_line=line)
    made = hardware.made_for(d)
    bound = follow_bound(d, made, memory_timing("sdram"), Corrector(d, made).timing)
    assert result.differing == [] and result.follow["follow_early_reads"] == 0
    assert 0 < result.follow["follow_latency_clocks"] <= bound.clocks


@pytest.mark.longer
def test_another_lens_with_every_frame():
    wide, tele = at_nodes(16), at_nodes(16, (96, 24), seed=8, strength=.1)
    corrector = Corrector(wide, Hardware(data_width=64))
    result = simulate_lens_change(corrector, verilog_of(corrector),
                                  [(wide, noise(wide)), (tele, noise(tele, 2))], 8,
                                  memory="hostile", intruder=True)
    assert result.differing == (0,) * 8 and max(result.idle) <= 2


@pytest.mark.regress
def test_the_distance_is_shown_to_the_host():
    d = at_nodes(16)
    text = verilog_of(Corrector(d))
    assert "The network is evaluated at every 16th pixel of a row." in text
    rows = {r.name: r.address for r in registers(4, d.formats, 16)}
    result = simulate_frame(text, b"", Program().read(rows["NODES"]), source_base=0,
                            output_base=0, output_bytes=0, memory="ideal")
    assert result.registers[rows["NODES"]] == 16
    plain = Corrector(at_nodes(1))
    assert "NODES" not in {r.name for r in plain.registers.table}
    assert "every" not in verilog_of(plain).split("module")[0]


def test_lenses_of_other_nodes_or_too_curved_for_them_are_rejected():
    d = at_nodes(8, (320, 60))
    corrector = Corrector(d)
    check_lens(corrector, "net.toml", d)
    with pytest.raises(InputError, match="other.toml: pixels from node to node 16 does not fit a "
                                         "corrector made for 8"):
        check_lens(corrector, "other.toml", replace(d, nodes=16))
    curved = replace(d, hidden_weights=d.hidden_weights * 4)
    with pytest.raises(InputError, match="curved.toml: nodes 8 pixels apart miss this map by .* "
                                         "px, the limit is 0.001"):
        check_lens(corrector, "curved.toml", curved)


def test_hidden_neurons_that_follow_the_scan_are_rejected():
    with pytest.raises(InputError, match="hidden is raster, a network at every 16th pixel needs "
                                         "multiply"):
        Corrector(at_nodes(16), Hardware(hidden="raster"))
