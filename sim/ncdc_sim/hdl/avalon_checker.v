// Protocol checker of one Avalon-MM port: pipelined burst reads, burst writes.
//
// Each violation counts in `errors`; the first 20 print "AVALON-ERROR <port> <rule> <time>":
//   held             a command, and a write's data and byteenable, stay under waitrequest
//   burst-range      burstcount of a new command is 1..MAX_BURST
//   burst-constant   burstcount does not change inside a write burst
//   read-in-write    no read while a write burst is unfinished
//   read-and-write   never both at once
//   aligned          the address is a multiple of the word's bytes
//   unrequested      readdatavalid only while a beat is due
//   unknown          no X or Z on control out of reset, nor on what it qualifies (four states)
// `host_rst` high: the host is being reset and may let go of what it holds; what it has been
// promised and what it has begun stay due. `memory_rst` high: the agent is being reset, and nothing
// is due any more. Unused halves are tied to 0. Counters: commands, beats,
// enabled bytes written, clocks a command waited. The address matters on the first beat of a burst
// alone.

`timescale 1ns/1ps

module avalon_checker #(
    parameter NAME = "port",
    parameter DATA_WIDTH = 32,
    parameter BURST_WIDTH = 5,
    parameter MAX_BURST = 16
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire                    host_rst,
    input  wire                    memory_rst,
    input  wire [31:0]             address,
    input  wire                    read,
    input  wire                    write,
    input  wire [BURST_WIDTH-1:0]  burstcount,
    input  wire [DATA_WIDTH-1:0]   writedata,
    input  wire [DATA_WIDTH/8-1:0] byteenable,
    input  wire                    waitrequest,
    input  wire                    readdatavalid,
    output reg  [31:0]             errors,
    output reg  [31:0]             commands,
    output reg  [31:0]             beats,
    output reg  [31:0]             bytes,
    output reg  [31:0]             waits
);
    localparam LANES = DATA_WIDTH / 8;

    reg                    was_waiting;
    reg                    was_read, was_write;
    reg [31:0]             was_address;
    reg [BURST_WIDTH-1:0]  was_burstcount;
    reg [DATA_WIDTH-1:0]   was_writedata;
    reg [LANES-1:0]        was_byteenable;
    reg [31:0]             write_left;
    reg [31:0]             due;
    reg [DATA_WIDTH-1:0]   mask;
    integer                lane;

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
            commands = 0;
            beats = 0;
            bytes = 0;
            waits = 0;
            was_waiting = 0;
            write_left = 0;
            due = 0;
        end else if (memory_rst) begin
            was_waiting = 0;
            write_left = 0;
            due = 0;
        end else begin
            if (^{read, write, waitrequest, readdatavalid} === 1'bx)
                violation("unknown");
            if (was_waiting && (read !== was_read || write !== was_write
                    || burstcount !== was_burstcount
                    || (write_left == 0 && address !== was_address)
                    || (write && (writedata !== was_writedata || byteenable !== was_byteenable))))
                violation("held");

            if ((read || write) && !was_waiting) begin
                mask = 0;
                for (lane = 0; lane < LANES; lane = lane + 1)
                    if (write && byteenable[lane])
                        mask[8*lane +: 8] = 8'hFF;
                if (^{write_left == 0 ? address : 32'd0, burstcount,
                      write ? byteenable : {LANES{1'b0}}, writedata & mask} === 1'bx)
                    violation("unknown");
                if (read && write)
                    violation("read-and-write");
                if (read && write_left != 0)
                    violation("read-in-write");
                if (write && write_left != 0) begin
                    if (burstcount !== was_burstcount)
                        violation("burst-constant");
                end else begin
                    if (32'd0 + burstcount - 32'd1 >= MAX_BURST)     // 0 too
                        violation("burst-range");
                    if (address % LANES != 0)
                        violation("aligned");
                end
            end

            // Before the beats of this edge's own command: data cannot come with its command.
            if (readdatavalid) begin
                if (due == 0)
                    violation("unrequested");
                else
                    due = due - 1;
                beats = beats + 1;
            end
            if ((read || write) && waitrequest)
                waits = waits + 1;
            if (read && !waitrequest) begin
                commands = commands + 1;
                due = due + burstcount;
            end
            if (write && !waitrequest) begin
                if (write_left == 0) begin
                    commands = commands + 1;
                    write_left = burstcount;
                end
                if (write_left != 0)
                    write_left = write_left - 1;
                beats = beats + 1;
                for (lane = 0; lane < LANES; lane = lane + 1)
                    if (byteenable[lane])
                        bytes = bytes + 1;
            end

            was_waiting = (read || write) && waitrequest && !host_rst;
            was_read = read;
            was_write = write;
            was_address = address;
            was_burstcount = read || write ? burstcount : was_burstcount;
            was_writedata = writedata;
            was_byteenable = byteenable;
        end
    end
endmodule
