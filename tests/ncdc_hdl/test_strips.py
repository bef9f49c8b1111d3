"""Whole frames of Verilog in strips, in groups of pixels, aborted, and reset in the middle."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.correction import correct
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.errors import InputError
from ncdc_spec.frames import frame_bytes, raw_image, stored_picture
from ncdc_spec.geometry import scan_order
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL, FAST
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_ABORT,
    CTRL_COMMIT,
    CTRL_START,
    STATUS_ABORTED,
    STATUS_DONE,
    registers,
)

FILL = (200, 100, 50)
# Fetcher, data width, hidden neurons, interpolation: each is compiled once for all tests.
BUILDS = [("cache", 64, "raster", FAST), ("multiport", 128, "multiply", FAST),
          ("cache", 64, "raster", DIRECTIONAL)]


def each_build(short):
    """Parametrises a test by all builds, of which the first ``short`` ones take little time."""
    return pytest.mark.parametrize("fetcher,data_width,hidden,needs", [
        *BUILDS[:short],
        *(pytest.param(*each, marks=pytest.mark.longer) for each in BUILDS[short:])],
        ids=lambda each: getattr(each, "name", None))


def camera(width=77, needs=FAST):
    """A corrected width that is a multiple neither of a strip nor of a memory word."""
    return barrel_descriptor((width, 29), (85, 33), hidden_neurons=2, bayer="GBRG", fill=FILL,
                             interpolation=needs)


def noise(d, seed=1):
    return np.random.default_rng(seed).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


def build(d, fetcher, data_width, hidden):
    return corrector_verilog(d, Hardware(data_width=data_width, fetcher=fetcher, hidden=hidden))


@pytest.mark.longer
@each_build(short=2)
@pytest.mark.parametrize("strip,memory", [(32, "hostile"), (64, "sdram"), (96, "hostile")])
def test_strips_equal_golden(fetcher, data_width, hidden, needs, strip, memory):
    d = camera(needs=needs)
    hardware = Hardware(data_width=data_width, fetcher=fetcher, hidden=hidden, strip=strip)
    result = simulate_correction(d, noise(d), hardware, memory=memory,
                                 verilog=build(d, fetcher, data_width, hidden))
    assert result.differing == []
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == 77 * 29
    # Every byte once: what two strips share of a word is enabled in one of its two writes.
    assert result.bytes_written == 4 * 77 * 29
    assert result.blank.any() and not result.blank.all()


class Frames:
    """Frames of ``d`` to buffers of their own, one after the other, in a program for the bench.

    If the interpolation has a crest, all frames have a mild one.
    """

    def __init__(self, d, data_width):
        self.d, self.data_width = d, data_width
        self.rows = {r.name: r.address for r in registers(d.hidden_neurons, d.formats)}
        self.values = host_values(d, Hardware(data_width=data_width))
        self.raw, self.program = noise(d), Program()
        self.base = self.values["TARGET_BASE"]
        self.size = -(-frame_bytes(d.geometry) // 4096) * 4096
        self.count = 0
        self.crest = CRESTS["mild"] * (d.geometry.interpolation == DIRECTIONAL)

    @property
    def golden(self):
        """The picture of the golden model."""
        return correct(self.d, self.raw, crest=self.crest).picture

    def start(self, strip=0, control=CTRL_COMMIT | CTRL_START, **values):
        """Write what differs from the values after configuration, commit, start."""
        target = self.base + self.count * self.size
        changed = {"STRIP_WIDTH": strip, "TARGET_BASE": target, "TARGET_LIMIT": target + self.size,
                   "CORRECTED_WIDTH": self.values["CORRECTED_WIDTH"]} | values
        if self.crest:
            changed["CREST"] = self.crest
        for name, value in changed.items():
            self.program.write(self.rows[name], value)
        self.program.write(self.rows["IRQ_ENABLE"], 1).write(self.rows["CTRL"], control)
        self.count += 1

    def end(self):
        """Wait, and read what became of the frame."""
        self.program.wait_irq().read(self.rows["STATUS"]).read(self.rows["PIXELS"])
        self.program.write(self.rows["STATUS"], STATUS_DONE)

    def run(self, verilog, **options):
        """Pixels of all frames, (frames, height, width, 4); flags ABORTED; numbers of pixels."""
        result = simulate_frame(
            verilog, raw_image(self.raw, self.values["SOURCE_PITCH"]), self.program, source_base=0,
            output_base=self.base, output_bytes=self.count * self.size, **options)
        width, height = self.d.geometry.corrected
        stored = np.frombuffer(result.output, np.uint8).reshape(self.count, self.size)
        pixels = stored[:, :4 * width * height].reshape(self.count, height, width, 4)
        assert (stored[:, 4 * width * height:] == 0xA5).all(), "written beyond a frame"
        flags = [bool(value & STATUS_ABORTED) for address, value in result.reads
                 if address == self.rows["STATUS"]]
        counts = [value for address, value in result.reads if address == self.rows["PIXELS"]]
        return pixels, flags, counts


def check_whole(pixels, golden):
    np.testing.assert_array_equal(stored_picture(pixels), golden)
    assert not pixels[..., 3].any()


def check_begun(pixels, golden, strip, written=None):
    """The first ``written`` pixels are right but for the last, which is blank; the others are
    untouched. Without a count: each pixel is right or untouched."""
    pixels, golden = scan_order(pixels, strip), scan_order(golden, strip)
    if written is not None:
        np.testing.assert_array_equal(stored_picture(pixels[:written - 1]), golden[:written - 1])
        assert pixels[written - 1].tolist() == [*FILL[::-1], 0]
        assert (pixels[written:] == 0xA5).all()
    else:
        right = (stored_picture(pixels) == golden).all(axis=1) & (pixels[:, 3] == 0)
        assert (right | (pixels == 0xA5).all(axis=1)).all()


@each_build(short=1)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_abort_at_any_moment(fetcher, data_width, hidden, needs, seed):
    """Each aborted frame is followed by a whole one; all of them with random strips."""
    d, rng = camera(needs=needs), np.random.default_rng(seed)
    frames, kinds = Frames(d, data_width), []
    for moment in (0, 1, *rng.integers(2, 4000, 12)):
        kinds.append(int(rng.choice([0, 32, 64])))
        frames.start(kinds[-1])
        frames.program.wait(int(moment)).write(frames.rows["CTRL"], CTRL_ABORT)
        frames.end()
        kinds.append(int(rng.choice([0, 32, 64])))
        frames.start(kinds[-1])
        frames.end()
    pixels, aborted, counts = frames.run(build(d, fetcher, data_width, hidden), memory="hostile",
                                         seed=seed)
    golden = frames.golden
    for k, (strip, frame) in enumerate(zip(kinds, pixels)):
        if aborted[k]:
            check_begun(frame, golden, strip, counts[k])
        else:
            check_whole(frame, golden)
    assert not any(aborted[1::2]) and sum(aborted) > 8
    assert len(set(counts[::2])) > 8, "the aborts came at the same moment"


@each_build(short=2)
def test_abort_and_start_together_and_frames_without_a_pixel(fetcher, data_width, hidden, needs):
    """A frame aborted by the start of the next, then one of no width, then a whole one."""
    d = camera(needs=needs)
    frames = Frames(d, data_width)
    frames.start()
    frames.program.wait(600)
    frames.start(32, control=CTRL_COMMIT | CTRL_START | CTRL_ABORT)
    frames.end()
    frames.end()
    frames.start(64, CORRECTED_WIDTH=0)
    frames.end()
    # Without a frame that runs an abort does nothing, and not to the next one either.
    frames.program.write(frames.rows["CTRL"], CTRL_ABORT)
    frames.start(64)
    frames.end()
    pixels, aborted, counts = frames.run(build(d, fetcher, data_width, hidden), memory="sdram")
    golden = frames.golden
    assert aborted == [True, False, True, False]
    check_begun(pixels[0], golden, 0, counts[0])
    check_whole(pixels[1], golden)
    assert (pixels[2] == 0xA5).all() and counts[2] == 1
    check_whole(pixels[3], golden)


@each_build(short=1)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_reset_at_any_moment(fetcher, data_width, hidden, needs, seed):
    """The memory is not reset: it gets whole bursts, and no old word is taken for a new one."""
    d, rng = camera(needs=needs), np.random.default_rng(seed)
    frames, kinds = Frames(d, data_width), []
    for moment in rng.integers(2, 3000, 12):
        kinds.append(int(rng.choice([0, 32, 64])))
        frames.start(kinds[-1])
        frames.program.wait(int(moment)).reset(int(rng.integers(1, 4)))
        kinds.append(int(rng.choice([0, 32, 64])))
        frames.start(kinds[-1])
        frames.end()
    pixels, aborted, _ = frames.run(build(d, fetcher, data_width, hidden), memory="hostile",
                                    seed=seed)
    golden = frames.golden
    for strip, frame in zip(kinds[::2], pixels[::2]):
        check_begun(frame, golden, strip)
    for frame in pixels[1::2]:
        check_whole(frame, golden)
    assert not any(aborted) and (pixels[::2] == 0xA5).all(axis=-1).any(axis=(1, 2)).sum() > 8


@pytest.mark.parametrize("lanes,data_width,output,hidden,share,strip,memory", [
    pytest.param(2, 128, "stream", "multiply", 1, 0, "ddr3", marks=pytest.mark.regress),
    pytest.param(2, 64, "memory", "multiply", 1, 32, "hostile", marks=pytest.mark.regress),
    pytest.param(2, 32, "memory", "raster", 2, 0, "sdram", marks=pytest.mark.regress),
    pytest.param(4, 128, "memory", "raster", 1, 64, "hostile", marks=pytest.mark.regress),
    pytest.param(4, 64, "stream", "multiply", 1, 0, "hostile", marks=pytest.mark.regress)])
def test_groups_equal_golden(lanes, data_width, output, hidden, share, strip, memory):
    d = camera(76)
    hardware = Hardware(data_width=data_width, output=output, strip=strip, hidden=hidden,
                        share=share, lanes=lanes)
    result = simulate_correction(d, noise(d), hardware, memory=memory)
    assert result.differing == []
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == 76 * 29
    assert result.bytes_written == 76 * 29 * (3 if output == "stream" else 4)
    assert result.report()["pixels_per_clock"] == lanes


@pytest.mark.parametrize("options,message", [
    ({"strip": 32, "output": "stream"}, "the strip width is 32, a video stream needs 0 .raster."),
    ({"lanes": 2}, "the corrected width is 77, 2 pixels per clock need a multiple of 2"),
    ({"lanes": 2, "fetcher": "multiport"},
     "pixels per clock is 2, the multiport fetcher can have 1 only"),
    ({"lanes": 4, "tile_memory": "shared"},
     "tile memory is shared, with 4 pixels per clock and data of 32 bits; it needs 1 pixel and"),
    ({"data_width": 64, "tile_memory": "shared"}, "tile memory is shared, .* data of 64 bits"),
    ({"fetcher": "multiport", "tile_memory": "luts"},
     "fetch is multiport, tile memory luts needs cache"),
    ({"tile_memory": "luts, blocks"}, "the tile memory is .*, one of blocks, luts, shared is"),
    ({"format": "Mono8"}, "the format is Mono8, which needs a grey sensor, the camera's colour "
     "filter is GBRG"),
    ({"format": "BGR8", "output": "stream"}, "the format is BGR8, a video stream has none"),
    ({"format": "BGRa8"}, "the format is 'BGRa8', one of BGRX8, BGR8, Mono8 is needed")])
def test_choices_that_do_not_fit(options, message):
    with pytest.raises(InputError, match=message):
        Corrector(camera(), Hardware(**options))


def test_pixels_per_clock_that_there_are_not():
    with pytest.raises(InputError, match="pixels per clock is 3, one of 1, 2, 4 is needed"):
        Hardware(lanes=3)


def test_a_host_reads_that_colours_would_be_lost():
    with pytest.raises(InputError, match="the format is Mono8, which needs a grey sensor"):
        host_values(camera(), Hardware(format="Mono8"))


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("lanes,strip", [(1, 128), (2, 128), (4, 256)])
def test_full_size_frames(lanes, strip):
    d = barrel_descriptor((1920, 1080), (1920, 1080), hidden_neurons=4, strength=0.4)
    result = simulate_correction(d, noise(d), Hardware(data_width=128, strip=strip, lanes=lanes),
                                 memory="ddr3")
    assert result.differing == []
    assert result.blank.any()
