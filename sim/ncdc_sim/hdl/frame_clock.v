// The clock of the frame bench for simulators that keep time themselves.

`timescale 1ns/1ps

module frame_clock;
    reg clk = 0;
    always #5 clk = !clk;
    frame_bench bench (.clk(clk));

    string waves;                       // file of the waveforms, if there are to be any
    initial
        if ($value$plusargs("waves=%s", waves)) begin
            $dumpfile(waves);
            $dumpvars(0, bench);
        end
endmodule
