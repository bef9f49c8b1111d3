// When a sensor may be talked to, and whether it is there at all.
//
// It sleeps until its reset pin was low for RESET_US, with its clock, and REST_US or REST_CLOCKS of the
// external clock have passed since then, whichever is longer. A START condition before that prints
// "SENSOR early" and is not answered. Numbers: see sensor.v.
//
// Plusargs, decimal:
//   sensor_khz=          frequency of the external clock; 25000 if absent
//   sensor_time_scale=        so many times shorter are reset and rest; 1 if absent
//   sensor_fault=unplug, sensor_fault_start=, sensor_fault_clocks=
//                        from that external clock on, counted from 0, and for so many of them the sensor
//                        has no supply: its pins are low or let go, its registers lost
// `plugged` changes while the clock is low.

`timescale 1ns/1ps

module sensor_waking #(
    parameter RESET_US = 0,
    parameter REST_US = 0,
    parameter REST_CLOCKS = 0
) (
    input  wire extclk,
    input  wire reset_n,
    input  wire scl,
    input  wire sda,
    output reg  plugged,
    output wire awake
);
    reg [8*16-1:0] fault;
    reg [63:0] khz, time_scale, unplug, away, reset_clocks, rest_clocks, us_clocks;
    initial begin
        if (!$value$plusargs("sensor_khz=%d", khz)) khz = 25000;
        if (!$value$plusargs("sensor_time_scale=%d", time_scale)) time_scale = 1;
        if (!$value$plusargs("sensor_fault=%s", fault)) fault = 0;
        if (!$value$plusargs("sensor_fault_start=%d", unplug)) unplug = 0;
        if (!$value$plusargs("sensor_fault_clocks=%d", away)) away = 0;
        us_clocks = REST_US * khz / 1000;
        reset_clocks = RESET_US * khz / 1000 / time_scale;
        rest_clocks = (us_clocks > REST_CLOCKS ? us_clocks : REST_CLOCKS) / time_scale;
        plugged = 1;
        woken = reset_clocks == 0;
    end

    reg [63:0] now = 0;                 // clocks of the simulation
    reg [63:0] low = 0, rested = 0;     // clocks of the reset, and since its end
    reg        woken;                   // the last reset was long enough
    reg        scl_was = 1, sda_was = 1;
    assign awake = woken && rested >= rest_clocks;

    always @(negedge extclk)
        plugged <= !(fault == "unplug" && now >= unplug && now < unplug + away);

    always @(posedge extclk) begin
        now <= now + 1;
        scl_was <= scl;
        sda_was <= sda;
        if (!plugged) begin
            low <= 0;
            rested <= 0;
            woken <= reset_clocks == 0;
        end else if (!reset_n) begin
            low <= low + 1;
            rested <= 0;
            woken <= low + 1 >= reset_clocks;
        end else begin
            low <= 0;
            if (!awake)
                rested <= rested + 1;
        end
        if (plugged && !awake && scl && scl_was && sda_was && !sda)
            $display("SENSOR early");
    end
endmodule
