"""LiteDRAM's controller as the memory: words of the copier, frames of the corrector."""

import importlib.metadata

import numpy as np
import pytest

from cameras import barrel_descriptor
from copier import copier
from ncdc_sim.memory.timing import simulated_memory
from ncdc_sim.system import frame
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware

WORDS, SOURCE, OUTPUT = 512, 0x2000, 0x10000


def copy(memory, width=32, words=WORDS, **options):
    """The copier's output, its clocks, and what it should have written."""
    source = np.random.default_rng(1).integers(0, 256, words * width // 8, np.uint8)
    program = (Program().write(0, SOURCE).write(1, OUTPUT).write(2, words).write(3, 1).wait_irq())
    result = simulate_frame(copier(width), source.tobytes(), program, source_base=SOURCE,
                            output_base=OUTPUT, output_bytes=len(source), memory=memory, **options)
    return np.frombuffer(result.output, np.uint8), result.clocks[0], ~source


@pytest.mark.longer
def test_copies():
    output, clocks, expected = copy("litedram")
    np.testing.assert_array_equal(output, expected)
    # Each burst of 8 is asked for, read, written; the controller answers within 8 to 40 clocks.
    assert 8 + 16 < clocks / (WORDS / 8) < 40 + 16


@pytest.mark.regress
@pytest.mark.parametrize("memory,width", [("litedram", 64), ("litedram", 128),
                                          ("litedram-ddr3", 128)])
def test_copies_other_widths(memory, width):
    output, _, expected = copy(memory, width)
    np.testing.assert_array_equal(output, expected)


@pytest.mark.parametrize("old,new", [
    ("write_word <= write_word + 1;", ""),
    ("{enable[LANES*sent +: LANES],", "{{LANES{1'b0}},"),
    ("read_word[p] <= read_word[p] + 1;", "")])
@pytest.mark.regress
def test_a_broken_bridge_is_seen(old, new, tmp_path, monkeypatch):
    for path in frame.HDL.iterdir():
        (tmp_path / path.name).write_text(path.read_text())
    text = (tmp_path / "litedram_memory.v").read_text()
    assert old in text
    (tmp_path / "litedram_memory.v").write_text(text.replace(old, new))
    monkeypatch.setattr(frame, "HDL", tmp_path)
    output, _, expected = copy("litedram")
    assert (output != expected).any()


@pytest.mark.regress
@pytest.mark.parametrize("fetcher", ["cache", "multiport"])
@pytest.mark.parametrize("memory,width,output", [("litedram", 32, "memory"),
                                                 ("litedram", 32, "stream"),
                                                 ("litedram-ddr3", 128, "memory")])
def test_frames(memory, width, output, fetcher):
    d = barrel_descriptor((160, 120), (160, 120))
    raw = np.random.default_rng(1).integers(0, 256, (120, 160), np.uint8)
    result = simulate_correction(
        d, raw, Hardware(data_width=width, output=output, fetcher=fetcher), memory=memory)
    assert not result.differing


@pytest.mark.parametrize("memory,width,simulator,message", [
    ("litedram", 32, "icarus", "ports of 32 bits and 128 MB needs the simulator verilator .* "
                               "asked for are icarus, 32 bits and 0 MB"),
    ("litedram-ddr3", 32, "verilator", "ports of 128 bits .* asked for are verilator, 32 bits")])
def test_what_it_cannot_do(memory, width, simulator, message):
    with pytest.raises(InputError, match=message):
        copy(memory, width, simulator=simulator)


def test_not_installed(monkeypatch):
    def missing(name):
        raise importlib.metadata.PackageNotFoundError(name)
    monkeypatch.setattr(importlib.metadata, "version", missing)
    with pytest.raises(InputError, match=r'litedram is not installed, .* pip install "ncdc\[lite'):
        copy("litedram")


def test_names():
    assert simulated_memory("litedram").bytes == 128 << 20
    assert simulated_memory("litedram-ddr3").bytes == 256 << 20
    with pytest.raises(InputError, match="one of .* hostile, litedram, litedram-ddr3, sdram@MHZ"):
        simulated_memory("liteddr")
