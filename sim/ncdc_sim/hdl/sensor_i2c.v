// I2C target of an image sensor: registers at a pointer of one or two bytes, each of one or
// two bytes, the upper one first.
//
// A write takes effect with its last shift; the pointer moves on after each register, written or
// read. `write` is high for one clock with `pointer` and `value`; `answer` is what a read of
// `pointer` gives. Faults (see sensor.v): `nack` does not acknowledge its address; `stuck_sda`
// pulls SDA low after its address, for so many clocks of SCL, as a target does that was left in
// the middle of a byte.

`timescale 1ns/1ps

module sensor_i2c #(
    parameter [6:0] ADDRESS = 0,
    parameter WIDE_POINTER = 0,         // 1: two bytes
    parameter WIDE_VALUE = 0            // 1: two bytes
) (
    input  wire        clk,
    input  wire        reset_n,
    input  wire        scl,
    input  wire        sda,
    output reg         sda_low,
    output reg         write,
    output reg  [15:0] pointer,
    output reg  [15:0] value,
    input  wire [15:0] answer
);
    localparam IDLE = 0, SELECT = 1, POINT = 2, TAKE = 3, GIVE = 4, STUCK = 5;

    reg [8*16-1:0] fault;
    reg [31:0]     fault_start, fault_clocks;
    initial begin
        if (!$value$plusargs("sensor_fault=%s", fault)) fault = 0;
        if (!$value$plusargs("sensor_fault_start=%d", fault_start)) fault_start = 0;
        if (!$value$plusargs("sensor_fault_clocks=%d", fault_clocks)) fault_clocks = 9;
    end

    reg [2:0]  state;
    reg        scl_was, sda_was;
    reg [3:0]  bits;                    // of the byte and its acknowledge that have come
    reg [7:0]  shift;                   // a byte that comes or goes
    reg        upper;                   // the byte is the upper one of two
    reg        nack;                    // the controller did not acknowledge
    reg        moves;                    // the pointer moves on
    reg [31:0] starts;
    reg [31:0] left;                    // clocks of SCL for which SDA stays stuck

    wire [7:0] given = upper ? answer[15:8] : answer[7:0];

    // After the last bit of a byte that came: its meaning, and whether it is acknowledged.
    task take;
        begin
            sda_low <= 1;
            case (state)
                SELECT:
                    if (shift[7:1] != ADDRESS || (fault == "nack" && starts == fault_start + 1)) begin
                        state <= IDLE;
                        sda_low <= 0;
                    end else if (fault == "stuck_sda" && starts == fault_start + 1) begin
                        state <= STUCK;
                        left <= fault_clocks;
                    end else if (shift[0]) begin
                        state <= GIVE;
                        upper <= WIDE_VALUE;
                    end else begin
                        state <= POINT;
                        upper <= WIDE_POINTER;
                    end
                POINT: begin
                    if (upper) begin
                        pointer[15:8] <= shift;
                        upper <= 0;
                    end else begin
                        pointer <= WIDE_POINTER ? {pointer[15:8], shift} : {8'd0, shift};
                        state <= TAKE;
                        upper <= WIDE_VALUE;
                    end
                end
                default: begin          // TAKE
                    if (upper) begin
                        value[15:8] <= shift;
                        upper <= 0;
                    end else begin
                        value <= WIDE_VALUE ? {value[15:8], shift} : {8'd0, shift};
                        write <= 1;
                        moves <= 1;
                        upper <= WIDE_VALUE;
                    end
                end
            endcase
        end
    endtask

    task rise;
        begin
            if (bits < 8 && state != GIVE)
                shift <= {shift[6:0], sda};
            if (bits == 8)
                nack <= sda;
            bits <= bits + 1;
        end
    endtask

    task fall;
        begin
            if (state == STUCK) begin
                left <= left - 1;
                if (left == 1) begin
                    state <= IDLE;
                    sda_low <= 0;
                end
            end else if (bits == 8) begin
                if (state == GIVE) begin
                    sda_low <= 0;
                    upper <= WIDE_VALUE && !upper;
                    if (!upper)
                        moves <= 1;
                end else
                    take;
            end else if (bits == 9) begin
                bits <= 0;
                sda_low <= 0;
                if (state == GIVE && nack)
                    state <= IDLE;
                else if (state == GIVE) begin
                    shift <= {given[6:0], 1'b0};
                    sda_low <= !given[7];
                end
            end else if (state == GIVE) begin
                shift <= {shift[6:0], 1'b0};
                sda_low <= !shift[7];
            end
        end
    endtask

    always @(posedge clk) begin
        scl_was <= scl;
        sda_was <= sda;
        write <= 0;
        if (moves) begin
            moves <= 0;
            pointer <= pointer + 1;
        end
        if (!reset_n) begin
            state <= IDLE;
            sda_low <= 0;
            moves <= 0;
            starts <= 0;
            pointer <= 0;
            value <= 0;
            bits <= 0;
        end else if (scl && scl_was && sda_was && !sda) begin
            state <= SELECT;            // START
            starts <= starts + 1;
            bits <= 0;
            sda_low <= 0;
        end else if (scl && scl_was && !sda_was && sda) begin
            state <= IDLE;              // STOP
            sda_low <= 0;
        end else if (state != IDLE && scl && !scl_was)
            rise;
        else if (state != IDLE && !scl && scl_was)
            fall;
    end
endmodule
