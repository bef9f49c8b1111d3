"""Whole frames with white balance and tone: the generated Verilog against the golden model."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.colour import Colour, ColourSums
from ncdc_model.corrector import correct
from ncdc_model.hardware import Hardware
from ncdc_model.interpolation import FAST, GRADIENT
from ncdc_model.tone import tone_named
from ncdc_sim.system.corrector import simulate_correction

SET = Colour((461, 200, 358), tone_named("sRGB"))
FILL = (200, 100, 50)


def camera(bayer="GBRG", interpolation=GRADIENT):
    """A camera whose corrected picture has blank pixels, of a colour that the gains would change.
    """
    return barrel_descriptor((48, 40), (72, 49), bayer=bayer, interpolation=interpolation,
                             fill=FILL)


def noise(d):
    return np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


@pytest.mark.parametrize("settings,memory,options", [
    (dict(), "sdram", {}), (dict(output="stream"), "hostile", {"sink_chance": 150}),
    (dict(lanes=4, data_width=128, strip=32), "ddr3", {}),
    (dict(lanes=4, data_width=128, output="stream"), "hostile", {"sink_chance": 60})])
def test_verilog_equals_golden(settings, memory, options):
    d = camera()
    result = simulate_correction(d, noise(d), Hardware(colour=True, **settings), colour=SET,
                                 memory=memory, **options)
    plain = correct(d, noise(d))
    assert result.differing == []
    assert result.sums == result.sums_expected == ColourSums.of(plain).registers
    assert (result.picture[result.blank] == FILL).all() and result.blank.any()
    assert (result.picture != plain.picture).mean() > .5


@pytest.mark.parametrize("interpolation,fetcher", [(GRADIENT, "cache"), (FAST, "multiport")])
def test_without_a_host_the_picture_is_as_without_colour(interpolation, fetcher):
    """At reset values; and each pixel comes later by the part's latency, no more."""
    d = camera(interpolation=interpolation)
    plain, with_colour = (simulate_correction(
        d, noise(d), Hardware(fetcher=fetcher, output="stream", colour=colour), memory="ideal")
        for colour in (False, True))
    np.testing.assert_array_equal(with_colour.picture, plain.picture)
    later = [Corrector(d, Hardware(fetcher=fetcher, colour=colour)).end_latency
             for colour in (False, True)]
    assert with_colour.counters["CLOCKS"] - plain.counters["CLOCKS"] == later[1] - later[0] > 0


def test_a_grey_sensor_has_equal_sums():
    d = camera("MONO")
    result = simulate_correction(d, noise(d), Hardware(colour=True), colour=SET)
    assert result.differing == []
    assert result.sums == result.sums_expected
    assert result.sums["RED_SUM"] == result.sums["GREEN_SUM"] == result.sums["BLUE_SUM"] > 0


@pytest.mark.parametrize("right,wrong,pixels,sums", [
    ("gain_p1_1[7]", "gain_p1_1[6]", True, False),                      # rounds elsewhere
    ("issue & ~i__payload_blank;", "issue;", False, True)])             # blank pixels count
def test_a_planted_error_is_found(right, wrong, pixels, sums):
    d, hardware = camera(), Hardware(colour=True)
    verilog = corrector_verilog(d, hardware)
    assert verilog.count(right) == 1
    result = simulate_correction(d, noise(d), hardware, colour=SET,
                                 verilog=verilog.replace(right, wrong))
    assert bool(result.differing) == pixels
    assert (result.sums != result.sums_expected) == sums


def test_hardware_without_colour_has_nothing_of_it():
    text = corrector_verilog(camera(), Hardware())
    assert not any(name in text for name in ("gain_red", "tone0", "red_sum", "balanced0"))
    assert "gain_red" in corrector_verilog(camera(), Hardware(colour=True))
    assert Corrector(camera()).interpolator.queued == 32
