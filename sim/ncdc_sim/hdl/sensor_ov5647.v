// Registers of the OV5647, and what they mean: RAW10 frames of a window, of all pixels or binned by 2.
// Addresses and equations: see model/ncdc_spec/sensors/ov5647.py, from which this file shares no code.

`timescale 1ns/1ps

module sensor_ov5647 (
`include "sensor_registers.vh"
);
    localparam FIRST_COLUMN = 16, FIRST_ROW = 6;    // active pixels
    localparam [11:0] BLACK = 12'd64;

    // Registers 0x3000 to 0x3FFF, and those elsewhere that mean something.
    reg [7:0] file [0:16'h0FFF];
    reg       runs;
    reg [7:0] pattern_word, lanes_control, frames_off;
    wire there = pointer[15:12] == 4'h3;
    assign answer = there ? {8'd0, file[pointer[11:0]]} : pointer == 16'h0100 ? {15'd0, runs} : 0;

    integer k;
    task defaults;
        begin
            for (k = 0; k < 16'h1000; k = k + 1)
                file[k] <= 0;
            file[12'h00A] <= 8'h56;
            file[12'h00B] <= 8'h47;
            runs <= 0;
            pattern_word <= 0;
            lanes_control <= 8'h25;
            frames_off <= 0;
        end
    endtask

    always @(posedge clk)
        if (!reset_n || (write && pointer == 16'h0103 && value[0]))
            defaults;
        else if (write && there && pointer != 16'h300A && pointer != 16'h300B)
            file[pointer[11:0]] <= value[7:0];
        else if (write)
            case (pointer)
                16'h0100: runs <= value[0];
                16'h4202: frames_off <= value[7:0];
                16'h4800: lanes_control <= value[7:0];
                16'h503D: pattern_word <= value[7:0];
                default: ;
            endcase

    wire [15:0] x_start = {file[12'h800], file[12'h801]}, y_start = {file[12'h802], file[12'h803]};
    wire [15:0] x_end = {file[12'h804], file[12'h805]}, y_end = {file[12'h806], file[12'h807]};
    wire [15:0] x_offset = {file[12'h810], file[12'h811]}, y_offset = {file[12'h812], file[12'h813]};
    wire reduced = file[12'h814] == 8'h31;

    assign streaming = runs && frames_off == 0 && !lanes_control[0];
    // The sensor mirrors by itself.
    assign mirror_columns = !file[12'h821][1];
    assign mirror_rows = file[12'h820][1];
    assign skip = reduced ? 2 : 1;
    assign binning = file[12'h821][0] ? 2 : 1;
    assign left = $signed({1'b0, x_start}) + $signed({1'b0, skip * x_offset}) - FIRST_COLUMN;
    assign top = $signed({1'b0, y_start}) + $signed({1'b0, skip * y_offset}) - FIRST_ROW;
    assign width = {file[12'h808], file[12'h809]};
    assign height = {file[12'h80A], file[12'h80B]};
    assign line_clocks = {16'd0, file[12'h80C], file[12'h80D]};
    assign frame_lines = {16'd0, file[12'h80E], file[12'h80F]};
    wire [47:0] sixteenths = {28'd0, file[12'h500][3:0], file[12'h501], file[12'h502]};
    assign exposure = (sixteenths * {16'd0, line_clocks}) >> 4;
    assign gain = {18'd0, file[12'h50A][1:0], file[12'h50B], 4'd0};
    assign pattern = pattern_word[7] && pattern_word[1:0] == 0 ? 8 : 0;
    assign colours = 0;
    assign black = BLACK;

    always @(posedge streaming) begin
        if (file[12'h815] != file[12'h814] || (reduced != file[12'h821][0])
            || file[12'h820][0] != file[12'h821][0] || file[12'h820][6] != file[12'h821][0])
            $display("SENSOR-ERROR rows are binned as columns are in this model");
        if ({16'd0, x_end} + 1 - x_start < {16'd0, skip * (width + x_offset)}
            || {16'd0, y_end} + 1 - y_start < {16'd0, skip * (height + y_offset)})
            $display("SENSOR-ERROR the frame is larger than what is read");
        if (file[12'h018] != 8'h44 || file[12'h034] != 8'h1A || file[12'h00D] != 0)
            $display("SENSOR-ERROR two lanes of RAW10 are modelled");
    end
endmodule
