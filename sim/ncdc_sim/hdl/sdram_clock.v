// The clock of the SDRAM bench for simulators that keep time themselves.

`timescale 1ns/1ps

module sdram_clock;
    reg clk = 0;
    always #5 clk = !clk;
    sdram_bench bench (.clk(clk));
endmodule
