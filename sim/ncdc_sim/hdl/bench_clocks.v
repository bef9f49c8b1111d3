// The clocks of the bench `NCDC_BENCH for simulators that keep time themselves. Plusargs: those of
// bench_main.cpp for clk, extclk and lane.

`timescale 1ps/1ps

module bench_clocks;
    integer clk_period, extclk_period, extclk_phase, lane_period;
    reg clk = 0, extclk = 0, lane = 0;
    initial begin
        if (!$value$plusargs("clk_period=%d", clk_period)) clk_period = 10000;
        if (!$value$plusargs("extclk_period=%d", extclk_period)) extclk_period = 10000;
        if (!$value$plusargs("extclk_phase=%d", extclk_phase)) extclk_phase = extclk_period / 2;
        if (!$value$plusargs("lane_period=%d", lane_period)) lane_period = 10000;
        fork
            forever #(clk_period / 2) clk = !clk;
            forever #(lane_period / 2) lane = !lane;
            begin
                #(extclk_phase) extclk = 1;
                forever #(extclk_period / 2) extclk = !extclk;
            end
        join
    end
    `NCDC_BENCH bench (.*);

    string waves;                       // file of the waveforms, if there are to be any
    initial
        if ($value$plusargs("waves=%s", waves)) begin
            $dumpfile(waves);
            $dumpvars(0, bench);
        end
endmodule
