// Avalon-MM memory model: several pipelined burst-read ports and one burst-write port on one
// storage, timed by run-time settings. Rules and presets: model/ncdc_model/planner/memory_timing.py.
//
// Read data returns in order on each port. Each port stalls a command while it holds
// `max_pending` unfinished read commands, and at random in `wait_probability` of 256 clocks, idle
// ones included. All outputs come from registers.
//
// Two kinds of timing:
//   latency   (dram = 0) A read command accepted at clock edge t delivers its first beat at edge
//             t + latency at the earliest, latency drawn per command from
//             latency_min..latency_max. All ports together move at most `rate` beats in 256 clocks
//             (a beat is DATA_WIDTH bits), shared in turn. A write beat costs as much as a read
//             beat, a read command at least as much as `granule` beats.
//   rows      (dram = 1) Reads and writes become accesses of a dynamic memory, which `dram_timing`
//             gives their times. Read ports take turns by command; a write access is queued when
//             its last byte, or its burst's, has come.
//
// A reset forgets every read that has been accepted, and the rest of a write burst; what is stored
// stays. Byte 0 of a word is its least significant byte. An address beyond BYTES counts in `errors`.
// Settings are plusargs, read below.

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

    localparam RETURN = 64;             // beats under way to a port, open rows
    localparam QUEUE = 256;             // pieces of writes not yet scheduled

    // Settings.
    reg [31:0] dram, latency_min, latency_max, rate, granule, wait_probability, max_pending, seed;
    reg [31:0] controller_clocks, write_batch;

    initial begin
        if (!$value$plusargs("dram=%d", dram)) dram = 0;
        if (!$value$plusargs("latency_min=%d", latency_min)) latency_min = 1;
        if (!$value$plusargs("latency_max=%d", latency_max)) latency_max = latency_min;
        if (!$value$plusargs("rate=%d", rate)) rate = 256 * (PORTS + 1);
        if (!$value$plusargs("granule=%d", granule)) granule = 1;
        if (!$value$plusargs("wait_probability=%d", wait_probability)) wait_probability = 0;
        if (!$value$plusargs("max_pending=%d", max_pending)) max_pending = 64;
        if (!$value$plusargs("seed=%d", seed)) seed = 1;
        if (!$value$plusargs("controller_clocks=%d", controller_clocks)) controller_clocks = 1;
        if (!$value$plusargs("write_batch=%d", write_batch)) write_batch = 16;
        random = seed | 32'd1;
        range_errors = 0;
    end

    reg [31:0] now;                     // clocks since reset
    reg [31:0] random;
    integer    turn;                    // port served first; PORTS: the writer

    // Read commands, a ring of PENDING entries for each port.
    reg [31:0] word_of  [0:PORTS*PENDING-1];    // next word to deliver
    reg [31:0] left_of  [0:PORTS*PENDING-1];    // words to deliver
    reg [31:0] ready_at [0:PORTS*PENDING-1];    // clock of the first word, or of the first access
    integer    head     [0:PORTS-1];
    integer    held     [0:PORTS-1];

    // The write burst that is coming in.
    reg [31:0] write_word;
    reg [31:0] write_left;

    // Timing by latency and rate.
    integer cost_of [0:PORTS*PENDING-1];        // of the next beat
    integer credit;                             // 256 pay for one beat
    reg     granted;                            // one write beat is paid for

    // Timing by rows. Commands with accesses still to be scheduled are the last `unscheduled`
    // of those held; the first of them has bytes rest_from..rest_end to go if `started`.
    integer    unscheduled [0:PORTS-1];
    reg [PORTS-1:0] started;
    reg [31:0] rest_from [0:PORTS-1];
    reg [31:0] rest_end  [0:PORTS-1];
    reg [31:0] due_at     [0:PORTS*RETURN-1];   // memory clock of each beat under way
    integer    due_head   [0:PORTS-1];
    integer    due_count  [0:PORTS-1];
    reg [31:0] piece_from [0:QUEUE-1];          // bytes to write, a ring
    reg [31:0] piece_end  [0:QUEUE-1];
    reg [31:0] piece_at   [0:QUEUE-1];          // clock from which it may be scheduled
    integer    piece_head, pieces;
    integer    queued;                          // accesses of all pieces
    reg [31:0] gather_from;                     // start of the piece that is coming in
    reg        gathering;
    reg        writing;                         // direction of the last access
    integer    batch;                           // accesses since it changed

    integer k, p, q, slot, lane;
    reg [31:0]           word, from, upto, data_start;
    reg [DATA_WIDTH-1:0] beat;
    reg                  may_read, may_write, idle;     // idle: no port holds a read command
    reg [31:0]           range_errors;

    dram_timing dram_timing ();

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

    task put(input [31:0] address, input [7:0] value);
        store[address / LANES][8 * (address % LANES) +: 8] = value;
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

    // The address after the access that holds `from`, no further than `limit`.
    function [31:0] access_end(input [31:0] from, input [31:0] limit);
        begin
            access_end = ((from >> dram_timing.access_bits) + 1) << dram_timing.access_bits;
            if (access_end > limit)
                access_end = limit;
        end
    endfunction

    function integer accesses(input [31:0] from, input [31:0] upto);
        accesses = ((upto - 1) >> dram_timing.access_bits) - (from >> dram_timing.access_bits) + 1;
    endfunction

    task out_of_range(input [8*16-1:0] rule);
        begin
            $display("AVALON-ERROR memory %0s %0t", rule, $time);
            range_errors = range_errors + 1;
        end
    endtask

    task restart;
        begin
            now = 0;
            turn = 0;
            credit = 0;
            granted = 0;
            write_left = 0;
            piece_head = 0;
            pieces = 0;
            queued = 0;
            gathering = 0;
            writing = 0;
            batch = 0;
            started = 0;
            for (p = 0; p < PORTS; p = p + 1) begin
                head[p] = 0;
                held[p] = 0;
                unscheduled[p] = 0;
                due_head[p] = 0;
                due_count[p] = 0;
            end
            dram_timing.restart;
        end
    endtask

    // The command on port p.
    task take_read;
        begin
            slot = head[p] + held[p];
            if (slot >= PENDING)
                slot = slot - PENDING;
            slot = slot + p * PENDING;
            word_of[slot] = read_address[32*p +: 32] / LANES;
            left_of[slot] = read_burstcount[BURST_WIDTH*p +: BURST_WIDTH];
            held[p] = held[p] + 1;
            if (dram) begin
                ready_at[slot] = now + controller_clocks;
                unscheduled[p] = unscheduled[p] + 1;
            end else begin
                cost_of[slot] = left_of[slot] < granule ? 256 * (granule - left_of[slot] + 1)
                                                        : 256;
                random = shuffle(random);
                ready_at[slot] = now + latency_min - 1
                                 + random[23:8] % (latency_max - latency_min + 1);
            end
        end
    endtask

    task take_write;
        begin
            if (write_left == 0) begin
                write_word = write_address / LANES;
                write_left = write_burstcount;
            end
            if (write_word >= WORDS)
                out_of_range("write-range");
            else begin
                beat = store[write_word];
                for (lane = 0; lane < LANES; lane = lane + 1)
                    if (write_byteenable[lane])
                        beat[8*lane +: 8] = write_writedata[8*lane +: 8];
                store[write_word] = beat;
            end
            write_left = write_left - 1;
            granted = 0;
            if (!gathering)
                gather_from = write_word * LANES;
            write_word = write_word + 1;
            upto = write_word * LANES;
            gathering = write_left != 0 && access_end(upto - 1, upto + 1) != upto;
            if (dram && !gathering) begin
                slot = (piece_head + pieces) % QUEUE;
                piece_from[slot] = gather_from;
                piece_end[slot] = upto;
                piece_at[slot] = now + controller_clocks;
                pieces = pieces + 1;
                queued = queued + accesses(gather_from, upto);
            end
        end
    endtask

    // The next beat of port p.
    task deliver;
        begin
            slot = p * PENDING + head[p];
            word = word_of[slot];
            if (word >= WORDS)
                out_of_range("read-range");
            read_readdatavalid[p] <= 1;
            read_readdata[DATA_WIDTH*p +: DATA_WIDTH] <= store[word % WORDS];
            word_of[slot] = word + 1;
            left_of[slot] = left_of[slot] - 1;
            if (left_of[slot] == 0) begin
                head[p] = head[p] == PENDING - 1 ? 0 : head[p] + 1;
                held[p] = held[p] - 1;
            end
        end
    endtask

    // Serve the clients in turn, starting after the one served last.
    task serve_by_rate;
        begin
            credit = credit + rate;
            if (credit > rate + 256 * granule)
                credit = rate + 256 * granule;
            p = turn;
            for (k = 0; k <= PORTS; k = k + 1) begin
                slot = p * PENDING + head[p == PORTS ? 0 : p];
                if (p == PORTS) begin
                    if (!granted && credit >= 256) begin
                        granted = 1;
                        credit = credit - 256;
                        turn = 0;
                    end
                end else if (held[p] != 0 && ready_at[slot] <= now && credit >= cost_of[slot]) begin
                    credit = credit - cost_of[slot];
                    cost_of[slot] = 256;
                    deliver;
                    turn = p + 1;
                end
                p = p == PORTS ? 0 : p + 1;
            end
        end
    endtask

    // Find a read access that may be scheduled: port p, bytes from..upto.
    task find_read;
        begin
            may_read = 0;
            q = turn;
            for (k = 0; k < PORTS; k = k + 1) begin
                slot = head[q] + held[q] - unscheduled[q];
                slot = q * PENDING + (slot >= PENDING ? slot - PENDING : slot);
                if (!may_read && unscheduled[q] != 0 && ready_at[slot] <= now) begin
                    if (!started[q]) begin
                        rest_from[q] = word_of[slot] * LANES;
                        rest_end[q] = rest_from[q] + left_of[slot] * LANES;
                        started[q] = 1;
                    end
                    p = q;
                    from = rest_from[p];
                    upto = access_end(from, rest_end[p]);
                    may_read = due_count[p] + upto / LANES - from / LANES <= RETURN;
                end
                q = q == PORTS - 1 ? 0 : q + 1;
            end
        end
    endtask

    task schedule_read;
        begin
            dram_timing.schedule(1'b0, from, upto, data_start);
            for (k = from / LANES + 1; k <= upto / LANES; k = k + 1) begin
                due_at[p * RETURN + (due_head[p] + due_count[p]) % RETURN] =
                    data_start + dram_timing.words(from, k * LANES) * dram_timing.word_clocks;
                due_count[p] = due_count[p] + 1;
            end
            rest_from[p] = upto;
            turn = p;
            if (upto == rest_end[p]) begin
                started[p] = 0;
                unscheduled[p] = unscheduled[p] - 1;
                turn = p == PORTS - 1 ? 0 : p + 1;
            end
        end
    endtask

    task schedule_write;
        begin
            from = piece_from[piece_head];
            upto = access_end(from, piece_end[piece_head]);
            dram_timing.schedule(1'b1, from, upto, data_start);
            queued = queued - 1;
            piece_from[piece_head] = upto;
            if (upto == piece_end[piece_head]) begin
                piece_head = (piece_head + 1) % QUEUE;
                pieces = pieces - 1;
            end
        end
    endtask

    task serve_by_rows;
        begin
            dram_timing.step;
            for (p = 0; p < PORTS; p = p + 1)
                if (due_count[p] != 0 && due_at[p * RETURN + due_head[p]] <= dram_timing.next) begin
                    due_head[p] = (due_head[p] + 1) % RETURN;
                    due_count[p] = due_count[p] - 1;
                    deliver;
                end
            if (dram_timing.ready) begin
                find_read;
                idle = 1;
                for (q = 0; q < PORTS; q = q + 1)
                    if (held[q] != 0)
                        idle = 0;
                may_write = pieces != 0 && piece_at[piece_head] <= now;
                // The direction stays for a batch, and longer if nothing goes the other way.
                if (writing ? may_read && (!may_write || batch >= write_batch)
                            : may_write && (idle || queued >= write_batch
                                            && (!may_read || batch >= write_batch))) begin
                    writing = !writing;
                    batch = 0;
                end
                if (writing ? may_write : may_read) begin
                    batch = batch + 1;
                    if (writing)
                        schedule_write;
                    else
                        schedule_read;
                end
            end
        end
    endtask

    always @(posedge clk) begin
        read_readdatavalid <= 0;
        if (rst) begin
            restart;
            read_waitrequest <= {PORTS{1'b1}};
            write_waitrequest <= 1;
        end else begin
            now = now + 1;
            for (p = 0; p < PORTS; p = p + 1)
                if (read_read[p] && !read_waitrequest[p])
                    take_read;
            if (write_write && !write_waitrequest)
                take_write;
            if (dram)
                serve_by_rows;
            else
                serve_by_rate;
            for (p = 0; p < PORTS; p = p + 1) begin
                random = shuffle(random);
                read_waitrequest[p] <= held[p] >= max_pending || held[p] >= PENDING
                                       || random[15:8] < wait_probability;
            end
            random = shuffle(random);
            write_waitrequest <= (dram ? queued + accesses(0, LANES) > 2 * write_batch : !granted)
                                 || random[15:8] < wait_probability;
        end
        errors <= range_errors + dram_timing.errors;
    end
endmodule
