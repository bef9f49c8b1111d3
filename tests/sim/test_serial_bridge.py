"""Registers over a serial line, whose other end is of cocotbext-uart."""

import pytest

from cocotb_run import design_of, run_cocotb
from ncdc_hdl.registers.serial_bridge import SerialBridge
from ncdc_sim.tools import SIMULATORS
from ncdc_spec.protocols.serial_link import crc8, read_request
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

DIVISOR = 8


@pytest.mark.longer
@pytest.mark.parametrize("simulator", [
    pytest.param(name, marks=[pytest.mark.regress] if name == "verilator" else [])
    for name in SIMULATORS])
def test_a_host_on_the_line(simulator):
    run_cocotb(design_of(SerialBridge(DIVISOR, SYSTEM_WORDS_BITS)), "serial_bridge", simulator,
               divisor=DIVISOR)


@pytest.mark.regress
@pytest.mark.parametrize("off", [-.02, .02])
def test_a_host_whose_clock_is_off(off):
    """Two in a hundred; ten bits may be off by a half, which is five in a hundred."""
    run_cocotb(design_of(SerialBridge(16, SYSTEM_WORDS_BITS)), "serial_bridge", "icarus",
               divisor=16, off=off)


def test_the_check_is_the_one_of_the_catalogues():
    """CRC-8 of "123456789" with polynomial 0x07 from 0xFF on: 0xFB; a wrong bit changes it."""
    assert crc8(b"123456789") == 0xFB
    request = read_request(0x1234)
    assert crc8(request) == 0
    for bit in range(8 * len(request)):
        wrong = (int.from_bytes(request, "big") ^ 1 << bit).to_bytes(len(request), "big")
        assert crc8(wrong)
