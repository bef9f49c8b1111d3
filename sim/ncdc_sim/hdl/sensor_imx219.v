// Registers of the IMX219, and what they mean: RAW10 frames of a window, of all pixels or binned by 2.
// Addresses and equations: see model/ncdc_spec/sensors/imx219.py, from which this file shares no code.

`timescale 1ns/1ps

module sensor_imx219 (
`include "sensor_registers.vh"
);
    localparam [11:0] BLACK = 12'd256;

    // Registers 0x0000 to 0x06FF; the undocumented ones are taken and change nothing.
    reg [7:0] file [0:16'h06FF];
    wire there = pointer < 16'h0700;
    assign answer = there ? {8'd0, file[pointer[10:0]]} : 0;

    integer k;
    always @(posedge clk)
        if (!reset_n) begin
            for (k = 0; k < 16'h0700; k = k + 1)
                file[k] <= 0;
            file[11'h000] <= 8'h02;
            file[11'h001] <= 8'h19;
            file[11'h158] <= 8'h01;
        end else if (write && there && pointer > 1)
            file[pointer[10:0]] <= value[7:0];

    wire [15:0] x_start = {file[11'h164], file[11'h165]}, x_end = {file[11'h166], file[11'h167]};
    wire [15:0] y_start = {file[11'h168], file[11'h169]}, y_end = {file[11'h16A], file[11'h16B]};
    wire [15:0] digital = {file[11'h158], file[11'h159]}, shown = {file[11'h600], file[11'h601]};
    wire [31:0] analog = 256 - {24'd0, file[11'h157]};
    wire [7:0]  binned = file[11'h174];

    assign streaming = file[11'h100][0];
    assign mirror_columns = file[11'h172][0];
    assign mirror_rows = file[11'h172][1];
    assign left = {1'b0, x_start};
    assign top = {1'b0, y_start};
    assign width = {file[11'h16C], file[11'h16D]};
    assign height = {file[11'h16E], file[11'h16F]};
    assign skip = binned == 1 ? 2 : 1;
    assign binning = binned == 1 ? 2 : 1;
    assign line_clocks = {16'd0, file[11'h162], file[11'h163]};
    assign frame_lines = {16'd0, file[11'h160], file[11'h161]};
    assign exposure = {32'd0, file[11'h15A], file[11'h15B]} * {16'd0, line_clocks};
    assign gain = (256 * {16'd0, digital} + analog / 2) / analog;
    assign pattern = shown == 1 ? 1 : shown == 2 ? 8 : 0;
    assign colours = {file[11'h604][1:0], file[11'h605], 2'd0, file[11'h602][1:0], file[11'h603], 2'd0,
                      file[11'h606][1:0], file[11'h607], 2'd0, file[11'h608][1:0], file[11'h609], 2'd0};
    assign black = BLACK;

    // What a sensor that is started is set to.
    wire [15:0] step = binned == 1 ? 2 : 1;
    always @(posedge streaming) begin
        if (binned > 1 || file[11'h175] != binned || file[11'h170] != 1 || file[11'h171] != 1)
            $display("SENSOR-ERROR rows are binned as columns are, by 1 or 2, in this model");
        if (x_end + 1 - x_start != step * width || y_end + 1 - y_start != step * height)
            $display("SENSOR-ERROR the window has another size than the frame");
        if (file[11'h114] != 1 || {file[11'h18C], file[11'h18D], file[11'h309]} != 24'h0A0A0A)
            $display("SENSOR-ERROR two lanes of RAW10 are modelled");
        if (shown > 2)
            $display("SENSOR-ERROR test pattern %0d is not modelled", shown);
    end
endmodule
