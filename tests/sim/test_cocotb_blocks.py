"""Verilog of each block under both simulators, compared with the golden model.

A design is compiled once per simulator; gaps, stalls, waits and latencies are settings of a run.
"""

from functools import cache

import pytest

from cameras import barrel_descriptor
from cocotb_run import design_of, run_cocotb
from ncdc_hdl.avalon.burst_writer import BurstWriter
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_hdl.backend.multiport import Multiport
from ncdc_hdl.backend.window import WindowAddress
from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron
from ncdc_hdl.neural.tansig import Tansig
from ncdc_hdl.registers.agent import Registers
from ncdc_hdl.registers.weight_store import in_memory
from ncdc_sim.tools import SIMULATORS, SimulationError
from ncdc_spec.descriptor import Formats
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import registers
from ncdc_spec.tansig import TansigDesign

pytestmark = pytest.mark.longer

FORMATS = Formats()
D = barrel_descriptor((20, 16), (24, 18), hidden_neurons=3)
F = FORMATS.coordinate.f_bits
BURST = 8


def agent(share):
    """The registers of ``D`` for units that serve ``share`` neurons."""
    rows, hardware = registers(D.hidden_neurons, D.formats), Hardware(share=share)
    constants = {"DIGEST": int(D.digest[:8], 16), "NEURONS": D.hidden_neurons,
                 "CAPABILITIES": 7, "LARGEST": 9}
    return Registers(rows, host_values(D), constants,
                     in_memory=in_memory(rows, hardware),
                     neurons=hardware.served(D.hidden_neurons))


COMPONENTS = {
    "tansig": lambda: Tansig(TansigDesign()),
    "hidden": lambda: HiddenNeuron(FORMATS),
    "output": lambda: OutputNeuron(3, FORMATS),
    "window": lambda: WindowAddress(FORMATS),
    "interpolator": lambda: Interpolator(F),
    "multiport32": lambda: Multiport(F, 32),
    "multiport128": lambda: Multiport(F, 128),
    "burst_writer": lambda: BurstWriter(64, burst=BURST),
    "capture32": lambda: Capture(32, burst=4, depth=16),
    "capture_grid32": lambda: Capture(32, burst=4, depth=16, grid=56),
    "capture_grid128": lambda: Capture(128, burst=4, depth=64, grid=28),
    "capture128": lambda: Capture(128, burst=4, depth=64),
    "i2c": lambda: I2cController(),
    "backmap": lambda: BackMap(D.hidden_neurons, D.formats),
    "registers": lambda: agent(1),
    "registers_shared": lambda: agent(2),
    "corrector_cache": lambda: Corrector(D),
    "corrector_multiport": lambda: Corrector(D, Hardware(fetcher="multiport")),
}

BOTH = pytest.mark.parametrize("simulator", SIMULATORS)


def simulated(names, *cases):
    """The last case, the hardest, under both simulators; the others are `make regress`.

    Gaps, stalls and widths are those of each block's own tests in Amaranth's simulator; here its
    Verilog is compared, by two readers of it.
    """
    return pytest.mark.parametrize(f"{names},simulator", [
        *((*cases[-1], simulator) for simulator in SIMULATORS),
        *(pytest.param(*case, simulator, marks=pytest.mark.regress)
          for case in cases[:-1] for simulator in SIMULATORS)])


PAUSES = simulated("gap,stall", (0, 0), (0, .5), (.5, .3))


@cache
def component(name):
    return COMPONENTS[name]()


@cache
def design(name):
    return design_of(component(name), top=f"dut_{name}")


@pytest.fixture(scope="module")
def descriptor(tmp_path_factory):
    path = tmp_path_factory.mktemp("descriptor") / "net.toml"
    D.save(path)
    return str(path)


@BOTH
def test_tansig(simulator):
    run_cocotb(design("tansig"), "tansig", simulator, latency=component("tansig").latency)


def test_a_wrong_latency_is_found():
    with pytest.raises(SimulationError, match="(?s)failed: .*equals_model.*not equal"):
        run_cocotb(design("tansig"), "tansig", "icarus", latency=component("tansig").latency + 1)


@simulated("kind,inputs", ("hidden", 2), ("output", 3))
def test_neuron(kind, inputs, simulator):
    run_cocotb(design(kind), "neuron", simulator, kind=kind, inputs=inputs,
               latency=component(kind).latency)


@PAUSES
def test_window(gap, stall, simulator):
    run_cocotb(design("window"), "window", simulator, gap=gap, stall=stall)


@PAUSES
def test_interpolator(gap, stall, simulator):
    run_cocotb(design("interpolator"), "interpolator", simulator, gap=gap, stall=stall,
               phase=[int(gap > 0), int(stall > 0)])


@simulated("data_width,gap,stall,wait,latency", (32, 0, 0, 0, (1, 1)), (32, .3, 0, .5, (1, 20)),
           (128, 0, .5, .3, (8, 8)), (32, .5, .5, .7, (1, 60)))
def test_multiport(data_width, gap, stall, wait, latency, simulator):
    run_cocotb(design(f"multiport{data_width}"), "multiport", simulator, gap=gap, stall=stall,
               wait=wait, latency=latency, data_width=data_width, seed=data_width)


@simulated("count,gap,wait", (1, 0, 0), (16, 0, 0), (27, .4, .4))
def test_burst_writer(count, gap, wait, simulator):
    run_cocotb(design("burst_writer"), "burst_writer", simulator, gap=gap, wait=wait, count=count,
               burst=BURST, data_width=64)


@simulated("quarter", (8,))
def test_i2c(quarter, simulator):
    run_cocotb(design("i2c"), "i2c", simulator, quarter=quarter)


# The core's clock is 10 ns.
@simulated("data_width,period_ps,phase_ps,wait,seed", (32, 10_000, 1, 0, 1),
           (32, 79_990, 7_000, .6, 3), (128, 1_270, 300, .2, 2))
def test_capture(data_width, period_ps, phase_ps, wait, seed, simulator):
    run_cocotb(design(f"capture{data_width}"), "capture", simulator, camera_period_ps=period_ps,
               phase_ps=phase_ps, wait=wait, seed=seed)


@simulated("data_width,grid,period_ps,phase_ps,wait,seed", (32, (0, 0), 10_000, 1, .2, 1),
           (32, (3, 1), 19_990, 7_000, .6, 3), (128, (3, 0), 1_270, 300, .2, 2))
def test_capture_with_a_grid_stage(data_width, grid, period_ps, phase_ps, wait, seed, simulator):
    run_cocotb(design(f"capture_grid{data_width}"), "capture", simulator, grid=grid,
               camera_period_ps=period_ps, phase_ps=phase_ps, wait=wait, seed=seed)


@simulated("stall,busy", (0, 0), (.8, .5))
def test_backmap(stall, busy, simulator, descriptor):
    run_cocotb(design("backmap"), "backmap", simulator, stall=stall, busy=busy,
               descriptor=descriptor)


@BOTH
@pytest.mark.parametrize("name", ["registers", "registers_shared"])
def test_registers(name, simulator, descriptor):
    run_cocotb(design(name), "registers", simulator, descriptor=descriptor)


@simulated("fetcher,wait,latency", ("multiport", .5, (1, 40)), ("cache", .5, (1, 40)))
def test_corrector(fetcher, wait, latency, simulator, descriptor):
    run_cocotb(design(f"corrector_{fetcher}"), "corrector", simulator, wait=wait, latency=latency,
               descriptor=descriptor)
