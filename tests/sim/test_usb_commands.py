"""Table I and II and registers over bytes, without a processor."""

import pytest

from cocotb_run import design_of, run_cocotb
from ncdc_hdl.usb import mraw
from ncdc_hdl.usb.commands import ByteCommands
from ncdc_hdl.usb.view import SystemView
from ncdc_sim.tools import SimulationError
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS, Stores, system_registers
from ncdc_spec.sensors.catalogue import sensor_named

ADDRESSES = {r.name: r.address for r in system_registers(Stores(4, 4, 2))}
RAW, CORRECTED = (21, 5), (23, 7)
GAP_US = 20


def run(simulator="icarus", stall=.3):
    view = SystemView(ADDRESSES, CORRECTED, 0, 0x11, 4, reader=1, clock_mhz=100)
    commands = ByteCommands(view, sensor_named("mt9p031"), 64, 4, SYSTEM_WORDS_BITS, GAP_US)
    run_cocotb(design_of(commands), "usb_commands", simulator, raw=RAW, corrected=CORRECTED,
               stall=stall, gap=100 * GAP_US, addresses=ADDRESSES)


@pytest.mark.longer
@pytest.mark.parametrize("simulator", ["icarus", pytest.param("verilator",
                                                              marks=pytest.mark.regress)])
def test_a_host_that_sends_bytes(simulator):
    run(simulator)


@pytest.mark.regress
def test_a_frame_that_is_never_released_is_found(monkeypatch):
    monkeypatch.setattr(mraw, "_RELEASE", 0)
    with pytest.raises(SimulationError, match="pictures"):
        run(stall=0)
