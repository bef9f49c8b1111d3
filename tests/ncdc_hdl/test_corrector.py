"""The whole corrector: golden model compared with floating point, Verilog with both."""

import numpy as np
import pytest

from cameras import barrel_descriptor, barrel_map
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.correction import correct
from ncdc_model.golden.network import frame_coordinates
from ncdc_model.images import mosaic
from ncdc_model.reference import bayer_psnr, correct_real, grey_level_difference
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image, stored_picture
from ncdc_spec.geometry import BAYER_PHASE, Geometry, ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import address_values, host_values, table_words
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, registers

SIMULATORS = ["icarus", "verilator"]


def noise(d, seed=1):
    return np.random.default_rng(seed).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


def linear_descriptor(g, scale=1.0, shift=(0.0, 0.0), valid=None):
    """A map that is all but linear: x' = centre + scale (u - centre) + shift, within 0.005 px."""
    slope = 0.05       # so small that the tan-sigmoid is straight
    hidden = np.array([[slope, 0.0], [0.0, slope]])
    half = np.array([(size - 1) / 2 / 0.9999 for size in g.corrected])
    output = np.diag(scale * half * 2 / slope)
    centre = np.array([(size - 1) / 2 for size in g.distorted]) + shift
    return Descriptor.quantise(FloatNetwork(hidden, np.zeros(2), output, centre), g,
                               valid or ValidRows.everything(*g.corrected))


# The golden model compared with an independent implementation in floating point.

@pytest.mark.parametrize("bayer", BAYER_PHASE)
@pytest.mark.parametrize("levels", [2, 256])
def test_golden_is_within_one_grey_level_of_float(bayer, levels):
    d = barrel_descriptor((160, 120), (150, 130), hidden_neurons=5, bayer=bayer)
    raw = np.random.default_rng(3).integers(0, levels, (130, 150)) * (255 // (levels - 1))
    picture = correct(d, raw.astype(np.uint8))
    real = correct_real(d, raw.astype(np.uint8))
    np.testing.assert_array_equal(picture.blank, np.isnan(real).any(axis=2))
    assert grey_level_difference(picture.picture, real) <= 1
    assert 0.02 < picture.blank.mean() < 0.5


def test_first_and_last_row_and_column_are_right():
    """A corrected frame that lies inside the sensor to its very edge shows its edge samples."""
    g = Geometry(32, 24, 34, 26)       # every window is inside, the outermost at the edge
    d = linear_descriptor(g)
    raw = noise(d)
    result = correct(d, raw)
    assert not result.blank.any()
    windows = np.lib.stride_tricks.sliding_window_view(raw, (3, 3))
    # The corrected pixel (u, v) lies on the sample (u + 1, v + 1), the window's middle, but for
    # what the network is off. Interpolated grey levels rise by at most 255 per pixel on each axis,
    # and are rounded once.
    v, u = np.indices((24, 32))
    off = np.abs(d.formats.coordinate.real(frame_coordinates(d)) - (u + 1, v + 1)).max(axis=(1, 2))
    assert off.max() < 0.005
    tolerance = 255 * off.sum() + 0.5
    for u, v in ((0, 0), (31, 0), (0, 23), (31, 23), (16, 0), (16, 23), (0, 12), (31, 12)):
        w = windows[v, u].astype(int)
        middle, cross = w[1, 1], (w[0, 1] + w[1, 0] + w[1, 2] + w[2, 1]) / 4
        corners = (w[0, 0] + w[0, 2] + w[2, 0] + w[2, 2]) / 4
        sides = {0: (w[1, 0] + w[1, 2]) / 2, 1: (w[0, 1] + w[2, 1]) / 2}
        odd = ((u + 1) % 2, (v + 1) % 2)
        red, green, blue = {(0, 0): (middle, cross, corners), (1, 1): (corners, cross, middle),
                            (1, 0): (sides[0], (middle + corners) / 2, sides[1]),
                            (0, 1): (sides[1], (middle + corners) / 2, sides[0])}[odd]
        np.testing.assert_allclose(result.picture[v, u], [red, green, blue],
                                   rtol=0, atol=tolerance)


def test_windows_that_leave_the_image_are_filled():
    g = Geometry(40, 30, 40, 30, fill=(9, 8, 7))
    shift = (15.3, -11.2)
    everywhere = linear_descriptor(g, shift=shift)
    result = correct(everywhere, noise(everywhere))
    v, u = np.indices((30, 40))
    x, y = u + shift[0], v + shift[1]
    outside = (x < -0.5) | (x >= 39.5) | (y < -0.5) | (y >= 29.5)  # more than a pixel
    np.testing.assert_array_equal(result.blank, outside)
    assert (result.picture[outside] == [9, 8, 7]).all()
    by_truth = linear_descriptor(g, shift=shift, valid=ValidRows.of_mask(g.window_inside(x, y)))
    np.testing.assert_array_equal(correct(by_truth, noise(by_truth)).blank, ~g.window_inside(x, y))


def test_blanking_follows_the_true_map_not_the_network():
    """The rough network is pixels off at the edge; the map states what is blank all the same."""
    d = barrel_descriptor((64, 48), (64, 48), hidden_neurons=6, strength=0.4)
    v, u = np.indices((48, 64))
    truth = d.geometry.window_inside(*barrel_map(d.geometry, 0.4)(u, v))
    np.testing.assert_array_equal(d.valid.mask(64), truth)
    blank = correct(d, noise(d)).blank
    assert blank[~truth].all(), "a pixel without a source shows the extrapolation"


def test_half_pixel_is_compensated():
    rng = np.random.default_rng(5)
    d = barrel_descriptor((200, 150), (200, 150), hidden_neurons=6)
    colour = rng.integers(0, 256, (10, 13, 3)).astype(np.float64)
    colour = np.kron(colour, np.ones((15, 16, 1)))[:150, :200]
    ramp = np.linspace(0, 1, 200)[None, :, None]
    smooth = (colour * ramp + colour[::-1] * (1 - ramp)).astype(np.uint8)
    result = bayer_psnr(d, smooth)
    assert result["psnr_fast_db"] > result["psnr_uncompensated_db"] + 1
    assert result["psnr_fast_db"] > result["psnr_demosaic_db"] - 2


# The generated Verilog compared with the golden model.

@pytest.mark.parametrize("simulator,memory,hardware", [
    ("icarus", "hostile", Hardware(fetcher="multiport")),
    ("verilator", "hostile", Hardware(data_width=64, output="stream", fetcher="multiport")),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("icarus", "sdram", Hardware(data_width=64, output="stream", hidden="raster")),
        ("icarus", "ddr3", Hardware(data_width=128, share=2)),
        ("verilator", "hostile", Hardware(hidden="raster", share=2))))])
