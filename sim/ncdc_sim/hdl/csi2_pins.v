// The lanes of csi2_transmitter.v as wires: bits with skew and jitter, a clock in their middle.
//
// A lane in low-power mode has no difference between its wires: its comparator gives random bits.
//
// Plusargs, decimal:
//   csi2_lane_hz=        as of csi2_transmitter.v
//   csi2_skew_ps0=, csi2_skew_ps1=       by which the lane is late, less than a bit; 0 if absent
//   csi2_jitter_ps=      most by which an edge is late, at random, less than a bit; 0 if
//                        absent
//   csi2_clock_us=       when the clock lane starts; 0 if absent

`timescale 1ps/1ps

module csi2_pins #(parameter LANES = 2) (
    output reg                byte_clk,
    input  wire [8*LANES-1:0] bytes,
    input  wire [LANES-1:0]   hs,
    input  wire [LANES-1:0]   lp_n,
    output reg                pair,
    output wire [LANES-1:0]   pairs,
    output reg  [LANES-1:0]   low_power
);
    reg [63:0] lane_hz, clock_us;
    reg [31:0] skew [0:3];
    reg [31:0] jitter;
    real       bit_ps, start;
    integer    lane, number, sent;
    reg [8*LANES-1:0] now;
    reg [LANES-1:0]   now_hs;

    // Registers of its own for each lane, and for each delay: Verilator delays a single change of one at
    // a time.
    reg [LANES-1:0]   bits;
    reg               change;
    genvar k;
    generate for (k = 0; k < LANES; k = k + 1) begin : lanes
        reg skewed = 0, jittered = 0;
        always @(change) skewed <= #(skew[k]) bits[k];
        always @(skewed) jittered <= #(late(0)) skewed;
        assign pairs[k] = jittered;
    end endgenerate

    function [31:0] late(input [31:0] fixed);
        late = fixed + (jitter == 0 ? 0 : $urandom % jitter);
    endfunction

    initial begin
        if (!$value$plusargs("csi2_lane_hz=%d", lane_hz)) lane_hz = 456000000;
        for (lane = 0; lane < 4; lane = lane + 1) skew[lane] = 0;
        if (!$value$plusargs("csi2_skew_ps0=%d", skew[0])) skew[0] = 0;
        if (!$value$plusargs("csi2_skew_ps1=%d", skew[1])) skew[1] = 0;
        if (!$value$plusargs("csi2_jitter_ps=%d", jitter)) jitter = 0;
        if (!$value$plusargs("csi2_clock_us=%d", clock_us)) clock_us = 0;
        bit_ps = 1e12 / lane_hz;
        byte_clk = 0; pair = 0; bits = 0; change = 0; low_power = ~0; sent = 0;
        start = 1;
    end

    always begin
        #(start + sent * bit_ps - $realtime);
        number = sent % 8;
        if (number == 0) begin
            now = bytes;
            now_hs = hs;
            low_power <= lp_n;
            byte_clk <= 1;
        end
        if (number == 4)
            byte_clk <= 0;
        for (lane = 0; lane < LANES; lane = lane + 1)
            bits[lane] = now_hs[lane] ? now[8*lane + number] : $random;
        change = !change;
        if ($realtime >= clock_us * 1000000)
            pair <= #(late($rtoi(bit_ps / 2))) !pair;
        sent = sent + 1;
    end
endmodule
