// The system on a chip, with a sensor at its pins; clocks, Ethernet and serial line come from
// soc_main.cpp. NCDC_SENSOR is the sensor's name.

`timescale 1ns/1ps

module soc_bench (
    input  wire       clk,
    input  wire       extclk,           // the sensor's
    input  wire       rst,
    input  wire       rx_valid,         // bytes of a frame to the system, without a pause
    input  wire [7:0] rx_data,
    output wire       tx_valid,         // and from it
    output wire [7:0] tx_data,
    output wire       serial_valid,     // bytes of the serial line from the system
    output wire [7:0] serial_data,
    input  wire       terminal_valid,   // and to it
    output wire       terminal_ready,
    input  wire [7:0] terminal_data
);
    wire        pixclk, frame_valid, line_valid, scl_low, sda_low, sensor_sda_low, reset_n;
    wire [11:0] data;
    wire        scl = !scl_low, sda = !sda_low && !sensor_sda_low;

    ncdc_soc soc (
        .sys_clk(clk), .sys_rst(rst), .serial_source_valid(serial_valid),
        .serial_source_ready(1'b1), .serial_source_data(serial_data),
        .serial_sink_valid(terminal_valid), .serial_sink_ready(terminal_ready),
        .serial_sink_data(terminal_data),
        .eth_source_valid(tx_valid), .eth_source_ready(1'b1), .eth_source_data(tx_data),
        .eth_sink_valid(rx_valid), .eth_sink_ready(), .eth_sink_data(rx_data),
        .sensor_clock(pixclk), .sensor_frame_valid(frame_valid), .sensor_line_valid(line_valid),
        .sensor_data(data), .sensor_scl(scl), .sensor_sda(sda), .sensor_scl_low(scl_low),
        .sensor_sda_low(sda_low), .sensor_reset_n(reset_n));

    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(extclk), .reset_n(reset_n && !rst), .pixclk(pixclk), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .scl(scl), .sda(sda), .sda_low(sensor_sda_low));
endmodule
