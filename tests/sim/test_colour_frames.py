"""Whole frames in colour by windows of 6x6 samples: the generated Verilog and the golden model."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.planner.follow import follow_bound
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.colour import Colour
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, GRADIENT

regress = pytest.mark.regress


both = pytest.mark.parametrize("needs", [GRADIENT, DIRECTIONAL], ids=lambda each: each.name)


def camera(size=(48, 40), distorted=(72, 49), bayer="GBRG", needs=GRADIENT):
    """A camera whose corrected picture shows all four edges of its raw frame."""
    return barrel_descriptor(size, distorted, bayer=bayer, interpolation=needs)


def check(descriptor, hardware, memory="sdram", **options):
    geometry = descriptor.geometry
    raw = np.random.default_rng(1).integers(0, 256, geometry.distorted[::-1], np.uint8)
    simulation = simulate_correction(descriptor, raw, hardware, memory=memory, **options)
    report = simulation.report()
    assert report["pixels_different"] == 0
    assert report["pixels_compared"] == geometry.corrected_width * geometry.corrected_height
    assert report["windows_fetched"] == report["windows_fetched_expected"] > 0
    return simulation


@both
def test_a_frame_is_that_of_the_golden_model(needs):
    check(camera(needs=needs), Hardware(output="stream"), simulator="icarus")


@pytest.mark.parametrize("crest", [1, 2])
def test_a_frame_with_crests(crest):
    descriptor = camera(needs=DIRECTIONAL)
    made = check(descriptor, Hardware(output="stream"), colour=Colour(crest=crest))
    plain = check(descriptor, Hardware(output="stream"))
    assert (made.picture != plain.picture).any()


@pytest.mark.regress
def test_hardware_made_for_colours_corrects_a_grey_frame():
    hardware = Hardware(output="stream")
    grey = camera(bayer="MONO")
    simulation = check(grey, hardware, simulator="icarus",
                       verilog=corrector_verilog(camera(), hardware))
    seen = simulation.picture[~simulation.blank]
    assert (seen == seen[:, :1]).all() and np.ptp(seen) > 200


@regress
@both
@pytest.mark.parametrize("bayer,settings,memory", [
    ("RGGB", dict(data_width=32), "sdram"),
    ("GRBG", dict(data_width=64, output="stream"), "hostile"),
    ("BGGR", dict(data_width=128, lanes=2, output="stream"), "ddr3"),
    ("RGGB", dict(data_width=128, lanes=4, strip=32), "ddr3"),
    ("MONO", dict(data_width=64, lanes=2), "hostile"),
])
def test_every_mode(needs, bayer, settings, memory):
    check(camera(bayer=bayer, needs=needs), Hardware(**settings), memory)


@regress
@both
def test_a_frame_follows_its_camera(needs):
    descriptor, hardware = camera(needs=needs), Hardware(output="stream")
    line = descriptor.geometry.distorted_width
    simulation = check(descriptor, hardware, follow_line=line)
    assert simulation.follow["follow_early_reads"] == 0
    hardware = hardware.made_for(descriptor)
    bound = follow_bound(descriptor, hardware, memory_timing("sdram"),
                         Corrector(descriptor, hardware).timing, line=line)
    assert 0 < simulation.follow["follow_latency_clocks"] <= bound.clocks


SXGA, FHD = (1280, 1024), (1920, 1080)


@pytest.mark.many_clocks
@regress
@both
@pytest.mark.parametrize("size,settings,memory", [
    (SXGA, dict(output="stream"), "sdram"),
    (FHD, dict(output="stream", data_width=128), "ddr3")])
def test_large_frames(needs, size, settings, memory):
    # The weights of the first seed leave their format at 1920 columns.
    check(barrel_descriptor(size, size, seed=2, interpolation=needs), Hardware(**settings), memory)


@pytest.mark.many_clocks
@regress
@both
@pytest.mark.parametrize("size,neurons,bayer,settings,memory", [
    (SXGA, 12, "RGGB", dict(), "sdram"), (SXGA, 16, "GBRG", dict(strip=128), "sdram"),
    (SXGA, 12, "MONO", dict(output="stream"), "sdram"),
    (FHD, 12, "BGGR", dict(output="stream", data_width=128), "ddr3"),
    (FHD, 16, "GRBG", dict(output="stream", data_width=128, lanes=2), "ddr3"),
    (FHD, 16, "RGGB", dict(output="stream", data_width=128, lanes=4), "ddr3")])
def test_large_frames_at_nodes(needs, size, neurons, bayer, settings, memory):
    """Streams keep the rate: 0.5 % over a clock per pixel and lane."""
    plain = barrel_descriptor(size, size, neurons, strength=.1, bayer=bayer,
                              interpolation=needs)
    hardware = Hardware(**settings)
    report = check(replace(plain, nodes=16), hardware, memory).report()
    if hardware.stream:
        assert report["clocks_per_pixel"] * hardware.lanes <= 1.005
