"""Frames of 1920x1080 at the ports from the FPGA to a Cyclone V's hard memory controller."""

from dataclasses import replace

import pytest

from cameras import barrel_descriptor
from ncdc_bench.throughput import measure as bench
from ncdc_bench.throughput.lenses import Lens
from ncdc_bench.throughput.measure import Run, measure
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.ip.platform_designer import interfaces
from ncdc_model.planner.memory_timing import MEMORIES
from ncdc_spec.hardware import FETCHERS, OUTPUTS, Hardware

FHD = Lens(120, (1920, 1080))
PAPER = 8.21            # frames per second of the paper's board, at this size


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("output", OUTPUTS)
def test_a_pixel_per_clock(output):
    [row] = measure([Run("cache", FHD, "hps", output)])
    print(f"hps {output}: {row['clocks_per_pixel']:.5f} clocks per pixel, "
          f"{row['frames_per_second']:.2f} frames/s, {row['pixels_different']} differ")
    assert row["pixels_different"] == 0
    assert row["clocks_per_pixel"] <= 1.02
    assert row["frames_per_second"] > 5 * PAPER


@pytest.mark.regress
@pytest.mark.parametrize("clocks,pending", [(60, 8), (24, 4)])
def test_what_is_not_published(clocks, pending, monkeypatch):
    """More than twice the latency that is taken, or half the commands: slower, and right."""
    worse = replace(MEMORIES["hps"], controller_clocks=clocks, max_pending=pending)
    monkeypatch.setattr(bench, "simulate_correction", _with(bench.simulate_correction, worse))
    [row] = measure([Run("cache", FHD, "hps", "stream")])
    print(f"hps, {clocks} clocks, {pending} commands: {row['clocks_per_pixel']:.5f}")
    assert row["pixels_different"] == 0 and row["frames_per_second"] > 5 * PAPER


def _with(simulate, memory):
    return lambda *args, **named: simulate(*args, **named | {"memory": memory})


@pytest.mark.parametrize("fetcher", FETCHERS)
@pytest.mark.parametrize("output", OUTPUTS)
def test_the_ports_take_what_is_sent(output, fetcher):
    """32 to 256 bits; six command ports, four of 64 bits for data in each direction; bursts of at
    most a power of two up to 1024 words (Cyclone V HPS manual, 12.4.4, 12.12.1.1)."""
    corrector = Corrector(barrel_descriptor(), Hardware(data_width=64, output=output,
                                                        fetcher=fetcher))
    hosts = {name: ports for name, (kind, direction, ports) in interfaces(corrector).items()
             if kind == "avalon" and direction == "start"}
    reads = [name for name in hosts if name.startswith("read")]
    assert len(hosts) <= 6 and len(reads) <= 4 and len(hosts) - len(reads) <= 4
    for ports in hosts.values():
        roles = {role: width for role, width in ports.values()}
        assert roles.get("readdata", roles.get("writedata")) == 64
        # A burst of as many as the port's top bit says, a power of two, is the longest one.
        assert 1 <= roles["burstcount"] <= 11
