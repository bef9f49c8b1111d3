// The clocks of the USB bench for simulators that keep time themselves.

`timescale 1ps/1ps

module usb_clock;
    integer clk_period, extclk_period;
    reg clk = 0, extclk = 0;
    initial begin
        if (!$value$plusargs("clk_period=%d", clk_period)) clk_period = 10000;
        if (!$value$plusargs("extclk_period=%d", extclk_period)) extclk_period = 16667;
        fork
            forever #(clk_period / 2) clk = !clk;
            forever #(extclk_period / 2) extclk = !extclk;
        join
    end
    usb_bench bench (.clk(clk), .extclk(extclk));
endmodule
