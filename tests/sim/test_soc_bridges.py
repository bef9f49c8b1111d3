"""Verilog of the bridges under simulation: gaps, stalls and resets; planted errors are found."""

import pytest

from cocotb_run import design_of, run_cocotb
from ncdc_hdl.avalon.native import NativeReader, NativeWriter
from ncdc_hdl.avalon.wishbone import WishboneAgent
from ncdc_sim.tools import SimulationError
from planted_bridges import CommandOnly, Forgets, TooEarly

_BURST = 8


COMPONENTS = {"reader": NativeReader(32, _BURST), "writer": NativeWriter(32, _BURST, 4, depth=4),
              "wishbone": WishboneAgent(8)}
PLANTED = {"reader": TooEarly(32, _BURST), "writer": CommandOnly(32, _BURST, 4, depth=4),
           "wishbone": Forgets(8)}


def simulate(name, component, simulator="icarus", wait=.5, gap=.3, reset=.2):
    run_cocotb(design_of(component, top=f"dut_{name}"), "soc_bridges", simulator, bridge=name,
               burst=_BURST, bursts=100, seed=5, wait=wait, gap=gap, reset=reset)


@pytest.mark.parametrize("wait,gap,reset", ((0, 0, 0), (.5, .3, .2), (.8, 0, .2)))
@pytest.mark.parametrize("name", COMPONENTS)
def test_bridge(name, wait, gap, reset):
    simulate(name, COMPONENTS[name], wait=wait, gap=gap, reset=reset)


@pytest.mark.regress
@pytest.mark.parametrize("name", COMPONENTS)
def test_bridge_under_verilator(name):
    simulate(name, COMPONENTS[name], "verilator")


@pytest.mark.parametrize("name", PLANTED)
def test_planted_errors_are_found(name):
    with pytest.raises(SimulationError, match="AssertionError"):
        simulate(name, PLANTED[name])
