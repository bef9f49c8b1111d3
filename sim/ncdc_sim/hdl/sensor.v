// A CMOS image sensor: I2C target with its registers, and frames from a file at its pins. Of one with
// CSI-2 these are the samples before its transmitter, csi2_transmitter.v.
//
//   sensor_i2c         I2C target: writes and reads of registers
//   sensor_waking      reset and rest before it answers, and a sensor that is unplugged
//   sensor_<name>      registers of one sensor, and what they mean
//   sensor_core        frames by these meanings: window, mirrors, exposure, gain, test patterns
//
// `extclk` is the pixel clock: there is no PLL. `pixclk` is `extclk`, and the other outputs change
// when it falls. SCL and SDA are sampled with `extclk`, at least 16 times as fast as a bit;
// `sda_low` pulls the line low. A sensor of fewer than 12 bits has them at the top of `data`.
//
// A model of what a user of the sensor sees, with these simplifications: settings are taken at the
// beginning of a frame, none later; a sensor that is switched off stops at once; there is no
// automatic exposure and no noise. It skips and bins as far as ours are set up to, columns and rows
// alike: the MT9P031 by 2 to 7, the others by 2. `extclk` of a sensor with CSI-2 counts its pixels.
//
// Plusargs, all of which may be absent; numbers are decimal:
//   sensor_file=<name>       samples, 16 bits each, the low byte first, row by row, frame by frame
//   sensor_file_width=, sensor_file_height=      of a frame in the file
//   sensor_file_left=, sensor_file_top=          where its corner lies in the active pixels
//   sensor_nominal=          exposure in pixel clocks at which, with a gain of 1, samples leave as
//                            they are in the file; 0 or absent: whatever the exposure and the gain
//   sensor_fault=            short_line, long_line, glitch, cut_frame, clock_stop; nack, stuck_sda
//   sensor_fault_frame=, sensor_fault_row=       where one of the first five happens, from 0 on
//   sensor_fault_clocks=     pixel clocks of clock_stop, clocks of SCL of stuck_sda
//   sensor_fault_start=      number of the START condition, from 0 on, of one of the last two
//   sensor_khz=, sensor_time_scale=, sensor_fault=unplug: see sensor_waking.v
// A pixel outside of the file is dark. The file begins anew whenever the sensor is started,
// and when it has ended. Each frame prints "SENSOR frame <number>", what cannot be modelled
// "SENSOR-ERROR <reason>".

`timescale 1ns/1ps

module sensor #(
    parameter SENSOR = "mt9p031"        // or "mt9d111", "ov5640", "imx219", "ov5647"
) (
    input  wire        extclk,          // pixel clock
    input  wire        reset_n,
    output wire        pixclk,
    output wire        frame_valid,
    output wire        line_valid,
    output wire [11:0] data,
    input  wire        scl,             // the lines, as all that pull them leave them
    input  wire        sda,
    output wire        sda_low          // pulls SDA low
);
    wire        write;
    wire [15:0] pointer, value, answer;

    wire               streaming, mirror_columns, mirror_rows;
    wire signed [16:0] left, top;
    wire [15:0]        width, height;
    wire [3:0]         skip;
    wire [2:0]         binning;
    wire [31:0]        line_clocks, frame_lines, gain;
    wire [47:0]        exposure;
    wire [3:0]         pattern;
    wire [47:0]        colours;
    wire [11:0]        black;

    localparam MT9P031 = SENSOR == "mt9p031", MT9D111 = SENSOR == "mt9d111";
    localparam OV5640 = SENSOR == "ov5640", IMX219 = SENSOR == "imx219", OV5647 = SENSOR == "ov5647";
    localparam [6:0] ADDRESS = MT9P031 ? 7'h5D : MT9D111 ? 7'h48 : OV5640 ? 7'h3C
        : IMX219 ? 7'h10 : 7'h36;
    localparam WIDE_VALUE = MT9P031 || MT9D111, WIDE_POINTER = !WIDE_VALUE;
    localparam BITS = MT9P031 ? 12 : 10;
    // Before the first access. MT9P031: Linux, mt9p031.c. OV5640: data sheet, power up sequence, t3 and
    // t4. MT9D111: not found; taken for that of the OV5640. IMX219, OV5647: Linux, imx219.c and ov5647.c.
    localparam RESET_US = 1000, REST_US = MT9P031 ? 0 : IMX219 ? 6200 : 20000;
    localparam REST_CLOCKS = MT9P031 ? 850000 : 0;
    // Parities of the red pixels, counted from the first active one.
    localparam RED_COLUMN = !IMX219 && !OV5647, RED_ROW = OV5640 || OV5647;

    wire plugged, awake, running;
    sensor_waking #(
        .RESET_US(RESET_US), .REST_US(REST_US), .REST_CLOCKS(REST_CLOCKS)
    ) waking (
        .extclk(extclk), .reset_n(reset_n), .scl(scl), .sda(sda), .plugged(plugged), .awake(awake));
    wire powered = reset_n && plugged;
    assign pixclk = running && plugged;

    generate if (MT9P031) begin : chip_mt9p031
        sensor_mt9p031 registers (
            .clk(extclk), .reset_n(powered), .write(write), .pointer(pointer), .value(value),
            .answer(answer),
`include "sensor_connections.vh"
        );
    end endgenerate
    generate if (MT9D111) begin : chip_mt9d111
        sensor_mt9d111 registers (
            .clk(extclk), .reset_n(powered), .write(write), .pointer(pointer), .value(value),
            .answer(answer),
`include "sensor_connections.vh"
        );
    end endgenerate
    generate if (OV5640) begin : chip_ov5640
        sensor_ov5640 registers (
            .clk(extclk), .reset_n(powered), .write(write), .pointer(pointer), .value(value),
            .answer(answer),
`include "sensor_connections.vh"
        );
    end endgenerate
    generate if (IMX219) begin : chip_imx219
        sensor_imx219 registers (
            .clk(extclk), .reset_n(powered), .write(write), .pointer(pointer), .value(value),
            .answer(answer),
`include "sensor_connections.vh"
        );
    end endgenerate
    generate if (OV5647) begin : chip_ov5647
        sensor_ov5647 registers (
            .clk(extclk), .reset_n(powered), .write(write), .pointer(pointer), .value(value),
            .answer(answer),
`include "sensor_connections.vh"
        );
    end endgenerate
    initial if (!MT9P031 && !MT9D111 && !OV5640 && !IMX219 && !OV5647) begin
        $display("SENSOR-ERROR no sensor %0s", SENSOR);
        $finish;
    end

    sensor_i2c #(
        .ADDRESS(ADDRESS), .WIDE_POINTER(WIDE_POINTER), .WIDE_VALUE(WIDE_VALUE)
    ) target (
        .clk(extclk), .reset_n(powered && awake), .scl(scl), .sda(sda), .sda_low(sda_low), .write(write),
        .pointer(pointer), .value(value), .answer(answer));

    sensor_core #(
        .BITS(BITS), .RED_COLUMN(RED_COLUMN), .RED_ROW(RED_ROW)
    ) core (
        .extclk(extclk), .reset_n(powered), .pixclk(running), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data),
`include "sensor_connections.vh"
    );
endmodule
