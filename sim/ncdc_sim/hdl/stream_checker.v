// Protocol checker of a packet stream (valid, ready, data, startofpacket, endofpacket).
//
// Each violation counts in `errors`; the first 20 print "AVALON-ERROR <port> <rule> <time>":
//   held             once valid, valid and all it qualifies stay until ready
//   packet-start     a packet starts with startofpacket, which appears nowhere else
//   unknown          no X or Z on valid out of reset, nor on what it qualifies (needs four states)

`timescale 1ns/1ps

module stream_checker #(
    parameter NAME = "stream",
    parameter WIDTH = 24
) (
    input  wire             clk,
    input  wire             rst,
    // The source is being reset. A packet may break off then, and, as the source's reset may come
    // from a register, a clock later.
    input  wire             host_rst,
    input  wire             valid,
    input  wire             ready,
    input  wire [WIDTH-1:0] data,
    input  wire             startofpacket,
    input  wire             endofpacket,
    output reg  [31:0]      errors,
    output reg  [31:0]      beats,
    output reg  [31:0]      packets,
    output reg  [31:0]      waits
);
    reg             was_waiting;
    reg [WIDTH+1:0] was_payload;
    reg             in_packet;
    reg             host_rst_before;
    wire            breaking = host_rst || host_rst_before;

    task violation(input [8*16-1:0] rule);
        begin
            if (errors < 20)
                $display("AVALON-ERROR %0s %0s %0t", NAME, rule, $time);
            errors = errors + 1;
        end
    endtask

    always @(posedge clk) begin
        if (rst) begin
            errors = 0;
            beats = 0;
            packets = 0;
            waits = 0;
            was_waiting = 0;
            in_packet = 0;
            host_rst_before = 0;
        end else begin
            if (^valid === 1'bx)
                violation("unknown");
            if (was_waiting && (!valid || {startofpacket, endofpacket, data} !== was_payload))
                violation("held");
            if (valid && !was_waiting) begin
                if (^{startofpacket, endofpacket, data} === 1'bx)
                    violation("unknown");
                if (startofpacket == in_packet && !breaking)
                    violation("packet-start");
            end
            if (valid && ready) begin
                beats = beats + 1;
                in_packet = !endofpacket;
                if (endofpacket)
                    packets = packets + 1;
            end
            if (valid && !ready)
                waits = waits + 1;
            if (breaking)
                in_packet = 0;
            was_waiting = valid && !ready && !breaking;
            was_payload = {startofpacket, endofpacket, data};
            host_rst_before = host_rst;
        end
    end
endmodule
