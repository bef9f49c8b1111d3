// Registers of the OV5640, and what they mean: raw frames of a window, of all pixels or of every
// other pair of columns and rows. Addresses, defaults and equations: see model/ncdc_spec/sensors/ov5640.py, from which this file shares no
// code.

`timescale 1ns/1ps

module sensor_ov5640 (
`include "sensor_registers.vh"
);
    localparam FIRST_COLUMN = 16, FIRST_ROW = 4;

    // Registers 0x3000 to 0x5FFF.
    reg [7:0] file [0:16'h2FFF];
    wire there = pointer >= 16'h3000 && pointer < 16'h6000;
    wire [13:0] index = pointer[13:0] - 14'h3000;
    assign answer = there ? {8'd0, file[index]} : 0;

    integer k;
    task defaults;
        begin
            for (k = 0; k < 16'h3000; k = k + 1)
                file[k] <= 0;
            file[14'h0008] <= 8'h02;
            file[14'h000A] <= 8'h56;
            file[14'h000B] <= 8'h40;
            file[14'h000E] <= 8'h58;
            file[14'h0805] <= 8'h3F;
            file[14'h0804] <= 8'h0A;
            file[14'h0806] <= 8'h07;
            file[14'h0807] <= 8'h9F;
            file[14'h0808] <= 8'h0A;
            file[14'h0809] <= 8'h20;
            file[14'h080A] <= 8'h07;
            file[14'h080B] <= 8'h98;
            file[14'h080C] <= 8'h0B;
            file[14'h080D] <= 8'h1C;
            file[14'h080E] <= 8'h07;
            file[14'h080F] <= 8'hB0;
            file[14'h0811] <= 8'd16;
            file[14'h0813] <= 8'd4;
            file[14'h0814] <= 8'h11;
            file[14'h0815] <= 8'h11;
            file[14'h1009] <= 8'd16;
            file[14'h1740] <= 8'h20;
        end
    endtask

    always @(posedge clk) begin
        if (!reset_n)
            defaults;
        else if (write && pointer == 16'h3008 && value[7])
            defaults;
        else if (write && there && pointer != 16'h300A && pointer != 16'h300B) begin
            file[index] <= value[7:0];
            if ((pointer == 16'h3814 || pointer == 16'h3815) && value[7:0] != 8'h11
                && value[7:0] != 8'h31)
                $display("SENSOR-ERROR skipping by 1 and 2 is modelled");
        end
    end
    always @(posedge streaming)
        if (file[14'h0814] != file[14'h0815] || file[14'h0820][0] != file[14'h0821][0]
            || (file[14'h0820][0] && skip == 1))
            $display("SENSOR-ERROR rows are skipped and binned as columns are in this model");
    assign skip = file[14'h0814] == 8'h31 ? 2 : 1;
    assign binning = file[14'h0821][0] ? 2 : 1;

    // Outputs enabled, awake, and raw after the correction of defects.
    wire raw = file[14'h1300][7:4] == 0 && file[14'h201F][2:0] == 3;
    assign streaming = !file[14'h0008][6] && raw && file[14'h0017][6:4] == 7;

    wire [15:0] x_start = {file[14'h0800], file[14'h0801]};
    wire [15:0] y_start = {file[14'h0802], file[14'h0803]};
    wire [15:0] x_offset = {file[14'h0810], file[14'h0811]};
    wire [15:0] y_offset = {file[14'h0812], file[14'h0813]};
    // Offsets count samples. The sensor sees through its back; mirrored, reading begins one further.
    assign mirror_columns = !file[14'h0821][1];
    assign mirror_rows = file[14'h0820][1];
    assign left = $signed({1'b0, x_start}) + $signed({1'b0, skip * x_offset}) - FIRST_COLUMN
        + (mirror_columns ? 1 : 0);
    assign top = $signed({1'b0, y_start}) + $signed({1'b0, skip * y_offset}) - FIRST_ROW
        + (mirror_rows ? 1 : 0);
    assign width = {file[14'h0808], file[14'h0809]};
    assign height = {file[14'h080A], file[14'h080B]};
    assign line_clocks = {15'd0, file[14'h080C], file[14'h080D], 1'b0};
    assign frame_lines = {16'd0, file[14'h080E], file[14'h080F]};

    wire [47:0] sixteenths = {28'd0, file[14'h0500][3:0], file[14'h0501], file[14'h0502]};
    assign exposure = (sixteenths * {16'd0, line_clocks}) >> 4;
    assign gain = {18'd0, file[14'h050A][1:0], file[14'h050B], 4'd0};
    assign pattern = file[14'h203D][7] && file[14'h203D][1:0] == 0 ? 8 : 0;
    assign colours = 0;
    assign black = {2'd0, file[14'h1009], 2'b00};
endmodule
