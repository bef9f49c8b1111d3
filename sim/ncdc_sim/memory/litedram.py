"""LiteDRAM, a third-party memory controller, as a memory of the frame bench.

The package ``litedram`` generates the Verilog of the controller and of LiteDRAM's model of PHY and
memory on request; the repository holds none of it.
"""

import importlib.metadata
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from ncdc_sim.tools import SimulationError, call
from ncdc_spec.builds import built, key_of, without_header
from ncdc_spec.errors import InputError
from ncdc_spec.needs import pip_line

__all__ = ["LITEDRAM", "LiteDram", "litedram_sources"]

_PACKAGES = ("litedram", "litex")


@dataclass(frozen=True)
class LiteDram:
    """A core that LiteDRAM can make, at 100 MHz.

    Parameters
    ----------
    native : int
        Bits of its native ports.
    address_bits : int
        Bits of a native word's address: row, bank, column from the top.
    banks, column_bits : int
        Banks and column bits of the memory; columns count native words.
    config : dict
        For LiteDRAM's generator, ports aside.
    """
    native: int
    address_bits: int
    banks: int
    column_bits: int
    config: dict

    @property
    def bytes(self):
        """Size of the memory."""
        return self.native // 8 << self.address_bits


_COMMON = {"cpu": None, "sys_clk_freq": 100e6, "input_clk_freq": 100e6}

# The memories of ncdc_model.planner.memory_timing: IS42S16320 twice, a DDR3 of 2 Gbit, x16.
# LiteDRAM counts modules of 8 bits. In simulation its model of PHY and memory stands for the PHY
# named.
LITEDRAM = {
    "litedram": LiteDram(32, 25, 4, 10, _COMMON | {
        "memtype": "SDR", "sdram_module": "IS42S16320", "sdram_module_nb": 4,
        "sdram_phy": "GENSDRPHY"}),
    "litedram-ddr3": LiteDram(128, 24, 8, 7, _COMMON | {
        "memtype": "DDR3", "sdram_module": "MT41K128M16", "sdram_module_nb": 2,
        "sdram_rank_nb": 1, "sdram_phy": "A7DDRPHY", "speedgrade": -1, "cmd_latency": 0,
        "iodelay_clk_freq": 200e6, "rtt_nom": "60ohm", "rtt_wr": "60ohm", "ron": "34ohm"}),
}


def litedram_sources(core, ports):
    """[(file name, Verilog)] of the ``core`` with so many native ports, side by side in the ports
    of the module ``litedram_core``; see ``hdl/litedram_memory.v``.

    Raises
    ------
    InputError
        If LiteDRAM is not installed.
    SimulationError
        If it does not make what this module expects.
    """
    try:
        versions = [importlib.metadata.version(name) for name in _PACKAGES]
    except importlib.metadata.PackageNotFoundError as error:
        raise InputError(f"{error.name} is not installed, which the memory litedram needs: "
                         f"{pip_line('litedram')}") from error
    config = json.dumps(core.config | {"user_ports": {
        f"p{k}": {"type": "native", "block_until_ready": False} for k in range(ports)}})

    def generate(folder):
        (folder / "core.yml").write_text(config)
        call([sys.executable, "-m", "litedram.gen", "--sim", "--no-compile", "--output-dir", "made",
              "--name", "litedram", "core.yml"], folder)

    made = built(key_of("litedram", config, *versions), generate)
    text = without_header((Path(made) / "made/gateware/litedram.v").read_text())
    return [("litedram.v", text), ("litedram_core.v", _adapter(core, ports, text))]


def _adapter(core, ports, text):
    """Verilog of ``litedram_core``: the ports as vectors, and functions that see the content."""
    memories = dict(re.findall(r"bankmodel(\d+)_read_port_dat_r = (\w+)\[", text))
    width = re.search(r"input +wire +\[(\d+):0\] +user_port_p0_cmd_addr", text)
    if (sorted(map(int, memories)) != list(range(core.banks)) or not width
            or int(width[1]) + 1 != core.address_bits):
        raise SimulationError("LiteDRAM made a core without the expected banks and addresses")
    w, a = core.native, core.address_bits
    connections = "".join(f"""
        .user_port_p{k}_cmd_addr(cmd_addr[{a * k} +: {a}]),
        .user_port_p{k}_cmd_valid(cmd_valid[{k}]), .user_port_p{k}_cmd_ready(cmd_ready[{k}]),
        .user_port_p{k}_cmd_we(cmd_we[{k}]),
        .user_port_p{k}_wdata_data(wdata[{w * k} +: {w}]),
        .user_port_p{k}_wdata_we(wdata_we[{w // 8 * k} +: {w // 8}]),
        .user_port_p{k}_wdata_valid(wdata_valid[{k}]),
        .user_port_p{k}_wdata_ready(wdata_ready[{k}]),
        .user_port_p{k}_rdata_data(rdata[{w * k} +: {w}]),
        .user_port_p{k}_rdata_valid(rdata_valid[{k}]),
        .user_port_p{k}_rdata_ready(1'b1),""" for k in range(ports))
    bank = f"address[{core.column_bits} +: {core.banks.bit_length() - 1}]"
    index = (f"{{address[{a - 1}:{core.column_bits + core.banks.bit_length() - 1}], "
             f"address[{core.column_bits - 1}:0]}}")
    peek = "".join(f"\n            {k}: peek = core.{memories[str(k)]}[{index}];"
                   for k in range(core.banks))
    poke = "".join(f"\n            {k}: core.{memories[str(k)]}[{index}] = value;"
                   for k in range(core.banks))
    return f"""`timescale 1ns/1ps
module litedram_core (
    input  wire clk,
    input  wire [{ports - 1}:0] cmd_valid,
    output wire [{ports - 1}:0] cmd_ready,
    input  wire [{ports - 1}:0] cmd_we,
    input  wire [{ports * a - 1}:0] cmd_addr,
    input  wire [{ports - 1}:0] wdata_valid,
    output wire [{ports - 1}:0] wdata_ready,
    input  wire [{ports * w - 1}:0] wdata,
    input  wire [{ports * w // 8 - 1}:0] wdata_we,
    output wire [{ports - 1}:0] rdata_valid,
    output wire [{ports * w - 1}:0] rdata
);
    litedram core ({connections}
        .clk(clk), .sim_trace(1'b0), .init_done(), .init_error(), .user_clk(), .user_rst(),
        .wb_ctrl_ack(), .wb_ctrl_adr(30'd0), .wb_ctrl_bte(2'd0), .wb_ctrl_cti(3'd0),
        .wb_ctrl_cyc(1'b0), .wb_ctrl_dat_r(), .wb_ctrl_dat_w(32'd0), .wb_ctrl_err(),
        .wb_ctrl_sel(4'd0), .wb_ctrl_stb(1'b0), .wb_ctrl_we(1'b0)
    );

    function [{w - 1}:0] peek(input [{a - 1}:0] address);
        case ({bank}){peek}
        endcase
    endfunction

    task poke(input [{a - 1}:0] address, input [{w - 1}:0] value);
        case ({bank}){poke}
        endcase
    endtask
endmodule
"""
