// A vendor's camera core: a parallel sensor's samples as a stream of video, COUNT in a beat, the first
// one lowest. With PACKETS the frames are packets of Intel's Video and Image Processing Suite, each
// after a control packet; otherwise `first` and `last` are those of a frame. It knows the
// protocols' rules and the size of the sensor's frames alone.
//
// A violation prints AVALON-ERROR video queue time: the sink took the beats too slowly.

`timescale 1ns/1ps

module video_camera #(
    parameter COUNT = 1, BITS = 12, PACKETS = 0, WIDTH = 64, HEIGHT = 24
) (
    input  wire        clock, frame_valid, line_valid,
    input  wire [11:0] data,
    output reg         valid,
    input  wire        ready,
    output reg  [COUNT*BITS-1:0] beat,
    output reg         first, row_end, last
);
    reg  [COUNT*BITS+2:0] queue [0:2047];
    reg  [10:0]           head = 0, tail = 0;
    reg  [COUNT*BITS-1:0] gathered = 0;
    reg  [35:0]           control;
    reg  [31:0]           random = 32'h1234567;
    reg                   held;
    integer               x = 0, y = 0, k;

    initial valid = 0;

    task put(input is_first, ends_row, is_last, input [COUNT*BITS-1:0] symbols);
        begin
            queue[tail] = {is_first, ends_row, is_last, symbols};
            tail = tail + 1;
            if (tail == head) $display("AVALON-ERROR video queue %0t", $time);
        end
    endtask

    // The control packet of 9 symbols of four bits, the upper ones first; then the frame's type.
    task header;
        begin
            control = {WIDTH[15:0], HEIGHT[15:0], 4'b0011};
            put(1, 0, 0, 15);
            gathered = 0;
            for (k = 0; k < 9; k = k + 1) begin
                gathered[k % COUNT * BITS +: 4] = control[35 - 4 * k -: 4];
                if (k % COUNT == COUNT - 1 || k == 8) begin
                    put(0, 0, k == 8, gathered);
                    gathered = 0;
                end
            end
            put(1, 0, 0, 0);
        end
    endtask

    always @(posedge clock) begin
        held = valid && !ready;             // a beat that is offered stays
        if (valid && ready) head = head + 1;
        random = {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        if (!frame_valid) begin
            x = 0;
            y = 0;
        end else if (line_valid) begin
            if (PACKETS != 0 && x == 0 && y == 0) header;
            gathered[x % COUNT * BITS +: BITS] =
                BITS > 12 ? data << (BITS - 12) : data >> (12 - BITS);
            x = x + 1;
            if (x % COUNT == 0) begin
                put(PACKETS == 0 && x == COUNT && y == 0, x == WIDTH,
                    x == WIDTH && y == HEIGHT - 1, gathered);
                gathered = 0;
            end
            if (x == WIDTH) begin
                x = 0;
                y = y + 1;
            end
        end
        valid <= head != tail && (held || random[1:0] != 0);
        {first, row_end, last, beat} <= queue[head];
    end
endmodule
