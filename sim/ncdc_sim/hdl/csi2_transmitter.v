// CSI-2 transmitter of an image sensor: packets of the frames at sensor.v's pins, on the lanes.
//
// Written from the specifications of CSI-2 and D-PHY, apart from the receiver and from the transmitter
// in Python. A row is sent once it has come: in RAW10, of the upper ten bits of `data`. Before the
// first row of a frame come EMBEDDED packets of embedded data. A row whose samples are no whole group
// of four is sent without its last low bits.
//
// A byte of each lane leaves with each rising edge of `byte_clk`, the lowest bit first; `hs` is high
// while a lane is in high-speed mode, else `lp_p` and `lp_n` are its levels; `valid` from the first byte
// after the sync byte on. The clock lane always runs. `idle` is high while nothing waits to be sent.
//
// Plusargs, decimal:
//   csi2_lane_hz=        bits per second of a lane; 456000000 if absent
//   csi2_bad_checksum=   number of the packet, from 0 on, whose checksum is wrong

`timescale 1ns/1ps

module csi2_transmitter #(
    parameter LANES = 2,
    parameter EMBEDDED = 0
) (
    input  wire                 pixel_clk,
    input  wire                 reset_n,
    input  wire                 frame_valid,
    input  wire                 line_valid,
    input  wire [11:0]          data,
    input  wire                 byte_clk,
    output reg  [8*LANES-1:0]   bytes,
    output reg  [LANES-1:0]     hs,
    output reg  [LANES-1:0]     valid,
    output reg  [LANES-1:0]     lp_p,
    output reg  [LANES-1:0]     lp_n,
    output wire                 idle
);
    localparam [5:0] FRAME_START = 6'h00, FRAME_END = 6'h01, EMBEDDED_DATA = 6'h12, RAW10 = 6'h2B;
    localparam [7:0] SYNC_BYTE = 8'hB8;
    localparam SPACE = 65536, PACKETS = 64, EMBEDDED_BYTES = 20;

    // Packets that wait: type, number or bytes, where its payload begins.
    reg [7:0]  payload [0:SPACE-1];
    reg [5:0]  kinds [0:PACKETS-1];
    reg [15:0] words [0:PACKETS-1], checks [0:PACKETS-1];
    reg [31:0] starts [0:PACKETS-1];
    reg [31:0] written, begun, taken, put;          // bytes, begin of the packet; packets
    reg [15:0] check, frame;
    integer    k;

    function [15:0] crc(input [15:0] sum_before, input [7:0] value);
        integer bit_number;
        begin
            crc = sum_before;
            for (bit_number = 0; bit_number < 8; bit_number = bit_number + 1)
                crc = (crc >> 1) ^ (crc[0] ^ value[bit_number] ? 16'h8408 : 16'h0000);
        end
    endfunction

    // Parity bit of those bits of the header that the specification's table gives for it.
    function [7:0] ecc(input [23:0] header);
        ecc = {2'b00, ^(header & 24'hEFFC00), ^(header & 24'hDF03F0), ^(header & 24'hB8E38E),
               ^(header & 24'h749A6D), ^(header & 24'hF2555B), ^(header & 24'hF12CB7)};
    endfunction

    task add(input [7:0] value);
        begin
            payload[written % SPACE] = value;
            check = crc(check, value);
            written = written + 1;
        end
    endtask

    task push(input [5:0] kind, input [15:0] word);
        begin
            kinds[put % PACKETS] = kind;
            words[put % PACKETS] = word;
            starts[put % PACKETS] = begun;
            checks[put % PACKETS] = put == bad ? ~check : check;
            put = put + 1;
            begun = written;
            check = 16'hFFFF;
            if (put - taken > PACKETS || written - starts[taken % PACKETS] > SPACE) begin
                $display("SENSOR-ERROR the lanes are too slow for the rows");
                $finish;
            end
        end
    endtask

    // Samples of the group that is not complete.
    reg [7:0]  low;
    reg [1:0]  count;
    reg        frame_before, line_before;
    reg [31:0] lane_hz, bad;
    initial begin
        if (!$value$plusargs("csi2_lane_hz=%d", lane_hz)) lane_hz = 456000000;
        if (!$value$plusargs("csi2_bad_checksum=%d", bad)) bad = 32'hFFFFFFFF;
        written = 0; begun = 0; taken = 0; put = 0; check = 16'hFFFF; frame = 0;
        frame_before = 0; line_before = 0; count = 0; low = 0;
        state = IDLE; left = 0; hs = 0; valid = 0; lp_p = ~0; lp_n = ~0;
    end
    wire line = frame_valid && line_valid;
    always @(posedge pixel_clk) begin
        if (!reset_n) begin
            frame_before <= 0;
            line_before <= 0;
            frame = 0;
            put = taken;
            begun = written;
            check = 16'hFFFF;
        end else begin
            frame_before <= frame_valid;
            line_before <= line;
            if (frame_valid && !frame_before) begin
                frame = frame + 1;
                push(FRAME_START, frame);
                repeat (EMBEDDED) begin
                    for (k = 0; k < EMBEDDED_BYTES; k = k + 1)
                        add(8'h0A + k);
                    push(EMBEDDED_DATA, EMBEDDED_BYTES);
                end
            end
            if (line) begin
                add(data[11:4]);
                low = {data[3:2], low[7:2]};
                count = count + 1;
                if (count == 0)
                    add(low);
            end
            if (line_before && !line) begin
                count = 0;
                push(RAW10, written - begun);
            end
            if (frame_before && !frame_valid)
                push(FRAME_END, frame);
        end
    end

    // The lanes. Times: D-PHY, global operation timing parameters, in bytes.
    localparam IDLE = 0, LP01 = 1, LP00 = 2, ZERO = 3, SYNC = 4, SEND = 5, TRAIL = 6;
    function [31:0] clocks(input [31:0] ns);
        clocks = (64'd1 * ns * lane_hz + 64'd7999999999) / 64'd8000000000;
    endfunction
    reg [2:0]       state;
    reg [31:0]      left, sent, total;      // byte clocks; bytes of the packet
    reg [LANES-1:0] last;                   // last bit of each lane
    integer         lane;
    assign idle = state == IDLE && left == 0 && put == taken;

    wire [5:0]  kind = kinds[taken % PACKETS];
    wire [15:0] word = words[taken % PACKETS], sum = checks[taken % PACKETS];
    function [7:0] byte_of(input [31:0] at);
        case (at)
            0: byte_of = {2'b00, kind};
            1: byte_of = word[7:0];
            2: byte_of = word[15:8];
            3: byte_of = ecc({word, 2'b00, kind});
            default: byte_of = at < 4 + {16'd0, word}
                ? payload[(starts[taken % PACKETS] + at - 4) % SPACE]
                : at == 4 + {16'd0, word} ? sum[7:0] : sum[15:8];
        endcase
    endfunction

    task go(input [2:0] to, input [31:0] count_of);
        begin
            state = to;
            left = count_of;
        end
    endtask

    always @(posedge byte_clk) begin
        if (left != 0)
            left = left - 1;
        if (left == 0)
            case (state)
                IDLE: if (put != taken) go(LP01, clocks(50));       // T_LPX
                LP01: go(LP00, clocks(60));                         // T_HS-PREPARE
                LP00: go(ZERO, clocks(130));                        // T_HS-ZERO
                ZERO: go(SYNC, 1);
                SYNC: begin
                    total = kind < 6'h10 ? 4 : 6 + {16'd0, word};
                    sent = 0;
                    go(SEND, (total + LANES - 1) / LANES);
                end
                SEND: begin
                    taken = taken + 1;
                    go(TRAIL, clocks(70) + 1);                      // T_HS-TRAIL
                end
                default: go(IDLE, clocks(100));                     // T_HS-EXIT
            endcase
        for (lane = 0; lane < LANES; lane = lane + 1) begin
            lp_p[lane] <= state == IDLE;
            lp_n[lane] <= state == IDLE || state == LP01;
            hs[lane] <= state >= ZERO;
            valid[lane] <= state >= SEND;
            // The trail is the opposite of the lane's last bit.
            bytes[8*lane +: 8] <= state == SYNC ? SYNC_BYTE
                : state == SEND && sent + lane < total ? byte_of(sent + lane)
                : state == SEND || state == TRAIL ? {8{!last[lane]}} : 8'd0;
            if (state == SEND && sent + lane < total)
                last[lane] = byte_of(sent + lane) >> 7;
        end
        if (state == SEND)
            sent = sent + LANES;
    end
endmodule
