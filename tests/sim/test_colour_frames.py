"""Whole frames in colour by windows of 6x6 samples: the generated Verilog and the golden model."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.example import noise_picture
from ncdc_model.golden.network import coordinates
from ncdc_model.golden.picture import window_address
from ncdc_model.planner.follow import follow_bound
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.colour import Colour
from ncdc_spec.geometry import BAYERS
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL, GRADIENT

regress = pytest.mark.regress


both = pytest.mark.parametrize("needs", [GRADIENT, DIRECTIONAL], ids=lambda each: each.name)


def camera(size=(48, 40), distorted=(72, 49), bayer="GBRG", needs=GRADIENT):
    """A camera whose corrected picture shows all four edges of its raw frame."""
    return barrel_descriptor(size, distorted, bayer=bayer, interpolation=needs)


def check(descriptor, hardware, memory="sdram", *, crest=0, raw=None, **options):
    """The simulation of a frame, by default of noise; only directional hardware has a crest."""
    geometry = descriptor.geometry
    if raw is None:
        raw = np.random.default_rng(1).integers(0, 256, geometry.distorted[::-1], np.uint8)
    colour = Colour(crest=crest * (geometry.interpolation == DIRECTIONAL))
    simulation = simulate_correction(descriptor, raw, hardware, memory=memory, colour=colour,
                                     **options)
    report = simulation.report()
    assert report["pixels_different"] == 0
    assert report["pixels_compared"] == geometry.corrected_width * geometry.corrected_height
    assert report["windows_fetched"] == report["windows_fetched_expected"] > 0
    return simulation


def test_the_camera_shows_all_four_edges():
    descriptor = camera()
    geometry = descriptor.geometry
    v, u = np.indices(geometry.corrected[::-1])
    x0, y0, *_, inside = window_address(*coordinates(descriptor, u, v), geometry,
                                        descriptor.formats.coordinate)
    inside &= descriptor.valid.mask(geometry.corrected_width)
    for first, size in ((x0, geometry.distorted_width), (y0, geometry.distorted_height)):
        assert (first[inside].min(), first[inside].max()) == (0, size - 2)
    assert not inside.all()


@both
def test_a_frame_is_that_of_the_golden_model(needs):
    check(camera(needs=needs), Hardware(output="stream"), simulator="icarus")


@pytest.mark.parametrize("lanes,settings,memory", [
    pytest.param(1, dict(output="stream"), "sdram", marks=pytest.mark.longer),
    pytest.param(1, dict(strip=32, data_width=64), "hostile", marks=regress),
    pytest.param(2, dict(output="stream", data_width=64), "hostile", marks=regress),
    pytest.param(4, dict(strip=32, data_width=128), "ddr3", marks=regress)])
def test_each_filter_and_crest_on_the_same_verilog(lanes, settings, memory):
    """The filter and the crest are registers. Black and white noise is farthest out of range."""
    hardware = Hardware(lanes=lanes, **settings)
    verilog = corrector_verilog(camera(needs=DIRECTIONAL), hardware)
    for bayer in BAYERS:
        descriptor = camera(bayer=bayer, needs=DIRECTIONAL)
        raw = noise_picture(*descriptor.geometry.distorted)
        plain, mild, strong = (check(descriptor, hardware, memory, crest=crest, raw=raw,
                                     verilog=verilog).picture for crest in CRESTS.values())
        assert (mild != plain).any() and (mild != strong).any()


@regress
@both
def test_hardware_made_for_colours_corrects_a_grey_frame(needs):
    hardware = Hardware(output="stream")
    simulation = check(camera(bayer="MONO", needs=needs), hardware, simulator="icarus",
                       verilog=corrector_verilog(camera(needs=needs), hardware))
    seen = simulation.picture[~simulation.blank]
    assert (seen == seen[:, :1]).all() and np.ptp(seen) > 200


@regress
@both
@pytest.mark.parametrize("bayer,crest,settings,memory", [
    ("RGGB", 0, dict(data_width=32), "sdram"),
    ("GRBG", 1, dict(data_width=64, output="stream"), "hostile"),
    ("BGGR", 0, dict(data_width=128, lanes=2, output="stream"), "ddr3"),
    ("RGGB", 2, dict(data_width=128, lanes=4, strip=32), "ddr3"),
    ("MONO", 1, dict(data_width=64, lanes=2), "hostile"),
])
def test_every_mode(needs, bayer, crest, settings, memory):
    check(camera(bayer=bayer, needs=needs), Hardware(**settings), memory, crest=crest)


def check_early_start(descriptor, hardware, memory="sdram", **options):
    """A frame that begins with the camera's reads no row too early and ends in its bound."""
    line = descriptor.geometry.distorted_width
    simulation = check(descriptor, hardware, memory, follow_line=line, **options)
    assert simulation.follow["follow_early_reads"] == 0
    hardware = hardware.made_for(descriptor)
    bound = follow_bound(descriptor, hardware, memory_timing(memory),
                         Corrector(descriptor, hardware).timing, camera=line)
    assert 0 < simulation.follow["follow_latency_clocks"] <= bound.clocks


@regress
@both
@pytest.mark.parametrize("crest,settings", [
    (0, dict()), (2, dict(lanes=2, data_width=64)), (1, dict(lanes=4, data_width=128))])
def test_a_frame_follows_its_camera(needs, crest, settings):
    check_early_start(camera(needs=needs), Hardware(output="stream", **settings), crest=crest)


SXGA, FHD = (1280, 1024), (1920, 1080)


@pytest.mark.many_clocks
@regress
@both
@pytest.mark.parametrize("size,crest,settings,memory", [
    (SXGA, 1, dict(output="stream"), "sdram"),
    (FHD, 0, dict(output="stream", data_width=128), "ddr3")])
def test_large_frames(needs, size, crest, settings, memory):
    # The weights of the first seed leave their format at 1920 columns.
    check(barrel_descriptor(size, size, seed=2, interpolation=needs), Hardware(**settings), memory,
          crest=crest)


@pytest.mark.many_clocks
@regress
def test_a_large_frame_follows_its_camera():
    check_early_start(barrel_descriptor(SXGA, SXGA, 12, strength=.1, bayer="GRBG",
                                        interpolation=DIRECTIONAL),
                      Hardware(output="stream", data_width=64), crest=1)


@pytest.mark.many_clocks
@regress
@both
@pytest.mark.parametrize("size,neurons,bayer,crest,settings,memory", [
    (SXGA, 12, "RGGB", 0, dict(), "sdram"), (SXGA, 16, "GBRG", 2, dict(strip=128), "sdram"),
    (SXGA, 12, "MONO", 1, dict(output="stream"), "sdram"),
    (FHD, 12, "BGGR", 2, dict(output="stream", data_width=128), "ddr3"),
    (FHD, 16, "GRBG", 1, dict(output="stream", data_width=128, lanes=2), "ddr3"),
    (FHD, 16, "RGGB", 0, dict(output="stream", data_width=128, lanes=4), "ddr3")])
def test_large_frames_at_nodes(needs, size, neurons, bayer, crest, settings, memory):
    """Streams keep the rate: 0.5 % over a clock per pixel and lane."""
    plain = barrel_descriptor(size, size, neurons, strength=.1, bayer=bayer,
                              interpolation=needs)
    hardware = Hardware(**settings)
    report = check(replace(plain, nodes=16), hardware, memory, crest=crest).report()
    if hardware.stream:
        assert report["clocks_per_pixel"] * hardware.lanes <= 1.005
