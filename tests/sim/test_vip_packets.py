"""Whole frames in Intel's video packets, taken apart by a sink that knows their rules."""

import random

import numpy as np
import pytest
from amaranth.sim import Simulator

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.ip.platform_designer import hw_tcl
from ncdc_hdl.export.verilog.cover import verilog_of
from ncdc_hdl.video import vip_packets
from ncdc_hdl.video.vip_packets import VipPackets
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.tools import SIMULATORS, SimulationError
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from simulations.vip import unpacked

SIZE, RAW = (40, 32), (48, 40)
HARDWARE = Hardware(output="stream", video="vip", cache=CacheOptions(64, pending=64,
                                                                    outstanding=8))


def run(**options):
    d = barrel_descriptor(SIZE, RAW, hidden_neurons=2)
    raw = np.random.default_rng(1).integers(0, 256, RAW[::-1], np.uint8)
    return simulate_correction(d, raw, HARDWARE,
                               verilog=unpacked(verilog_of(Corrector(d, HARDWARE))), **options)


@pytest.mark.regress
@pytest.mark.parametrize("sink_probability", [256, 100])
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_every_pixel(simulator, sink_probability):
    result = run(memory="hostile", sink_probability=sink_probability, simulator=simulator)
    assert result.differing == []


class Early(VipPackets):
    """Takes ``ready`` for this clock, as today's plain stream does."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += self.o.valid.eq(self.i.valid)
        return m


@pytest.mark.regress
@pytest.mark.parametrize("rule", ["latency", "control", "type"])
def test_a_planted_error_is_found(rule, monkeypatch):
    if rule == "latency":
        monkeypatch.setattr("ncdc_hdl.corrector.VipPackets", Early)
    else:
        name, value = {"control": ("_PROGRESSIVE", 2), "type": ("_PICTURE", 3)}[rule]
        monkeypatch.setattr(vip_packets, name, value)
    with pytest.raises(SimulationError, match=f"vip {rule}"):
        run(memory="ideal", simulator="icarus")


def sent(dut, frames, size, gap=0.0, stall=0.0):
    """Beats (data, first, last) of ``frames``, lists of pixels, as a sink takes them.

    One that comes without ``ready`` in the clock before raises.
    """
    rng, beats = random.Random(1), []
    pixels = [(pixel, k == 0, k == len(frame) - 1) for frame in frames
              for k, pixel in enumerate(frame)]

    async def bench(ctx):
        ctx.set(dut.width, size[0])
        ctx.set(dut.height, size[1])
        allowed, valid = False, False
        while pixels:
            ready, valid = rng.random() >= stall, valid or rng.random() >= gap
            pixel, first, last = pixels[0]
            ctx.set(dut.o.ready, ready)
            ctx.set(dut.i.valid, valid)
            ctx.set(dut.i.p, {"data": pixel, "first": first, "last": last})
            if ctx.get(dut.o.valid):
                assert allowed, "a beat came without ready"
                beats.append((ctx.get(dut.o.data), ctx.get(dut.o.startofpacket),
                              ctx.get(dut.o.endofpacket)))
            if valid and ctx.get(dut.i.ready):
                pixels.pop(0)
                valid = False
            await ctx.tick()
            allowed = ready

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return beats


HEADER = [(0x00000F, 1, 0), (0x080200, 0, 0), (0x010000, 0, 0), (0x03000E, 0, 1),
          (0x000000, 1, 0)]
"""Before a frame of 640x480, 0x0280 by 0x01E0: four bits a symbol, the upper bits first, the first
symbol lowest; progressive; then the type of the pixels."""


@pytest.mark.parametrize("gap,stall", [(0, 0), (.4, 0), (0, .4), (.4, .6)])
def test_the_packets_of_the_manual(gap, stall):
    frames = [[0x111111, 0xABCDEF, 0x333333], [0x00000F], list(range(200))]
    ends = [[(pixel, 0, int(k == len(frame) - 1)) for k, pixel in enumerate(frame)]
            for frame in frames]
    assert sent(VipPackets(), frames, (640, 480), gap, stall) == sum(
        (HEADER + pixels for pixels in ends), [])


def test_a_source_without_ready_latency_is_found():
    with pytest.raises(AssertionError, match="without ready"):
        sent(Early(), [[1, 2, 3]], (640, 480), stall=.5)


def test_platform_designer_knows_the_ready_latency():
    d = barrel_descriptor(SIZE, RAW, hidden_neurons=2)
    assert "set_interface_property stream readyLatency 1" in hw_tcl(Corrector(d, HARDWARE))


@pytest.mark.parametrize("choices,text", [
    ({"output": "memory"}, "the output is memory, the video vip needs stream"),
    ({"output": "stream", "bus": "axi"}, "the bus is axi, the video vip needs avalon"),
    ({"output": "stream", "lanes": 2}, "pixels per clock is 2, the video vip needs 1")])
def test_where_there_are_no_such_packets(choices, text):
    with pytest.raises(InputError, match=text):
        Hardware(video="vip", **choices)
