"""White balance before interpolation: whole frames of the generated Verilog equal the golden model.

Raw frames that are balanced as they are read, and a camera whose samples are as they are captured.
"""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_model.golden.colour import ColourSums
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.tone import tone_named
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.colour import Colour
from ncdc_spec.frames import frame_bytes, raw_image, stored_picture
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST
from ncdc_spec.raw_gains import NO_RAW_GAINS, frame_gains
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    CTRL_START,
    RAW_GAINS,
    STATUS_DONE,
    registers,
)
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.level import levelled
from ncdc_spec.sensors.sensor import Settings

pytestmark = pytest.mark.longer

GAINS = (461, 200, 358)
BALANCED = Hardware(raw_balance=True)
regress = pytest.mark.regress


def camera(bayer="GBRG", interpolation=FAST):
    return barrel_descriptor((48, 40), (72, 49), bayer=bayer, interpolation=interpolation)


def noise(d):
    return np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


@pytest.mark.parametrize("camera_of,settings,memory,options", [
    (("GBRG", FAST), dict(colour=True), "sdram", {}),
    *(pytest.param(*case, marks=regress) for case in (
        (("RGGB", DIRECTIONAL), dict(colour=True, lanes=4, data_width=128, strip=32), "ddr3", {}),
        (("GRBG", DIRECTIONAL), dict(output="stream", data_width=64), "hostile",
         {"sink_probability": 150}),
        (("BGGR", FAST), dict(lanes=2), "hostile", {}),
        (("MONO", DIRECTIONAL), dict(data_width=64), "sdram", {}),
        (("RGGB", DIRECTIONAL), dict(colour=True), "sdram", {"follow_line": 200})))])
def test_verilog_equals_golden(camera_of, settings, memory, options):
    d = camera(*camera_of)
    colour = Colour(raw_gains=GAINS)
    if settings.get("colour"):
        colour = Colour((300, 256, 280), tone_named("sRGB"), raw_gains=GAINS)
    result = simulate_correction(d, noise(d), Hardware(raw_balance=True, **settings),
                                 colour=colour, memory=memory, **options)
    plain = correct(d, noise(d))
    assert result.differing == [] and result.sums == result.sums_expected
    assert (result.picture != plain.picture).mean() > .5
    if settings.get("colour"):      # the sums are of balanced samples
        assert result.sums != ColourSums.of(plain).registers


def test_a_planted_error_is_found():
    d = camera()
    verilog, right = corrector_verilog(d, BALANCED), "byte3_p1[7]"
    assert verilog.count(right) == 1
    result = simulate_correction(d, noise(d), BALANCED, colour=Colour(raw_gains=GAINS),
                                 verilog=verilog.replace(right, "byte3_p1[6]"))
    assert result.differing


def test_a_host_balances_the_next_frame_while_one_runs():
    """The frame that runs keeps its gains, and DIGEST still identifies the lens."""
    d, raw = camera(), noise(camera())
    rows = {r.name: r.address for r in registers(d.hidden_neurons, d.formats, raw_balance=True)}
    host, size = host_values(d, BALANCED), frame_bytes(d.geometry)
    first, second = host["TARGET_BASE"], host["TARGET_BASE"] + size
    program = Program().write(rows["IRQ_ENABLE"], 1).write(rows["CTRL"], CTRL_START)
    for name, value in (dict(zip(RAW_GAINS, GAINS)) | {
            "TARGET_BASE": second, "TARGET_LIMIT": second + size}).items():
        program.write(rows[name], value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START).wait_irq()
    program.write(rows["STATUS"], STATUS_DONE).wait_irq().compare(rows["ALTERED"], 0)
    result = simulate_frame(corrector_verilog(d, BALANCED), raw_image(raw, host["SOURCE_PITCH"]),
                            program, source_base=host["SOURCE_BASE"], output_base=first,
                            output_bytes=2 * size, memory="sdram")
    pictures = np.frombuffer(result.output, np.uint8).reshape(2, 40, 48, 4)
    for picture, gains in zip(pictures, (NO_RAW_GAINS, GAINS)):
        np.testing.assert_array_equal(stored_picture(picture),
                                      correct(d, raw, raw_gains=gains).picture)


SIZE = 64, 24


@pytest.fixture(scope="module")
def system():
    return System(barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4, bayer="GRBG"),
                  Hardware(data_width=64))


@pytest.fixture(scope="module")
def verilog(system):
    return system_verilog(system)


def asked(name="mt9p031"):
    sensor = sensor_named(name)
    return setup(sensor, Settings(width=SIZE[0], height=SIZE[1], exposure_us=100,
                                  clock_hz=sensor.pixel_clock_hz))


def still():
    """The same random frame again and again."""
    return Light(np.random.default_rng(1).integers(0, 4096, (1, *SIZE[::-1]), dtype=np.uint16))


def test_a_camera_balances_its_samples(system, verilog):
    """With 12 bits: no level of a byte is lost, and the frames are those of the golden model."""
    run = simulate_camera(system, asked(), still(), count=1, verilog=verilog, gains=GAINS)
    assert [frame.different for frame in run.frames] == [0]


def test_a_camera_changes_its_gains_from_frame_to_frame(system, verilog):
    """While it runs: each frame has the gains of one set or the other, none of both."""
    new, d, asked_for = (300, 700, 256), system.descriptor, asked()
    run = simulate_camera(
        system, asked_for, still(), count=4, verilog=verilog, gains=GAINS,
        disturb=lambda host: setattr(host.camera, "gains", new))
    raw = raw_frames(asked_for, still())[0]
    golden = [correct(d, levelled(raw, asked_for.sensor.black, gains=frame_gains(
        d.geometry, gains))).picture for gains in (GAINS, new)]
    found = [[np.array_equal(frame.picture, picture) for picture in golden].index(True)
             for frame in run.frames]
    assert found == sorted(found) and found[0] == 0 and found[-1] == 1
