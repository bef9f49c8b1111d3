// Avalon-MM memory model: several pipelined burst-read ports and one burst-write port on one
// storage, with run-time latency, stalls and bandwidth.
//
// Timing. A read command accepted at clock edge t delivers its first beat at edge t + latency at
// the earliest, latency drawn per command from latency_min..latency_max; data returns in order on
// each port. All ports together move at most `rate` beats in 256 clocks (a beat is DATA_WIDTH
// bits), shared in turn. A write beat costs as much as a read beat, a read command at least as much
// as `granule` beats: a short read from a wide memory wastes the rest. Each port refuses a command
// while it holds `max_pending` unfinished read commands, and at random in `wait_chance` of 256
// clocks, idle ones included. All outputs come from registers.
//
// The one place where time is decided is `ready_at` (when a command's first beat may go) and
// `credit` (when any beat may go): a model of rows and banks replaces these two.
//
// Byte 0 of a word is its least significant byte. An address beyond BYTES counts in `errors`.

`timescale 1ns/1ps

module avalon_memory #(
    parameter PORTS = 1,                // read ports
    parameter DATA_WIDTH = 32,
    parameter BURST_WIDTH = 5,          // bits of a read port's burstcount
    parameter WRITE_BURST_WIDTH = 5,
    parameter BYTES = 65536,
    parameter PENDING = 64              // commands a read port can hold, at most
) (
    input  wire                          clk,
    input  wire                          rst,
    input  wire [15:0]                   latency_min,   // clocks, 1 or more
    input  wire [15:0]                   latency_max,
    input  wire [15:0]                   rate,          // beats per 256 clocks
    input  wire [15:0]                   granule,       // beats, 1 or more
    input  wire [8:0]                    wait_chance,   // of 256
    input  wire [15:0]                   max_pending,   // 1..PENDING
    input  wire [31:0]                   seed,
    output reg  [31:0]                   errors,

    input  wire [PORTS*32-1:0]           read_address,  // bytes
    input  wire [PORTS-1:0]              read_read,
    input  wire [PORTS*BURST_WIDTH-1:0]  read_burstcount,
    output reg  [PORTS-1:0]              read_waitrequest,
    output reg  [PORTS*DATA_WIDTH-1:0]   read_readdata,
    output reg  [PORTS-1:0]              read_readdatavalid,

    input  wire [31:0]                   write_address, // bytes
    input  wire                          write_write,
    input  wire [WRITE_BURST_WIDTH-1:0]  write_burstcount,
    input  wire [DATA_WIDTH-1:0]         write_writedata,
    input  wire [DATA_WIDTH/8-1:0]       write_byteenable,
    output reg                           write_waitrequest
);
    localparam LANES = DATA_WIDTH / 8;
    localparam WORDS = BYTES / LANES;

    reg [DATA_WIDTH-1:0] store [0:WORDS-1];

    // Read commands, a ring of PENDING entries for each port.
    reg [31:0] word_of  [0:PORTS*PENDING-1];
    reg [31:0] left_of  [0:PORTS*PENDING-1];
    integer    cost_of  [0:PORTS*PENDING-1];    // of the next beat
    reg [31:0] ready_at [0:PORTS*PENDING-1];
    integer    head     [0:PORTS-1];
    integer    held     [0:PORTS-1];

    reg [31:0] now;
    reg [31:0] random;
    integer    credit;              // 256 pay for one beat
    integer    turn;                // client served first: a port, or PORTS for the writer
    reg        granted;             // one write beat is paid for
    reg [31:0] write_word;
    reg [31:0] write_left;

    integer k, p, slot, lane, cost;
    reg [31:0]           word;
    reg [DATA_WIDTH-1:0] beat;

    function [31:0] shuffle(input [31:0] state);
        begin
            shuffle = state ^ (state << 13);
            shuffle = shuffle ^ (shuffle >> 17);
            shuffle = shuffle ^ (shuffle << 5);
        end
    endfunction

    // Words that files hold in byte order; see `load` and `save` below.
    function [DATA_WIDTH-1:0] reversed(input [DATA_WIDTH-1:0] value);
        integer i;
        begin
            for (i = 0; i < LANES; i = i + 1)
                reversed[8*i +: 8] = value[DATA_WIDTH-8-8*i +: 8];
        end
    endfunction

    // $fread puts the first byte of the file into the most significant byte of a word.
    task load(input integer file, input [31:0] base, input [31:0] bytes);
        integer i, got;
        begin
            got = $fread(store, file, base / LANES, (bytes + LANES - 1) / LANES);
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1)
                store[i] = reversed(store[i]);
        end
    endtask

    task fill(input [31:0] base, input [31:0] bytes, input [7:0] value);
        integer i;
        begin
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1)
                store[i] = {LANES{value}};
        end
    endtask

    task save(input integer file, input [31:0] base, input [31:0] bytes);
        integer i, j;
        reg [DATA_WIDTH-1:0] value;
        begin
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1) begin
                value = store[i];
                for (j = 0; j < LANES; j = j + 4)
                    $fwrite(file, "%u", value[8*j +: 32]);
            end
        end
    endtask

    always @(posedge clk) begin
        read_readdatavalid <= 0;
        if (rst) begin
            now = 0;
            random = seed | 32'd1;
            credit = 0;
            turn = 0;
            granted = 0;
            write_left = 0;
            errors <= 0;
            read_waitrequest <= {PORTS{1'b1}};
            write_waitrequest <= 1;
            for (p = 0; p < PORTS; p = p + 1) begin
                head[p] = 0;
                held[p] = 0;
            end
        end else begin
            now = now + 1;
            credit = credit + rate;
            if (credit > rate + 256 * granule)
                credit = rate + 256 * granule;

            for (p = 0; p < PORTS; p = p + 1)
                if (read_read[p] && !read_waitrequest[p]) begin
                    slot = head[p] + held[p];
                    if (slot >= PENDING)
                        slot = slot - PENDING;
                    slot = slot + p * PENDING;
                    word_of[slot] = read_address[32*p +: 32] / LANES;
                    left_of[slot] = read_burstcount[BURST_WIDTH*p +: BURST_WIDTH];
                    cost_of[slot] = left_of[slot] < granule ? 256 * (granule - left_of[slot] + 1)
                                                            : 256;
                    random = shuffle(random);
                    ready_at[slot] = now + latency_min - 1
                                     + random[23:8] % (latency_max - latency_min + 1);
                    held[p] = held[p] + 1;
                end

            if (write_write && !write_waitrequest) begin
                if (write_left == 0) begin
                    write_word = write_address / LANES;
                    write_left = write_burstcount;
                end
                if (write_word >= WORDS) begin
                    $display("AVALON-ERROR memory write-range %0t", $time);
                    errors <= errors + 1;
                end else begin
                    beat = store[write_word];
                    for (lane = 0; lane < LANES; lane = lane + 1)
                        if (write_byteenable[lane])
                            beat[8*lane +: 8] = write_writedata[8*lane +: 8];
                    store[write_word] = beat;
                end
                write_word = write_word + 1;
                write_left = write_left - 1;
                granted = 0;
            end

            // Serve the clients in turn, starting behind the one served last.
            p = turn;
            for (k = 0; k <= PORTS; k = k + 1) begin
                if (p == PORTS) begin
                    if (!granted && credit >= 256) begin
                        granted = 1;
                        credit = credit - 256;
                        turn = 0;
                    end
                end else if (held[p] != 0) begin
                    slot = p * PENDING + head[p];
                    if (ready_at[slot] <= now && credit >= cost_of[slot]) begin
                        word = word_of[slot];
                        if (word >= WORDS) begin
                            $display("AVALON-ERROR memory read-range %0t", $time);
                            errors <= errors + 1;
                        end
                        read_readdatavalid[p] <= 1;
                        read_readdata[DATA_WIDTH*p +: DATA_WIDTH] <= store[word % WORDS];
                        credit = credit - cost_of[slot];
                        cost_of[slot] = 256;
                        word_of[slot] = word + 1;
                        left_of[slot] = left_of[slot] - 1;
                        if (left_of[slot] == 0) begin
                            head[p] = head[p] == PENDING - 1 ? 0 : head[p] + 1;
                            held[p] = held[p] - 1;
                        end
                        turn = p + 1;
                    end
                end
                p = p == PORTS ? 0 : p + 1;
            end

            for (p = 0; p < PORTS; p = p + 1) begin
                random = shuffle(random);
                read_waitrequest[p] <= held[p] >= max_pending || held[p] >= PENDING
                                       || random[15:8] < wait_chance;
            end
            random = shuffle(random);
            write_waitrequest <= !granted || random[15:8] < wait_chance;
        end
    end
endmodule
