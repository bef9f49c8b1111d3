// Takes the packets of Intel's Video and Image Processing Suite apart again: a control packet, then
// a packet of pixels, of which the pixels leave as one packet. It knows the protocol's rules alone.
//
// A violation prints AVALON-ERROR vip rule time: "latency", a beat that comes though `ready` was low in
// the clock before; "type", a packet that is neither of control nor of pixels; "order", pixels
// without a control packet right before them; "control", one that is not of four beats, progressive,
// and four bits a symbol; "size", pixels that are not as many as it has said; "packet", a packet that
// begins in another, or a beat of none.

`timescale 1ns/1ps

module vip_unpacker (
    input  wire        clk, rst,
    input  wire        in_valid,
    output reg         in_ready,
    input  wire [23:0] in_data,
    input  wire        in_startofpacket, in_endofpacket,
    output wire        valid,
    input  wire        ready,
    output wire [23:0] data,
    output wire        startofpacket, endofpacket
);
    localparam NONE = 0, CONTROL = 1, PIXELS = 2;
    reg         allowed = 0;            // `in_ready` in the clock before
    reg  [1:0]  packet = NONE;          // that is under way
    reg         announced = 0;          // the last packet was one of control
    reg  [2:0]  beat = 0;
    reg  [35:0] control = 0;
    reg  [31:0] pixels = 0, random = 32'h2545F491;
    wire [15:0] width = control[35:20], height = control[19:4];
    wire [35:0] next_control = {control[23:0], in_data[3:0], in_data[11:8], in_data[19:16]};

    // What comes waits here: `in_ready` says one clock in advance that there is space.
    reg  [25:0] queue [0:7];
    reg  [2:0]  first = 0;
    reg  [3:0]  count = 0;
    wire [2:0]  tail = first + count[2:0];
    wire        put = in_valid && packet == PIXELS && !in_startofpacket;
    wire        take = valid && ready;
    assign valid = count != 0;
    assign {startofpacket, endofpacket, data} = queue[first];

    task violation(input [8*8-1:0] rule);
        $display("AVALON-ERROR vip %0s %0t", rule, $time);
    endtask

    always @(posedge clk) begin
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        in_ready <= count < 4 && random[3:0] < 12;
        allowed <= in_ready;
        if (rst) begin
            packet <= NONE;
            announced <= 0;
            count <= 0;
            allowed <= 0;
            in_ready <= 0;
        end else begin
            if (in_valid && !allowed) violation("latency");
            if (in_valid && in_startofpacket) begin
                if (packet != NONE || in_endofpacket) violation("packet");
                beat <= 0;
                pixels <= 0;
                case (in_data[3:0])
                    4'd15: packet <= CONTROL;
                    4'd0: begin
                        packet <= PIXELS;
                        if (!announced) violation("order");
                    end
                    default: violation("type");
                endcase
            end else if (in_valid && packet == CONTROL) begin
                control <= next_control;
                beat <= beat + 1;
                if (in_data & 24'hF0F0F0) violation("control");
                if (in_endofpacket) begin
                    packet <= NONE;
                    announced <= 1;
                    if (beat != 2 || next_control[3:0] != 4'b0011) violation("control");
                end
            end else if (in_valid && packet == PIXELS) begin
                pixels <= pixels + 1;
                if (in_endofpacket) begin
                    packet <= NONE;
                    announced <= 0;
                    if (pixels + 1 != width * height) violation("size");
                end
            end else if (in_valid)
                violation("packet");
            if (put)
                queue[tail] <= {pixels == 0, in_endofpacket, in_data};
            count <= count + put - take;
            if (take)
                first <= first + 1;
        end
    end
endmodule
