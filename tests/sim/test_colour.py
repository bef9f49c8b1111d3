"""Whole frames with white balance and tone: the generated Verilog equals the golden model."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.correction import correct
from ncdc_model.golden.colour import ColourSums, coloured
from ncdc_model.golden.tone import tone_named
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.colour import Colour
from ncdc_spec.frames import frame_bytes, raw_image, stored_picture
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT
from ncdc_spec.registers.host_values import colour_values, host_values
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, STATUS_DONE, registers
from ncdc_spec.white_balance import grey_world

pytestmark = pytest.mark.longer

SET = Colour((461, 200, 358), tone_named("sRGB"))
FILL = (200, 100, 50)
regress = pytest.mark.regress


def camera(bayer="GBRG", interpolation=GRADIENT):
    """A camera whose corrected picture has blank pixels, of a colour that the gains would change.
    """
    return barrel_descriptor((48, 40), (72, 49), bayer=bayer, interpolation=interpolation,
                             fill=FILL)


def noise(d):
    return np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


@pytest.mark.parametrize("settings,memory,options", [
    pytest.param(dict(), "sdram", {}, marks=regress),
    (dict(output="stream"), "hostile", {"sink_probability": 150}),
    pytest.param(dict(lanes=4, data_width=128, strip=32), "ddr3", {}, marks=regress),
    pytest.param(dict(lanes=4, data_width=128, output="stream"), "hostile",
                 {"sink_probability": 60}, marks=regress)])
def test_verilog_equals_golden(settings, memory, options):
    d = camera()
    result = simulate_correction(d, noise(d), Hardware(colour=True, **settings), colour=SET,
                                 memory=memory, **options)
    plain = correct(d, noise(d))
    assert result.differing == []
    assert result.sums == result.sums_expected == ColourSums.of(plain).registers
    assert (result.picture[result.blank] == FILL).all() and result.blank.any()
    assert (result.picture != plain.picture).mean() > .5


@regress
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


@regress
def test_a_grey_sensor_has_equal_sums():
    d = camera("MONO")
    hardware = Hardware(colour=True)
    result = simulate_correction(d, noise(d), hardware, colour=SET,
                                 verilog=corrector_verilog(camera(), hardware))
    assert result.differing == []
    assert result.sums == result.sums_expected
    assert result.sums["RED_SUM"] == result.sums["GREEN_SUM"] == result.sums["BLUE_SUM"] > 0


@pytest.mark.parametrize("right,wrong,pixels,sums", [
    ("balanced1_p1[7]", "balanced1_p1[6]", True, False),                      # rounds elsewhere
    pytest.param("issue & ~i__payload_blank;", "issue;", False, True,   # blank pixels count
                 marks=regress)])
def test_a_planted_error_is_found(right, wrong, pixels, sums):
    d, hardware = camera(), Hardware(colour=True)
    verilog = corrector_verilog(d, hardware)
    assert verilog.count(right) == 1
    result = simulate_correction(d, noise(d), hardware, colour=SET,
                                 verilog=verilog.replace(right, wrong))
    assert bool(result.differing) == pixels
    assert (result.sums != result.sums_expected) == sums


def test_a_host_balances_the_next_frame_while_one_runs():
    """The frame that runs keeps its colours, the next one has the gains of a host that knows the
    sums, and DIGEST still identifies the lens."""
    d, hardware = camera(), Hardware(colour=True)
    raw, golden = noise(d), correct(d, noise(d))
    balanced = Colour(grey_world((3, 5, 4)), tone_named("gamma:2.2"))
    rows = {r.name: r.address for r in registers(d.hidden_neurons, d.formats, colour=True)}
    host, size = host_values(d, hardware), frame_bytes(d.geometry)
    first, second = host["TARGET_BASE"], host["TARGET_BASE"] + size
    program = Program().write(rows["IRQ_ENABLE"], 1).write(rows["CTRL"], CTRL_START)
    for name, value in (colour_values(balanced) | {
            "TARGET_BASE": second, "TARGET_LIMIT": second + size}).items():
        program.write(rows[name], value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START).wait_irq()
    sums = ColourSums.of(golden).registers
    for name, value in sums.items():
        program.compare(rows[name], value)
    program.write(rows["STATUS"], STATUS_DONE).wait_irq().compare(rows["ALTERED"], 0)
    for name, value in sums.items():
        program.compare(rows[name], value)
    result = simulate_frame(corrector_verilog(d, hardware), raw_image(raw, host["SOURCE_PITCH"]),
                            program, source_base=host["SOURCE_BASE"], output_base=first,
                            output_bytes=2 * size, memory="sdram")
    pictures = np.frombuffer(result.output, np.uint8).reshape(2, 40, 48, 4)
    np.testing.assert_array_equal(stored_picture(pictures[0]), golden.picture)
    np.testing.assert_array_equal(stored_picture(pictures[1]), coloured(golden, balanced))


def test_hardware_without_colour_has_nothing_of_it():
    text = corrector_verilog(camera(), Hardware())
    assert not any(name in text for name in ("gain_red", "tone0", "red_sum", "balanced0"))
    assert "gain_red" in corrector_verilog(camera(), Hardware(colour=True))
    deep = camera(interpolation=DIRECTIONAL)        # its pipeline needs more than the least queue
    plain, coloured = (Corrector(deep, Hardware(colour=colour)).interpolator
                       for colour in (False, True))
    assert coloured.queued - plain.queued == coloured.latency - plain.latency == 10
