"""The Verilog model of an EEPROM of the 24C kind, seen by cocotbext-i2c's controller."""

import numpy as np
import pytest

from cocotb_run import Design, run_cocotb
from ncdc_sim.runner import hdl_text
from ncdc_sim.tools import SimulationError

# Pins, bytes, bytes of a page: 24C02, 24C04 with two addresses of its own, 24C32, 24C512.
CHIPS = ((1, 256, 8), (2, 512, 16), (4, 4096, 32), (6, 65536, 128))
_TOP = """
module eeprom_lines (
    input wire clk, input wire scl_o, input wire sda_o, output wire scl, output wire sda
);
    wire [4:0] low;
    assign scl = scl_o;
    assign sda = sda_o && low == 0;
%s
endmodule
"""
_CHIP = ('    eeprom_24c #(.PINS({0}), .BYTES({1}), .PAGE({2}), .FILE("eeprom{0}=%s"))\n'
         '        chip{0} (.clk(clk), .scl(scl), .sda(sda), .sda_low(low[{3}]));')


def design(parts=CHIPS, change=lambda text: text):
    """Chips, and one at 0x50 without a file, on one bus; ``change`` of the model's text."""
    chips = [_CHIP.format(*one, k) for k, one in enumerate((*parts, (0, 4096, 32)))]
    return Design("eeprom_lines", _TOP % "\n".join(chips) + change(hdl_text("eeprom_24c.v")))


def run(parts=CHIPS, change=lambda text: text):
    files, chips, rng = {}, [], np.random.default_rng(1)
    for pins, size, page in parts:
        content = rng.bytes(min(size, 4000) - 1)
        files[f"chip{pins}"] = content
        chips.append((pins, size, page, content.hex()))
    run_cocotb(design(parts, change), "eeprom", "icarus", files=files, chips=chips,
               plusargs=[f"+eeprom{pins}=chip{pins}" for pins, *_ in parts])


@pytest.mark.longer
def test_chips_of_four_sizes_on_one_bus():
    run()


@pytest.mark.longer
@pytest.mark.parametrize("rule,broken,failing", [
    ("given <= 0;", "", "without_stop"), ("(next & IN_PAGE)", "next", "pages"),
    ("content[pointer & IN_CHIP];", "content[pointer];", "reads"),
    ("&& busy == 0", "", "pages")])
def test_a_broken_chip_is_found(rule, broken, failing):
    def change(text):
        assert text.count(rule) == 1, rule
        return text.replace(rule, broken)
    with pytest.raises(SimulationError, match=f"failed: .*{failing}"):
        run(CHIPS[:1], change)
