// Registers of the OV5647, and what they mean: RAW10 frames of a window, of all pixels or binned by 2.
// Addresses and equations: see model/ncdc_spec/sensors/ov5647.py, from which this file shares no code.

`timescale 1ns/1ps

module sensor_ov5647 (
`include "sensor_registers.vh"
);
    localparam FIRST_COLUMN = 16, FIRST_ROW = 6;    // active pixels
    localparam [11:0] BLACK = 12'd64;

    // Registers 0x3000 to 0x5FFF, and one below.
    reg [7:0] file [0:16'h2FFF];
    reg       runs;
    reg       cleared = 0;              // once for each reset: there are many
    wire there = pointer >= 16'h3000 && pointer < 16'h6000;
    wire [13:0] index = pointer[13:0] - 14'h3000;
    assign answer = there ? {8'd0, file[index]} : pointer == 16'h0100 ? {15'd0, runs} : 0;

    integer k;
    task defaults;
        begin
            for (k = 0; k < 16'h3000; k = k + 1)
                file[k] <= 0;
            file[14'h000A] <= 8'h56;
            file[14'h000B] <= 8'h47;
            file[14'h1800] <= 8'h25;
            runs <= 0;
        end
    endtask

    always @(posedge clk) begin
        cleared <= !reset_n;
        if (!reset_n) begin
            if (!cleared)
                defaults;
        end else if (write && pointer == 16'h0103 && value[0])
            defaults;
        else if (write && pointer == 16'h0100)
            runs <= value[0];
        else if (write && there && pointer != 16'h300A && pointer != 16'h300B)
            file[index] <= value[7:0];
    end

    wire [15:0] x_start = {file[14'h0800], file[14'h0801]}, y_start = {file[14'h0802], file[14'h0803]};
    wire [15:0] x_end = {file[14'h0804], file[14'h0805]}, y_end = {file[14'h0806], file[14'h0807]};
    wire [15:0] x_offset = {file[14'h0810], file[14'h0811]}, y_offset = {file[14'h0812], file[14'h0813]};
    wire reduced = file[14'h0814] == 8'h31;

    assign streaming = runs && file[14'h1202] == 0 && !file[14'h1800][0];
    // The sensor mirrors by itself.
    assign mirror_columns = !file[14'h0821][1];
    assign mirror_rows = file[14'h0820][1];
    assign skip = reduced ? 2 : 1;
    assign binning = file[14'h0821][0] ? 2 : 1;
    assign left = $signed({1'b0, x_start}) + $signed({1'b0, skip * x_offset}) - FIRST_COLUMN;
    assign top = $signed({1'b0, y_start}) + $signed({1'b0, skip * y_offset}) - FIRST_ROW;
    assign width = {file[14'h0808], file[14'h0809]};
    assign height = {file[14'h080A], file[14'h080B]};
    assign line_clocks = {16'd0, file[14'h080C], file[14'h080D]};
    assign frame_lines = {16'd0, file[14'h080E], file[14'h080F]};
    wire [47:0] sixteenths = {28'd0, file[14'h0500][3:0], file[14'h0501], file[14'h0502]};
    assign exposure = (sixteenths * {16'd0, line_clocks}) >> 4;
    assign gain = {18'd0, file[14'h050A][1:0], file[14'h050B], 4'd0};
    assign pattern = file[14'h203D][7] && file[14'h203D][1:0] == 0 ? 8 : 0;
    assign colours = 0;
    assign black = BLACK;

    always @(posedge streaming) begin
        if (file[14'h0815] != file[14'h0814] || (reduced != file[14'h0821][0])
            || file[14'h0820][0] != file[14'h0821][0] || file[14'h0820][6] != file[14'h0821][0])
            $display("SENSOR-ERROR rows are binned as columns are in this model");
        if ({16'd0, x_end} + 1 - x_start < {16'd0, skip * (width + x_offset)}
            || {16'd0, y_end} + 1 - y_start < {16'd0, skip * (height + y_offset)})
            $display("SENSOR-ERROR the frame is larger than what is read");
        if (file[14'h0018] != 8'h44 || file[14'h0034] != 8'h1A || file[14'h000D] != 0)
            $display("SENSOR-ERROR two lanes of RAW10 are modelled");
    end
endmodule
