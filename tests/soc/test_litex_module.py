"""The corrector as a LiteX user has it: in a system with LiteDRAM, driven over the bus."""

import re
from pathlib import Path

import numpy as np
import pytest
from litex.build.sim import SimPlatform

from cameras import barrel_descriptor
from ncdc_sim.system.litex import simulate_module
from ncdc_soc import module_soc
from ncdc_soc.module import NCDC
from ncdc_soc.module_soc import ModuleSoc, module_soc_verilog
from ncdc_soc.verilog import litex_verilog
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from peers import need

STREAM = Hardware(output="stream")
MEMORY = Hardware(format="BGR8")


def camera(width, height):
    """A descriptor, and a raw frame of noise for it."""
    size = width, height
    noise = np.random.default_rng(7).integers(0, 256, size[::-1], np.uint8)
    return barrel_descriptor(size, size, hidden_neurons=2), noise


def check(run, frames, pixels):
    """Every pixel is the golden model's, and the event comes with each frame and goes."""
    assert (run.pixels, run.different, run.errors) == (frames * pixels, 0, ())
    assert run.pending == (1, 0) * frames
    assert len(run.interrupts) == frames and min(run.interrupts) > pixels


@pytest.mark.longer
def test_frames_in_litedram_are_corrected_to_memory():
    check(simulate_module(*camera(32, 24), MEMORY, frames=2), 2, 32 * 24)


@pytest.mark.many_clocks
@pytest.mark.regress
def test_a_system_that_is_reset_in_the_midst_of_frames_corrects_the_next():
    cut = range(100, 3000, 61)
    check(simulate_module(*camera(48, 40), MEMORY, cut=cut), 1, 48 * 40)


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("sink", (256, 60))
def test_frames_leave_as_litex_s_video_whatever_the_sink_does(sink):
    run = simulate_module(*camera(64, 48), STREAM, frames=3, sink=sink)
    check(run, 3, 64 * 48)
    assert run.ends == tuple((k * 64 * 48, (k + 1) * 64 * 48 - 1) for k in range(3))
    assert (run.clocks[0] > 4 * 64 * 48) == (sink == 60)


@pytest.mark.longer
def test_litex_s_dma_takes_the_video():
    check(simulate_module(*camera(64, 48), STREAM, frames=2, sink=None), 2, 64 * 48)


@pytest.mark.many_clocks
@pytest.mark.regress
def test_a_processor_that_copies_memory_costs_clocks_and_no_pixel():
    need("riscv64-unknown-elf-gcc")
    runs = {cpu: simulate_module(*camera(128, 96), MEMORY, cpu, frames=2)
            for cpu in ("idle", "polls", "copies")}
    for run in runs.values():
        check(run, 2, 128 * 96)
    assert runs["copies"].clocks[0] > runs["idle"].clocks[0]


class Two(ModuleSoc):
    """A system with another corrector, of a camera and a name of its own."""

    def __init__(self, other, name, *args):
        super().__init__(*args)
        platform, folder = args[0], args[4]
        self.second = NCDC(platform, other, self.sdram.crossbar, name=name, folder=folder)
        self.bus.add_slave("second", self.second.bus, self.second.region(0x9800_0000))


def two(folder, name):
    """Verilog of a system with two correctors, and of these, by the names of their files."""
    cameras = [camera(32, 24)[0], camera(48, 40)[0]]
    platform = SimPlatform("SIM", module_soc._PINS)
    _, text = litex_verilog(platform, lambda: Two(cameras[1], name, platform, cameras[0], None,
                                                  None, folder), "top")
    return text, {Path(path).name: Path(path).read_text() for path, *_ in platform.sources}


@pytest.mark.longer
@pytest.mark.parametrize("name,second", [
    pytest.param(None, "ncdc1", marks=pytest.mark.regress), ("right", "right")])
def test_two_correctors_are_two_modules(tmp_path, name, second):
    text, files = two(tmp_path, name)
    assert list(files) == ["ncdc.v", f"{second}.v"]
    assert [re.search(rf"^{module} \w+ ?\(", text, re.M) is not None
            for module in ("ncdc", second)] == [True, True]
    found = [set(re.findall(r"^module (\\\S+|\w+)", verilog, re.M)) for verilog in files.values()]
    assert {"ncdc"} < found[0] and {second} < found[1] and not found[0] & found[1]
    # The first one is still that of the first camera.
    module_soc_verilog(camera(32, 24)[0], None, None, tmp_path / "alone")
    assert files["ncdc.v"] == (tmp_path / "alone" / "ncdc.v").read_text()


@pytest.mark.longer
@pytest.mark.parametrize("name,message", [
    ("ncdc", "the name is 'ncdc', which another Verilog module of the system has"),
    ("a b", "the name is 'a b', a letter is needed")])
def test_a_name_that_is_taken_or_none_is_rejected(tmp_path, name, message):
    with pytest.raises(InputError, match=message):
        two(tmp_path, name)
    assert [path.name for path in tmp_path.iterdir()] == ["ncdc.v"]


@pytest.mark.parametrize("hardware,message", [
    (Hardware(data_width=64), "data width is 64, LiteDRAM's controller has 32"),
    (Hardware(output="stream", lanes=2), "pixels per clock is 2, LiteX's video has 1"),
    (Hardware(output="stream", video="vip"), "the video vip needs avalon")])
def test_hardware_that_does_not_fit_is_rejected(hardware, message, tmp_path):
    with pytest.raises(InputError, match=message):
        module_soc_verilog(camera(32, 24)[0], hardware, None, tmp_path)
    assert not list(tmp_path.iterdir())
