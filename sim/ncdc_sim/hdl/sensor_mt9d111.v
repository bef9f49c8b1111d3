// Registers of the MT9D111, and what they mean: the sensor core, page 0, in context B, with the
// image processor bypassed. Addresses, defaults and equations: see
// model/ncdc_spec/sensors/mt9d111.py, from which this file shares no code.

`timescale 1ns/1ps

module sensor_mt9d111 (
`include "sensor_registers.vh"
);
    localparam FIRST_COLUMN = 60, FIRST_ROW = 28;
    localparam PAGE = 8'hF0;

    reg [15:0] file [0:255];            // page 0
    reg [15:0] processor [0:511];       // pages 1 and 2
    wire [15:0] page = file[PAGE];
    wire [8:0]  index = {page[1], pointer[7:0]};
    assign answer = page == 0 || pointer[7:0] == PAGE ? file[pointer[7:0]] : processor[index];

    integer k;
    task defaults;
        begin
            for (k = 0; k < 256; k = k + 1)
                file[k] <= 0;
            file[8'h00] <= 16'h1519;
            file[8'h01] <= 28;
            file[8'h02] <= 60;
            file[8'h03] <= 1200;
            file[8'h04] <= 1600;
            file[8'h05] <= 16'h0204;
            file[8'h06] <= 16'h002F;
            file[8'h07] <= 16'h00FE;
            file[8'h08] <= 16'h000C;
            file[8'h09] <= 16'h04D0;
            file[8'h0A] <= 1;
            file[8'h20] <= 16'h0300;
            file[8'h21] <= 16'h8400;
            file[8'h22] <= 16'h010F;
            file[8'h2B] <= 32;
            file[8'h2C] <= 32;
            file[8'h2D] <= 32;
            file[8'h2E] <= 32;
            file[8'h2F] <= 32;
            file[8'h30] <= 16'h042A;
            file[8'h65] <= 16'hE000;
        end
    endtask

    always @(posedge clk) begin
        if (!reset_n) begin
            defaults;
            for (k = 0; k < 512; k = k + 1)
                processor[k] <= 0;
            processor[8'h09] <= 2;      // the image processor's samples
        end else if (write && page != 0 && pointer[7:0] != PAGE)
            processor[index] <= value;
        else if (write && pointer[7:0] == 8'h0D && value[0]) begin
            defaults;
            file[8'h0D] <= 1;
        end else if (write && pointer[7:0] != 8'h00)
            file[pointer[7:0]] <= value;
    end

    // Without the bypass and context B samples are of another kind, which is not modelled.
    wire raw = processor[8'h09][1:0] == 0 && processor[8'hC3][0] && file[8'hF2][3]
        && file[8'hF2][1:0] == 2'b11;
    reg was_idle;
    always @(posedge clk) begin
        was_idle <= !reset_n || file[8'h0D][0] || file[8'h0D][2];
        if (was_idle && reset_n && file[8'h0D][2:0] == 0 && !raw && file[8'hF2] != 0)
            $display("SENSOR-ERROR only raw frames in context B are modelled");
    end
    assign streaming = !file[8'h0D][0] && !file[8'h0D][2] && raw;

    wire [15:0] mode = file[8'h20];
    assign mirror_rows = mode[0];
    assign mirror_columns = mode[1];
    wire [15:0] border = mode[9] && mode[8] ? 8 : 0;
    // Mirrored, reading begins one further, which keeps the first colour.
    assign left = $signed({1'b0, file[8'h02]}) - FIRST_COLUMN - (border != 0 ? 4 : 0)
        + (mirror_columns ? 1 : 0);
    assign top = $signed({1'b0, file[8'h01]}) - FIRST_ROW - (border != 0 ? 4 : 0)
        + (mirror_rows ? 1 : 0);
    // Of both by 2 or of none; else columns and rows would not be alike.
    assign skip = mode[7:2] == 6'b100100 ? 2 : 1;
    assign binning = 1;
    assign width = file[8'h04] / skip + border;
    assign height = file[8'h03] / skip + border;
    always @(posedge streaming)
        if (mode[15] || (mode[7:2] != 6'b100100 && (mode[7] || mode[4])))
            $display("SENSOR-ERROR skipping by 2 is modelled, of columns and rows");
    assign line_clocks = {16'd0, width} + {16'd0, file[8'h05]};

    wire [31:0] lines = file[8'h09] != 0 ? {16'd0, file[8'h09]} : 1;
    wire [31:0] given = {16'd0, height} + {16'd0, file[8'h06]};
    assign frame_lines = lines > given ? lines : given;
    wire [47:0] open = {16'd0, lines} * {16'd0, line_clocks};
    wire [47:0] closed = 260 + {32'd0, file[8'h0C]};
    assign exposure = open > closed ? open - closed : 0;

    wire [11:0] parts = file[8'h2F][11:0];
    wire [2:0] doublings = {2'd0, parts[7]} + {2'd0, parts[8]} + {2'd0, parts[9]}
        + {2'd0, parts[10]} + {2'd0, parts[11]};
    assign gain = {22'd0, parts[6:0], 3'd0} << doublings;
    assign pattern = 0;
    assign colours = 0;
    assign black = {file[8'h30][9:0], 2'b00};
endmodule
