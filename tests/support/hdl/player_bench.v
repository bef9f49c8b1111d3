// A component between inputs from a file and a consumer of its stream `o` that stalls at random.
//
// inputs.txt: lines of three hexadecimal numbers: the inputs; clocks for which they stay; whether
// they stay longer, until `quiet` has been high for a clock. A line of zero clocks ends the run.
//
// Prints "OUT clock payload" for each item taken, and "FLAGS clock value" when the flags
// change.
//
// Defines: NCDC_INPUTS, NCDC_PAYLOAD, NCDC_FLAGS: their bits; NCDC_QUIET: the bit of `quiet` among
// the flags; NCDC_SHOWN: the payload without what means nothing; NCDC_CONNECTIONS: the ports.

module player_bench (input wire clk);
    reg  [`NCDC_INPUTS-1:0]  in = 0, next_in;
    wire [`NCDC_PAYLOAD-1:0] payload;
    wire [`NCDC_PAYLOAD-1:0] shown = `NCDC_SHOWN;
    wire [`NCDC_FLAGS-1:0]   flags;
    reg  [`NCDC_FLAGS-1:0]   seen = 0;
    wire                     valid;
    wire                     quiet = flags[`NCDC_QUIET];
    reg                      rst = 1, ready = 0, until_quiet = 0, was_quiet = 0;
    reg  [31:0]              clocks = 0, left = 16, limit, stall, lfsr = 32'h1234567;
    integer                  file, got;
    initial begin
        if (!$value$plusargs("clock_limit=%d", limit)) limit = 0;
        if (!$value$plusargs("stall=%d", stall)) stall = 0;
        file = $fopen("inputs.txt", "r");
    end

    dut dut (.clk(clk), .rst(rst), .o__ready(ready), .o__valid(valid), .o__payload(payload),
             `NCDC_CONNECTIONS);

    always @(posedge clk) begin
        clocks = clocks + 1;
        if (valid && ready && !rst) $display("OUT %0d %h", clocks, shown);
        if (flags != seen) $display("FLAGS %0d %h", clocks, flags);
        seen = flags;
        lfsr = {lfsr[30:0], lfsr[31] ^ lfsr[21] ^ lfsr[1] ^ lfsr[0]};
        ready <= lfsr[7:0] >= stall[7:0];
        left = left - (left != 0);
        if (left == 0 && (!until_quiet || was_quiet)) begin
            rst <= 0;
            got = $fscanf(file, "%h %h %h", next_in, left, until_quiet);
            in <= next_in;
            if (got != 3 || left == 0) begin
                $display("RESULT total_clocks %0d", clocks);
                $finish;
            end
        end
        was_quiet = quiet;
        if (clocks == limit) begin
            $display("FAILED the clocks are used up");
            $finish;
        end
    end
endmodule
