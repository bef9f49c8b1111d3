// A PHY and a receiver between the wires of a sensor with CSI-2, whose frames are known, and a file.
//
// Sample x of row y of frame n is 37 x + 91 y + 17 n modulo 1024. Each clock in which the receiver gives
// something is a line "STREAM valid first last end bad sample0 sample1".
//
// Plusargs: those of csi2_pins.v and csi2_transmitter.v; frames, how many are sent.

`timescale 1ps/1ps

module csi2_phy_bench;
    localparam WIDTH = 32, HEIGHT = 6, LINE = 400, LINES = 8;   // samples, rows, clocks, lines

    reg clk = 0, rst = 1, pixel_clk = 0;
    always #8000 clk = !clk;
    always #5000 pixel_clk = !pixel_clk;
    initial #100000 rst = 0;

    integer frames, number = 0, line = 0, x = 0;
    initial if (!$value$plusargs("frames=%d", frames)) frames = 10;
    reg frame_valid = 0, line_valid = 0;
    reg [11:0] data = 0;
    always @(posedge pixel_clk) begin
        x = x + 1;
        if (x == LINE) begin
            x = 0;
            line = line + 1;
        end
        if (line == LINES) begin
            line = 0;
            number = number + 1;
        end
        frame_valid <= line < HEIGHT;
        line_valid <= line < HEIGHT && x >= 4 && x < 4 + WIDTH;
        data <= {10'd37 * (x - 4) + 10'd91 * line + 10'd17 * number, 2'b00};
        if (number == frames) begin
            $display("RESULT ready %0d", ready);
            $display("RESULT failures %0d", failures);
            $display("RESULT step0 %0d", eyes0[7:0]);
            $display("RESULT width0 %0d", eyes0[15:8]);
            $display("RESULT step1 %0d", eyes1[7:0]);
            $display("RESULT width1 %0d", eyes1[15:8]);
            $finish;
        end
    end

    wire [15:0] bytes;
    wire [1:0]  hs, lp_p, lp_n, pairs, low_power;
    wire        byte_clk, pair, idle;
    csi2_transmitter #(.LANES(2), .EMBEDDED(2)) sensor (
        .pixel_clk(pixel_clk), .reset_n(!rst), .frame_valid(frame_valid), .line_valid(line_valid),
        .data(data), .byte_clk(byte_clk), .bytes(bytes), .hs(hs), .valid(), .lp_p(lp_p), .lp_n(lp_n),
        .idle(idle));
    csi2_pins #(.LANES(2)) wires (
        .byte_clk(byte_clk), .bytes(bytes), .hs(hs), .lp_n(lp_n), .pair(pair), .pairs(pairs),
        .low_power(low_power));

    wire        clock, ready, first, last, ends, bad;
    wire [1:0]  valid;
    wire [11:0] sample0, sample1;
    wire [15:0] eyes0, eyes1;
    wire [7:0]  failures;
    phy_receiver dut (
        .clk(clk), .rst(rst), .pair(pair), .pairs(pairs), .low_power(low_power), .clock(clock),
        .ready(ready), .failures(failures), .eyes__0(eyes0), .eyes__1(eyes1), .o__valid(valid),
        .o__first(first), .o__last(last), .o__end(ends), .o__bad(bad),
        .o__sample({sample1, sample0}));
    always @(posedge clock)
        if (valid != 0 || ends)
            $display("STREAM %0d %0d %0d %0d %0d %0d %0d", valid, first, last, ends, bad, sample0, sample1);
endmodule
