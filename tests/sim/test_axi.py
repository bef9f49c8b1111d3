"""Whole frames through AXI: pixels, rules of the buses, clocks compared with Avalon's, resets."""

from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from cocotb_run import Design, run_cocotb
from ncdc_hdl import corrector as corrector_module
from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.axi import top
from ncdc_hdl.axi.read_bridge import ReadBridge
from ncdc_hdl.axi.top import AxiTop
from ncdc_hdl.axi.write_bridge import WriteBridge
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.axi_cover import axi_verilog
from ncdc_sim.system.corrector import corrector_program, simulate_correction
from ncdc_sim.system.frame import simulate_frame
from ncdc_sim.tools import SIMULATORS, SimulationError
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import FAULT_MEMORY, registers
from simulations.axi import adapted
from simulations.resets import simulate_resets

SIZE, RAW = (40, 32), (48, 40)
CACHE = CacheOptions(64, pending=64, outstanding=8)
BUILDS = {
    # Rows of strips begin anywhere, so that a burst would cross the end of a page.
    "memory": Hardware(cache=CACHE, strip=32),
    "stream, four pixels": Hardware(cache=CACHE, data_width=128, output="stream", lanes=4),
    "memory, raster": Hardware(cache=CACHE),
    "memory, two pixels": Hardware(cache=CACHE, strip=32, data_width=64, lanes=2),
    "memory, raster, two pixels": Hardware(cache=CACHE, data_width=64, lanes=2),
    "stream, two pixels": Hardware(cache=CACHE, data_width=64, output="stream", lanes=2),
    "multiport": Hardware(fetcher="multiport", data_width=64),
}
PEERS = (16, 12), (20, 16)       # of the frames in Python, which are slow
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


@pytest.mark.parametrize("simulator", ["icarus", pytest.param("verilator", marks=regress)])
@pytest.mark.parametrize("more", [pytest.param((), marks=regress, id="smooth"),
                                  pytest.param(ROUGH, id="rough")])
@pytest.mark.parametrize("name", ["memory", *(
    pytest.param(name, marks=regress) for name in BUILDS if name != "memory")])
def test_every_pixel(name, more, simulator):
    result = run(name, memory="hostile" if more else "ideal", more=more,
                 sink_probability=100 if more else 256, simulator=simulator)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.fetches_expected == result.counters["FETCHES"]


@pytest.mark.parametrize("data_width,output,lanes", [
    pytest.param(32, "memory", 1, marks=regress), pytest.param(64, "stream", 1, marks=regress),
    pytest.param(64, "memory", 2, marks=regress), pytest.param(128, "stream", 4, marks=regress),
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


@pytest.mark.longer
@pytest.mark.parametrize("fault,rule", [
    ("announced", "done-early"), pytest.param("writes", "page", marks=regress),
    pytest.param("reads", "page", marks=regress)])
def test_a_planted_error_is_found(fault, rule, monkeypatch):
    """A frame that is announced before it is in memory, and bursts across pages: those of reads by
    the multiport fetcher alone, as tiles are aligned."""
    name = "multiport" if fault == "reads" else "memory"
    if fault == "announced":
        monkeypatch.setattr(corrector_module, "BurstWriter", Announced)
    else:
        kind = {"reads": ReadBridge, "writes": WriteBridge}[fault]
        monkeypatch.setattr(top, kind.__name__, type(kind.__name__, (Crossing, kind), {}))
    raw = (80, 60)                              # of more than a page
    corrector, verilog = axi_text(BUILDS[name], descriptor(raw=raw))
    with pytest.raises(SimulationError, match=f"axi_.* {rule}"):
        simulate_correction(corrector.descriptor, noise(raw), corrector.hardware, verilog=verilog,
                            simulator="icarus", memory="hostile", more=("+axi_answer=60",))


@regress
@pytest.mark.parametrize("port", ["write", "read"])
def test_an_error_of_the_memory_is_reported(port):
    """FAULT.MEMORY, with the answer that is the fifth; 0 without one."""
    corrector, verilog = built("memory")
    other = "axi_read_memory" if port == "write" else "axi_write_memory"
    head, name, tail = verilog.partition(f"module {other}")
    verilog = head + name + tail.replace("axi_fail=%d", "no_fail=%d", 1)
    d, g = corrector.descriptor, corrector.descriptor.geometry
    [fault] = [r for r in registers(2, d.formats) if r.name == "FAULT"]
    buffers = FrameAddresses.after_reset(g, corrector.hardware.data_width)
    program = corrector_program(d, corrector.hardware, checked=False).read(fault.address)
    faults = [simulate_frame(verilog, raw_image(noise(), buffers.pitch), program,
                             source_base=buffers.source, output_base=buffers.target,
                             output_bytes=frame_bytes(g), more=more, simulator="icarus"
                             ).registers[fault.address] for more in ((), ("+axi_fail=5",))]
    assert faults == [0, FAULT_MEMORY]


@pytest.mark.longer
@pytest.mark.parametrize("name,frames,simulator,forgets", [
    ("memory", 3, "icarus", False),
    *(pytest.param(name, 100, "verilator", forgets, marks=regress)
      for name in BUILDS for forgets in (True, False))])
def test_the_frame_after_a_reset_is_right(name, frames, simulator, forgets):
    corrector, verilog = built(name)
    result = simulate_resets(corrector, verilog, [noise(), noise()[::-1]], frames, forgets=forgets,
                             longest=900, memory="hostile", more=ROUGH, simulator=simulator,
                             clock_limit=20_000 * frames)
    assert result.differing == (0,) * frames
    assert result.under_way > frames // 8


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("descriptor") / "net.toml"
    descriptor(*PEERS).save(path)
    return str(path)


@pytest.mark.longer
@pytest.mark.parametrize("name,pause,simulator", [
    ("memory, raster", .4, "icarus"),
    pytest.param("stream, four pixels", .4, "icarus", marks=regress),
    *(pytest.param(name, pause, simulator, marks=regress)
      for name in BUILDS if not BUILDS[name].strip for pause in (0, .7)
      for simulator in SIMULATORS)])
def test_peer(name, pause, simulator, file):
    """Memory, host and sink of ``cocotbext-axi``, which we did not write."""
    hardware = Hardware(**{**vars(BUILDS[name]), "bus": "axi"})
    design = Design("ncdc_axi", axi_verilog(AxiTop(Corrector(descriptor(*PEERS), hardware))))
    run_cocotb(design, "axi", simulator, descriptor=file, pause=pause,
               data_width=hardware.data_width, output=hardware.output, strip=hardware.strip)
