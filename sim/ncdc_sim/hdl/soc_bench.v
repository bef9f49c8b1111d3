// The system on a chip, with a sensor and an EEPROM (24C64) at its pins; clocks, Ethernet and serial line
// come from soc_main.cpp. NCDC_SENSOR is the sensor's name, NCDC_CSI2 the number of its lanes, 2, if it has CSI-2: its
// PHY is left out, and the clock of the bytes is that of the pixels.

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
    wire        pixclk, frame_valid, line_valid, scl_low, sda_low, reset_n;
    wire        sensor_sda_low, eeprom_sda_low;
    wire [11:0] data;
    wire        scl = !scl_low, sda = !sda_low && !sensor_sda_low && !eeprom_sda_low;

`ifdef NCDC_CSI2
    wire [8*`NCDC_CSI2-1:0] lane_bytes;
    wire [`NCDC_CSI2-1:0]   lane_valid, lane_active;
    localparam EMBEDDED = `NCDC_SENSOR == "imx219" ? 2 : 0;
    csi2_transmitter #(.LANES(`NCDC_CSI2), .EMBEDDED(EMBEDDED)) lanes (
        .pixel_clk(pixclk), .reset_n(reset_n && !rst), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .byte_clk(extclk), .bytes(lane_bytes),
        .hs(lane_active), .valid(lane_valid), .lp_p(), .lp_n(), .idle());
`endif

    ncdc_soc soc (
        .sys_clk(clk), .sys_rst(rst), .serial_source_valid(serial_valid),
        .serial_source_ready(1'b1), .serial_source_data(serial_data),
        .serial_sink_valid(terminal_valid), .serial_sink_ready(terminal_ready),
        .serial_sink_data(terminal_data),
        .eth_source_valid(tx_valid), .eth_source_ready(1'b1), .eth_source_data(tx_data),
        .eth_sink_valid(rx_valid), .eth_sink_ready(), .eth_sink_data(rx_data),
`ifdef NCDC_CSI2
        .sensor_clock(extclk),
        .sensor_lane0_data(lane_bytes[7:0]), .sensor_lane0_valid(lane_valid[0]),
        .sensor_lane0_active(lane_active[0]),
        .sensor_lane1_data(lane_bytes[15:8]), .sensor_lane1_valid(lane_valid[1]),
        .sensor_lane1_active(lane_active[1]),
`else
        .sensor_clock(pixclk), .sensor_frame_valid(frame_valid), .sensor_line_valid(line_valid),
        .sensor_data(data),
`endif
        .sensor_scl(scl), .sensor_sda(sda), .sensor_scl_low(scl_low),
        .sensor_sda_low(sda_low), .sensor_reset_n(reset_n));

    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(extclk), .reset_n(reset_n && !rst), .pixclk(pixclk), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .scl(scl), .sda(sda), .sda_low(sensor_sda_low));

    eeprom_24c #(.BYTES(8192)) eeprom (
        .clk(extclk), .scl(scl), .sda(sda), .sda_low(eeprom_sda_low));
endmodule