def test_verilog_equals_golden(simulator, memory, hardware):
    d = barrel_descriptor((37, 29), (45, 33), hidden_neurons=2, bayer="GBRG", fill=(200, 100, 50))
    result = simulate_correction(d, noise(d), hardware, memory=memory, simulator=simulator)
    assert result.differing == []
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == 37 * 29
    # The corrector's own count of clocks is the bench's, less the way of the register write.
    assert 0 < result.clocks_outside - result.counters["CLOCKS"] <= 6
    # The cache may keep up with so small a frame; the paper's fetcher never does.
    stalls = result.counters["FRONT_END_STALLS"]
    assert 0 <= stalls < result.counters["CLOCKS"] and (stalls or hardware.cached)
    assert result.blank.any() and not result.blank.all()
    assert result.bytes_written == 37 * 29 * (3 if hardware.stream else 4)


@pytest.mark.longer
@pytest.mark.parametrize("simulator", [
    "verilator", pytest.param("icarus", marks=pytest.mark.regress)])
def test_parameters_change_between_frames(simulator):
    """Made for one camera, programmed for another while its first frame runs: the first frame
    keeps the old parameters to its end, the second has all of the new ones."""
    one = barrel_descriptor((37, 29), (45, 33), hidden_neurons=2, bayer="GBRG", seed=1)
    two = barrel_descriptor((26, 31), (40, 20), hidden_neurons=2, bayer="RGGB", seed=8,
                            fill=(7, 7, 7))
    raw = [noise(one, 1), noise(two, 2)]
    rows = {r.name: r.address for r in registers(2, one.formats)}
    first = host_values(one)
    source, target = 8192, (16384, 32768)
    second = host_values(two, addresses=FrameAddresses(source, target[1], 40))
    program = Program().write(rows["IRQ_ENABLE"], 1)
    first |= address_values(one.geometry, 32, FrameAddresses(0, target[0], first["SOURCE_PITCH"]))
    for name, value in first.items():
        program.write(rows[name], value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    # While the first frame runs: all values of the second, its valid rows in the other bank.
    for name, value in (second | {"VALID_BANK": 1}).items():
        program.write(rows[name], value)
    program.write(rows["VALID_WINDOW"], 1)
    for address, value in table_words(two.valid):
        program.write(address, value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    program.wait_irq().write(rows["STATUS"], 2).wait_irq().read(rows["FRAMES"])
    content = raw_image(raw[0], first["SOURCE_PITCH"]).ljust(source, b"\0")
    content += raw_image(raw[1], second["SOURCE_PITCH"])
    span = target[1] - target[0]
    result = simulate_frame(corrector_verilog(one), content, program, source_base=0,
                            output_base=target[0], output_bytes=span + frame_bytes(two.geometry),
                            memory="sdram", simulator=simulator)
    assert result.registers[rows["FRAMES"]] == 2
    for d, picture, start in ((one, raw[0], 0), (two, raw[1], span)):
        width, height = d.geometry.corrected
        stored = np.frombuffer(result.output, np.uint8, 4 * width * height, start)
        np.testing.assert_array_equal(stored_picture(stored.reshape(height, width, 4)),
                                      correct(d, picture).picture)


def test_a_colour_swap_would_be_seen():
    """Red, green and blue of a flat coloured scene arrive as they were, in every phase."""
    for bayer in BAYER_PHASE:
        g = Geometry(16, 12, 20, 16, bayer=bayer)
        raw = mosaic(np.broadcast_to(np.array([200, 90, 20], np.uint8), (16, 20, 3)), bayer)
        assert (correct(linear_descriptor(g), raw).picture == [200, 90, 20]).all(), bayer


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("corrected,distorted,data_width,output", [
    ((1280, 1024), (1280, 1024), 32, "memory"), ((1920, 1080), (1920, 1080), 128, "stream")])
def test_full_size_frames(corrected, distorted, data_width, output):
    d = barrel_descriptor(corrected, distorted, hidden_neurons=4, strength=0.4)
    result = simulate_correction(d, noise(d), Hardware(data_width=data_width, output=output),
                                 memory="sdram")
    assert result.differing == []
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.blank.any()
