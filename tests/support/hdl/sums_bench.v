// Sums of colours, compared with sums that the bench makes itself, in each clock.
//
// A frame has random pixels, of which some are not counted; later ones are nearly white, so that the
// sums reach their highest bits. Plusargs: clocks (of all
// frames), frame (clocks of each but the first ones, which are short).

module sums_bench (input wire clk);
    localparam LATENCY = 3;
    reg         start = 0, counts = 0;
    reg  [23:0] pixel = 0;
    wire [127:0] sums;
    reg  [127:0] expected [0:LATENCY];
    reg  [31:0] random = 32'h2545F491;
    reg  [7:0]  light;
    integer     clocks = 0, limit, frame, at = 0, k;
    reg         begins;

    initial begin
        if (!$value$plusargs("clocks=%d", limit)) limit = 0;
        if (!$value$plusargs("frame=%d", frame)) frame = 0;
        for (k = 0; k <= LATENCY; k = k + 1) expected[k] = 0;
    end

    sums dut (.clk(clk), .rst(1'b0), .start(start), .counts(counts), .i(pixel), .sums(sums));

    always @(posedge clk) begin
        // The sums of `expected[0]` have the pixel that the inputs hold now.
        for (k = LATENCY; k > 0; k = k - 1) expected[k] = expected[k - 1];
        if (counts) begin
            expected[0][31:0]   = expected[0][31:0] + pixel[7:0];
            expected[0][63:32]  = expected[0][63:32] + pixel[15:8];
            expected[0][95:64]  = expected[0][95:64] + pixel[23:16];
            expected[0][127:96] = expected[0][127:96] + 1;
        end
        if (start) begin       // its clock is a clock shorter than a pixel's
            expected[0] = 0;
            expected[1] = 0;
        end
        if (clocks > LATENCY && sums !== expected[LATENCY]) begin
            $display("FAILED clock %0d: %h instead of %h", clocks, sums, expected[LATENCY]);
            $finish;
        end
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        light = clocks < 4096 ? 8'h00 : 8'hF8;
        begins = at == 0;
        start <= begins;
        counts <= !begins && (clocks >= 4096 || random[31]);
        pixel <= random[23:0] | {light, light, light};
        at = at + 1 == frame || (clocks < 4096 && random[30:23] == 0) ? 0 : at + 1;
        clocks = clocks + 1;
        if (clocks == limit) begin
            $display("RESULT total_clocks %0d", clocks);
            $display("RESULT sums %h", sums);
            $finish;
        end
    end
endmodule
