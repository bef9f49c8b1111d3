// Registers of the MT9P031, and what they mean. Addresses, defaults and equations: see
// model/ncdc_spec/sensors/mt9p031.py, from which this file shares no code.

`timescale 1ns/1ps

module sensor_mt9p031 (
`include "sensor_registers.vh"
);
    localparam FIRST_COLUMN = 16, FIRST_ROW = 54;

    reg [15:0] file [0:255];
    assign answer = file[pointer[7:0]];

    integer k;
    task defaults;
        begin
            for (k = 0; k < 256; k = k + 1)
                file[k] <= 0;
            file[8'h00] <= 16'h1801;
            file[8'hFF] <= 16'h1801;
            file[8'h01] <= 54;
            file[8'h02] <= 16;
            file[8'h03] <= 1943;
            file[8'h04] <= 2591;
            file[8'h06] <= 25;
            file[8'h07] <= 16'h1F82;
            file[8'h09] <= 1943;
            file[8'h10] <= 16'h0050;
            file[8'h11] <= 16'h6404;
            file[8'h1E] <= 16'h4006;
            file[8'h20] <= 16'h0040;
            file[8'h2B] <= 8;
            file[8'h2C] <= 8;
            file[8'h2D] <= 8;
            file[8'h2E] <= 8;
            file[8'h35] <= 8;
            file[8'h49] <= 168;
            file[8'h4B] <= 40;
        end
    endtask

    always @(posedge clk) begin
        if (!reset_n)
            defaults;
        else if (write && pointer[7:0] == 8'h0D && value[0]) begin
            defaults;
            file[8'h0D] <= 1;
        end else if (write && pointer[7:0] != 8'h00 && pointer[7:0] != 8'hFF) begin
            file[pointer[7:0]] <= value;
            if ((pointer[7:0] == 8'h22 || pointer[7:0] == 8'h23)
                && (value[2:0] == 7 || value[5:4] == 2 || value[5:4] > value[2:0]))
                $display("SENSOR-ERROR no such skipping and binning");
        end
    end

    // Both modes are written before the start.
    always @(posedge streaming)
        if (file[8'h22] != file[8'h23])
            $display("SENSOR-ERROR rows are skipped as columns are in this model");

    assign streaming = file[8'h07][1] && !file[8'h0D][0];
    assign mirror_rows = file[8'h20][15];
    assign mirror_columns = file[8'h20][14];
    assign left = $signed({1'b0, file[8'h02]}) - FIRST_COLUMN;
    assign top = $signed({1'b0, file[8'h01]}) - FIRST_ROW;
    assign skip = {1'b0, file[8'h23][2:0]} + 1;
    assign binning = {1'b0, file[8'h23][5:4]} + 1;
    wire [5:0] group = 2 * skip;        // of which two are sent
    assign width = 2 * ((file[8'h04] + group) / group);
    assign height = 2 * ((file[8'h03] + group) / group);

    // In pairs of columns. A row that is the mean of others takes the time of all of them.
    wire [31:0] dark = binning == 1 ? 40 : binning == 2 ? 20 : 10;
    wire [31:0] least_blanking = 346 * binning + 64 + dark;
    wire [31:0] blanking = file[8'h05] + 1 > least_blanking ? file[8'h05] + 1 : least_blanking;
    wire [31:0] pairs = width / 2 + blanking;
    wire [31:0] least_pairs = 41 + 346 * binning + 99;
    assign line_clocks = 2 * (pairs > least_pairs ? pairs : least_pairs);

    wire [31:0] given_lines = {12'd0, file[8'h08][3:0], file[8'h09]};
    wire [31:0] lines = given_lines > 1 ? given_lines : 1;
    wire [31:0] beyond = lines > height + 8 ? lines - height : 8;
    wire [31:0] rest = file[8'h06] > beyond ? file[8'h06] : beyond;
    assign frame_lines = height + rest + 1;

    // The overhead, in pairs of columns, of the shutter.
    wire [47:0] open = {16'd0, lines} * {16'd0, line_clocks};
    wire [47:0] overhead = 2 * (208 * {45'd0, binning} + 98 + {32'd0, file[8'h0C]} + 1 - 94);
    assign exposure = open > overhead ? open - overhead : 0;

    wire [31:0] analog_gain = file[8'h35][5:0] * (file[8'h35][6] ? 2 : 1);      // eighths
    assign gain = analog_gain * (8 + file[8'h35][14:8]) * 4;
    assign black = file[8'h49][11:0];

    reg [3:0] known;
    always @*
        case (file[8'hA0][6:3])
            0: known = 1;
            1: known = 2;
            2: known = 3;
            3: known = 4;
            5: known = 5;
            6: known = 6;
            7: known = 7;
            8: known = 8;
            default: known = 0;
        endcase
    assign pattern = file[8'hA0][0] ? known : 0;
    // Green in rows of red, red, blue, green in rows of blue.
    assign colours = {file[8'hA1][11:0], file[8'hA2][11:0], file[8'hA3][11:0], file[8'hA1][11:0]};
endmodule
