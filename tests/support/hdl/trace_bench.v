// Components with the inputs of a file, whose outputs are compared with those in it.
//
// trace.bin: for each clock the inputs, the outputs, and a mask of the outputs that mean something,
// each as a number of whole bytes, the highest byte first.
//
// Prints "FAILED" at the first difference, else the number of clocks and a hash of all outputs that
// mean something.
//
// Inputs change at the falling edge: one of them may be a clock, which then rises after the outputs
// of clk's registers have settled, as in Amaranth's simulator.
//
// Defines: NCDC_TOP: the module; NCDC_INPUTS, NCDC_OUTPUTS: their bits; NCDC_CONNECTIONS: the ports.

module trace_bench (input wire clk);
    localparam IN = (`NCDC_INPUTS + 7) / 8 * 8, OUT = (`NCDC_OUTPUTS + 7) / 8 * 8;
    reg  [IN-1:0]             in, next_in;
    reg  [OUT-1:0]            expected, mask;
    wire [`NCDC_OUTPUTS-1:0]  out;
    wire [OUT-1:0]            found = {{(OUT - `NCDC_OUTPUTS){1'b0}}, out} & mask;
    reg  [31:0]               clocks = 0;
    reg  [63:0]               hash = 0;
    integer                   file, got, k;
    initial begin
        file = $fopen("trace.bin", "rb");
        got = $fread(in, file);
        next_in = in;
        got = $fread(expected, file);
        got = $fread(mask, file);
    end

    `NCDC_TOP dut (.clk(clk), .rst(1'b0), `NCDC_CONNECTIONS);

    always @(posedge clk) begin
        if (found != (expected & mask)) begin
            $display("FAILED clock %0d: %h instead of %h", clocks, found, expected & mask);
            $finish;
        end
        for (k = 0; k < OUT; k = k + 8) hash = (hash ^ found[k +: 8]) * 64'h9E3779B97F4A7C15;
        clocks = clocks + 1;
        got = $fread(next_in, file);
        if (got == 0) begin
            $display("RESULT total_clocks %0d", clocks);
            $display("RESULT outputs %h", hash);
            $finish;
        end
        got = $fread(expected, file);
        got = $fread(mask, file);
    end

    always @(negedge clk) in <= next_in;
endmodule
