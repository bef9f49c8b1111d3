"""The tan-sigmoid's Verilog under both simulators."""

import pytest

from ncdc_hdl.neural.tansig import Tansig
from ncdc_model.tansig import TansigDesign
from ncdc_sim.cocotb_run import design_of, run_cocotb
from ncdc_sim.tools import SIMULATORS, SimulationError

DUT = Tansig(TansigDesign())


@pytest.fixture(scope="module")
def design():
    return design_of(DUT)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_equals_model(design, simulator):
    run_cocotb(design, "tansig", simulator, latency=DUT.latency)


def test_a_wrong_latency_is_found(design):
    with pytest.raises(SimulationError, match="(?s)failed: .*equals_model.*not equal"):
        run_cocotb(design, "tansig", "icarus", latency=DUT.latency + 1)
