// Ports of a sensor's register file: a write or a read of the I2C target, and what the registers mean.
    input  wire               clk,
    input  wire               reset_n,
    input  wire               write,
    input  wire [15:0]        pointer,
    input  wire [15:0]        value,
    output wire [15:0]        answer,
`define NCDC_MEANING output
`include "sensor_meanings.vh"
`undef NCDC_MEANING
