"""A memory that is reset in the midst of a frame, and a corrector that is not: FAULT.MEMORY."""

import subprocess

import pytest

from cameras import barrel_descriptor
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, FAULT_MEMORY, registers

BENCH = """
module bench;
  reg clk = 0, rst = 1, memory_rst = 1, write = 0, read = 0;
  reg [13:0] address = 0;
  wire [31:0] value;
  wire given, wait_;
  always #5 clk = !clk;
  ncdc dut (.clk(clk), .rst(rst), .memory_rst(memory_rst), .csr_address(address),
    .csr_read(read), .csr_write(write), .csr_writedata(32'd{start}), .csr_readdata(value),
    .csr_readdatavalid(given), .csr_waitrequest(wait_), .read0_waitrequest(1'b0),
    .read0_readdata(32'd0), .read0_readdatavalid(1'b0), .stream_ready(1'b1),
    .camera_rows(13'd0));
  task clocks(input integer count); repeat (count) @(posedge clk); endtask
  task start; begin
    address <= {ctrl}; write <= 1; @(posedge clk); while (wait_) @(posedge clk); write <= 0;
  end endtask
  initial begin
    clocks(8); rst <= 0; memory_rst <= 0; clocks(600);
    {steps}
    clocks(4); address <= {fault}; read <= 1;
    @(posedge clk); while (wait_) @(posedge clk); read <= 0;
    while (!given) @(posedge clk);
    $display("%0d", value); $finish;
  end
endmodule
"""
ALONE = "memory_rst <= 1; clocks(3); memory_rst <= 0;"
# What is done, and whether it is a fault.
STEPS = {
    "in a frame": (f"start; clocks(400); {ALONE}", True),
    "without a frame": (ALONE, False),
    "with the corrector": ("start; clocks(400); memory_rst <= 1; clocks(2); rst <= 1; clocks(3); "
                           "rst <= 0; clocks(1); memory_rst <= 0;", False),
    "a frame begins in it": ("memory_rst <= 1; clocks(2); start; clocks(300); memory_rst <= 0;",
                             False)}


@pytest.fixture(scope="module")
def design():
    descriptor = barrel_descriptor((32, 16), (40, 20), hidden_neurons=2)
    return descriptor, corrector_verilog(descriptor, Hardware(output="stream"))


@pytest.mark.parametrize("name", STEPS)
def test_a_memory_that_is_reset_alone_is_a_fault(design, tmp_path, name):
    descriptor, verilog = design
    words = {r.name: r.address for r in registers(2, descriptor.formats)}
    steps, fault = STEPS[name]
    text = BENCH
    for key, value in {"start": CTRL_COMMIT | CTRL_START, "ctrl": words["CTRL"],
                       "fault": words["FAULT"], "steps": steps}.items():
        text = text.replace("{" + key + "}", str(value))
    (tmp_path / "ncdc.v").write_text(verilog)
    (tmp_path / "bench.v").write_text(text)
    subprocess.run(["iverilog", "-g2005", "-s", "bench", "-o", "bench", "bench.v", "ncdc.v"],
                   cwd=tmp_path, check=True)
    out = subprocess.run(["vvp", "bench"], cwd=tmp_path, check=True, text=True, timeout=60,
                         capture_output=True).stdout
    assert int(out.split()[0]) == (FAULT_MEMORY if fault else 0)
