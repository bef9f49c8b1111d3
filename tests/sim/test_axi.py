"""Whole frames through AXI: pixels, rules of the buses, clocks beside Avalon's, resets."""

from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.axi import read_bridge, write_bridge
from ncdc_hdl.axi.top import AxiTop
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.axi_cover import axi_verilog
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.hardware import Hardware
from ncdc_model.interface.register_map import FAULT_MEMORY, registers
from ncdc_sim.system.axi import adapted
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.resets import simulate_resets
from ncdc_sim.tools import SimulationError

SIZE, RAW = (32, 16), (40, 20)
CACHE = CacheOptions(64, pending=64, outstanding=8)
BUILDS = {
    "memory": Hardware(cache=CACHE),
    "stream, four pixels": Hardware(cache=CACHE, data_width=128, output="stream", lanes=4),
    "memory, two pixels": Hardware(cache=CACHE, data_width=64, lanes=2),
    "multiport": Hardware(fetcher="multiport", data_width=64),
}
ROUGH = "+axi_wait=90", "+axi_answer=60"

regress = pytest.mark.regress


def descriptor(size=SIZE, raw=RAW):
    return barrel_descriptor(size, raw, hidden_neurons=2)


def noise(raw=RAW):
    return np.random.default_rng(1).integers(0, 256, raw[::-1], np.uint8)


def axi_text(hardware, d):
    """Verilog of a corrector with AXI between Avalon ports, for the benches of whole frames."""
    hardware = Hardware(**{**vars(hardware), "bus": "axi"})
    corrector = Corrector(d, hardware)
    return corrector, adapted(axi_verilog(AxiTop(corrector)), core="ncdc_axi", top="ncdc",
                              lines=d.geometry.corrected_height)


@cache
def built(name):
    return axi_text(BUILDS[name], descriptor())


def run(name, **options):
    corrector, verilog = built(name)
    return simulate_correction(descriptor(), noise(), corrector.hardware, verilog=verilog,
                               **options)


@pytest.mark.parametrize("more", [(), ROUGH], ids=["smooth", "rough"])
@pytest.mark.parametrize("name", ["memory", "stream, four pixels", *(
    pytest.param(name, marks=regress) for name in ("memory, two pixels", "multiport"))])
def test_every_pixel(name, more):
    result = run(name, memory="hostile" if more else "ideal", more=more,
                 sink_chance=100 if more else 256)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.fetches_expected == result.counters["FETCHES"]


@pytest.mark.parametrize("data_width,output,lanes", [
    pytest.param(32, "memory", 1, marks=regress), pytest.param(64, "stream", 1, marks=regress),
    pytest.param(64, "stream", 2, marks=regress), pytest.param(128, "memory", 4, marks=regress)])
def test_as_fast_as_avalon(data_width, output, lanes):
    """Clocks of a frame of 320x240 within a hundredth of those with Avalon's ports, on SDRAM."""
    size, raw = (320, 240), (400, 300)
    d, clocks = descriptor(size, raw), []
    for bus in ("avalon", "axi"):
        hardware = Hardware(data_width=data_width, output=output, lanes=lanes)
        verilog = axi_text(hardware, d)[1] if bus == "axi" else None
        result = simulate_correction(d, noise(raw), Hardware(**{**vars(hardware), "bus": bus}),
                                     verilog=verilog, memory="sdram")
        assert result.differing == []
        clocks.append(result.counters["CLOCKS"])
    print(f"AXI {data_width} {output} {lanes}: {clocks[1] / clocks[0]:.4f} of {clocks[0]} clocks")
    assert clocks[1] < 1.01 * clocks[0]


class Announced(BurstWriter):
    """Says that a frame is done when its last word is accepted, answered or not."""

    def _answers(self, m, burst_queue, burst, write, frame_end, accepted, nothing):
        m.d.comb += self.done.eq((accepted | nothing) & frame_end)
        return True


class Crossing:
    """Sees no end of a page."""

    def _to_end(self, address):
        return 1 << 12


def planted(monkeypatch, module, name, error):
    monkeypatch.setattr(module, name, error)
    return axi_text(BUILDS["memory"], descriptor())


@pytest.mark.parametrize("error,rule", [("announced", "done-early"), ("reads", "page"),
                                        ("writes", "page")])
def test_a_planted_error_is_found(error, rule, monkeypatch):
    """A frame that is announced before it is in memory, and bursts across pages."""
    from ncdc_hdl import corrector as room
    from ncdc_hdl.axi import top
    if error == "announced":
        corrector, verilog = planted(monkeypatch, room, "BurstWriter", Announced)
    else:
        name, kind = {"reads": ("ReadBridge", read_bridge.ReadBridge),
                      "writes": ("WriteBridge", write_bridge.WriteBridge)}[error]
        corrector, verilog = planted(monkeypatch, top, name, type(name, (Crossing, kind), {}))
    with pytest.raises(SimulationError, match=f"axi_.* {rule}"):
        # Places of 4 KB and more: the frame begins in the middle of a burst before a page's end.
        result = simulate_resets(corrector, verilog, [noise(), noise()], 6, forgets=False,
                                 longest=500, memory="hostile", more=("+axi_answer=60",),
                                 clock_limit=100_000)
        raise AssertionError(f"nothing was found: {result}")


@pytest.mark.parametrize("port", ["read", "write"])
def test_an_error_of_the_memory_is_told(port):
    """FAULT.MEMORY, with the answer that is the fifth."""
    corrector, verilog = built("memory")
    other = "axi_read_memory" if port == "write" else "axi_write_memory"
    head, _, tail = verilog.partition(f"module {other}")
    verilog = head + f"module {other}" + tail.replace("axi_fail=%d", "no_fail=%d", 1)
    [fault] = [r for r in registers(2, descriptor().formats) if r.name == "FAULT"]
    told = []
    for more in ((), ("+axi_fail=5",)):
        corrector_program = _with_fault(fault.address)
        result = corrector_program(verilog, corrector, more)
        told.append(result)
    assert told == [0, FAULT_MEMORY]


def _with_fault(address):
    """Runs a frame; the register of faults behind it."""
    from ncdc_model.interface.frames import FramePlaces, frame_bytes, raw_image
    from ncdc_sim.system.corrector import corrector_program
    from ncdc_sim.system.frame import simulate_frame

    def frame(verilog, corrector, more):
        g = corrector.descriptor.geometry
        places = FramePlaces.after_reset(g, corrector.hardware.data_width)
        program = corrector_program(corrector.descriptor, corrector.hardware).read(address)
        result = simulate_frame(verilog, raw_image(noise(), places.pitch), program,
                                source_base=places.source, output_base=places.target,
                                output_bytes=frame_bytes(g), more=more)
        return result.registers[address]
    return frame


@pytest.mark.parametrize("forgets", [True, False], ids=["forgets", "answers"])
@pytest.mark.parametrize("name,frames", [("memory", 40), *(
    pytest.param(name, 100, marks=regress) for name in BUILDS)])
def test_the_frame_behind_a_reset_is_right(name, frames, forgets):
    corrector, verilog = built(name)
    result = simulate_resets(corrector, verilog, [noise(), noise()[::-1]], frames, forgets=forgets,
                             longest=700, memory="hostile", more=ROUGH, clock_limit=20_000 * frames)
    assert result.differing == (0,) * frames
    assert result.under_way > frames // 8
