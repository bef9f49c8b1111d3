// First flops of synchronisers that behave as real ones do when their input changes near the edge of
// their clock: each bit takes its old or its new value, at random and on its own.
//
// Plusargs: metastable_ps, the time before and after the edge that is too near; twice that must be
// shorter than the period of the clock with which the input changes, as a bus in Gray code demands
// of its wires, and than that of the flop. 0, the default, makes plain flops. metastable_seed.
//
// A line METASTABLE path count reports the bits that took what a plain flop would not have taken:
// of the 1st, the 2nd, the 4th of them and so on.

`timescale 1ps/1ps

// A bit. NUMBER identifies the bits of a design, so that they do not choose alike.
module metastable_bit #(
    parameter NUMBER = 0
) (
    input wire  clk,
    input wire  i,
    output wire o
);
    reg [31:0] window, seed, random;
    reg [31:0] late_events = 0, early_events = 0;
    reg [63:0] edge_at = 0, changed_at = 0;
    reg        begun = 0;                       // there was an edge: a change before is none
    reg        taken = 0;                       // at the last edge
    reg        early = 0, early_before = 0;     // differ: the value after that edge was taken
    assign o = taken ^ early ^ early_before;

    initial begin
        if (!$value$plusargs("metastable_ps=%d", window)) window = 0;
        if (!$value$plusargs("metastable_seed=%d", seed)) seed = 1;
        random = ((NUMBER + 1) * 32'h9E3779B1 ^ seed * 32'h85EBCA6B) | 32'h100;
    end

    always @(posedge clk) begin
        random <= {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        edge_at <= $time;
        begun <= 1;
        early_before <= early;
        taken <= i;
        if (begun && $time - changed_at < {32'd0, window} && random[3]) begin
            taken <= !i;
            late_events = late_events + 1;
            if ((late_events & (late_events - 1)) == 0)
                $display("METASTABLE %m late %0d", late_events);
        end
    end

    always @(posedge i or negedge i) begin
        changed_at <= $time;
        if (begun && $time - edge_at < {32'd0, window} && random[17]) begin
            early <= !early_before;
            early_events = early_events + 1;
            if ((early_events & (early_events - 1)) == 0)
                $display("METASTABLE %m early %0d", early_events);
        end
    end
endmodule

module metastable_flop #(
    parameter WIDTH = 1,
    parameter NUMBER = 0
) (
    input wire              clk,
    input wire [WIDTH-1:0]  i,
    output wire [WIDTH-1:0] o
);
    genvar k;
    generate
        for (k = 0; k < WIDTH; k = k + 1) begin : bits
            metastable_bit #(.NUMBER(64 * NUMBER + k)) one (.clk(clk), .i(i[k]), .o(o[k]));
        end
    endgenerate
endmodule

// A flop that a reset sets at once, and that an edge clears. The end of a reset near an edge may be
// seen by that edge or by the next one.
module metastable_reset #(
    parameter NUMBER = 0
) (
    input wire  clk,
    input wire  i,
    output wire o
);
    reg [31:0] window, seed, random;
    reg [31:0] late_events = 0, early_events = 0;
    reg [63:0] edge_at = 0, ended_at = 0;
    reg        begun = 0;                       // there was an edge: an end before is none
    reg        set = 1;
    reg        early = 0, early_before = 0;     // differ: the edge before the end has cleared it
    assign o = i || set && early == early_before;

    initial begin
        if (!$value$plusargs("metastable_ps=%d", window)) window = 0;
        if (!$value$plusargs("metastable_seed=%d", seed)) seed = 1;
        random = ((64 * NUMBER + 1) * 32'h9E3779B1 ^ seed * 32'h85EBCA6B) | 32'h100;
    end

    always @(posedge clk) begin
        random <= {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        edge_at <= $time;
        begun <= 1;
    end

    always @(posedge clk or posedge i) begin
        early_before <= early;
        if (i)
            set <= 1;
        else if (begun && $time - ended_at < {32'd0, window} && random[3] && o) begin
            late_events = late_events + 1;
            if ((late_events & (late_events - 1)) == 0)
                $display("METASTABLE %m late %0d", late_events);
        end
        else
            set <= 0;
    end

    always @(negedge i) begin
        ended_at <= $time;
        if (begun && $time - edge_at < {32'd0, window} && random[17]) begin
            early <= !early_before;
            early_events = early_events + 1;
            if ((early_events & (early_events - 1)) == 0)
                $display("METASTABLE %m early %0d", early_events);
        end
    end
endmodule
