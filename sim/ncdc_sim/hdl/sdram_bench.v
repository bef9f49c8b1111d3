// Random traffic on all ports of an SDRAM controller, its data compared with a plain memory, and
// the chip's checker at its pins. The module `sdram_dut`, controller and chip, is made by
// ncdc_sim/sdram.py. The last host is the writer.
//
// What a read may give: each of its words as it was at some time between the read's acceptance and
// the data; a write burst has happened when its last word is accepted, or later. Up to eight
// versions of a word are known; of one that has had more in that time nothing is asked ("unsure").
//
// A reset of the controller (one in about `resets` clocks, 0: never) forgets what is under way;
// words accepted shortly before are not known until they are written whole again.
//
// Plusargs: clocks, seed, resets; and of each host, eight bits each from the lowest on, in hex:
//   kind    0 silent, 1 anywhere, 2 one burst after the other, 3 as a corrector reads: rows of a
//           picture, a few words of one of eight neighbouring rows
//   gap     of 256 clocks, those in which no command is begun, or no word of a burst is offered;
//           255: a command is begun some clocks after the one before it is over
//   least, most     minimum and maximum words of a burst
//
// Results: lines "RESULT <name> <value>", "SDRAM-WRONG ..." for each wrong word.

`timescale 1ns/1ps

module sdram_bench(input wire clk);
    localparam READS = `NCDC_READS;
    localparam HOSTS = READS + 1;
    localparam DATA = `NCDC_DATA;
    localparam BURST = `NCDC_BURST;             // words of a burst, at most
    localparam BITS = $clog2(BURST + 1);
    localparam COLUMNS = `NCDC_COLUMNS;         // bits of a word's column
    localparam ROWS = `NCDC_ROWS;
    localparam INDEX = 3 + 2 + COLUMNS;         // bits of a word's index in the plain memory
    localparam LANES = DATA / 8;
    localparam BEATS = `NCDC_BEATS;
    localparam QUEUE = 1024;                    // words that a reader waits for
    localparam LOG = 4 * BURST;                 // words written last that a reset may lose
    localparam LATEST = 50000;                  // clock in which the chip must be ready

    // Settings.
    reg [63:0] clocks, seed, resets;
    reg [8*HOSTS-1:0] kind, gap, least, most;
    initial begin
        if (!$value$plusargs("clocks=%d", clocks)) clocks = 10000;
        if (!$value$plusargs("seed=%d", seed)) seed = 1;
        if (!$value$plusargs("resets=%d", resets)) resets = 0;
        if (!$value$plusargs("kind=%h", kind)) kind = {HOSTS{8'd1}};
        if (!$value$plusargs("gap=%h", gap)) gap = {HOSTS{8'd100}};
        if (!$value$plusargs("least=%h", least)) least = {HOSTS{8'd1}};
        if (!$value$plusargs("most=%h", most)) most = {HOSTS{8'd8}};
        random = seed * 64'h9E3779B97F4A7C15 + 64'd1;
    end

    reg [63:0] random;
    function [31:0] next(input integer unused);
        begin
            random = random ^ (random << 13);
            random = random ^ (random >> 7);
            random = random ^ (random << 17);
            next = random[47:16];
        end
    endfunction

    reg                    rst;
    reg  [32*READS-1:0]    read_address;
    reg  [READS-1:0]       read_read;
    reg  [BITS*READS-1:0]  read_burstcount;
    wire [READS-1:0]       read_waitrequest, read_readdatavalid;
    wire [DATA*READS-1:0]  read_readdata;
    reg  [31:0]            write_address;
    reg                    write_write;
    reg  [BITS-1:0]        write_burstcount;
    reg  [DATA-1:0]        write_writedata;
    reg  [LANES-1:0]       write_byteenable;
    wire                   write_waitrequest;
    wire                   ready;
    wire [31:0]            violations, refreshes, refresh_most, beats_read, beats_written;
    wire [63:0]            trace;               // a hash of the controller's outputs

    sdram_dut dut (
        .clk(clk), .rst(rst), .read_address(read_address), .read_read(read_read),
        .read_burstcount(read_burstcount), .read_waitrequest(read_waitrequest),
        .read_readdata(read_readdata), .read_readdatavalid(read_readdatavalid),
        .write_address(write_address), .write_write(write_write),
        .write_burstcount(write_burstcount), .write_writedata(write_writedata),
        .write_byteenable(write_byteenable), .write_waitrequest(write_waitrequest), .ready(ready),
        .violations(violations), .refreshes(refreshes), .refresh_most(refresh_most),
        .beats_read(beats_read), .beats_written(beats_written), .trace(trace)
    );

    reg  [63:0]         now, ready_at;          // clocks
    wire [32*HOSTS-1:0] port_errors;
    genvar g;
    generate
        for (g = 0; g < HOSTS; g = g + 1) begin : port
            if (g < READS) begin : reading
                avalon_checker #(.NAME("read"), .DATA_WIDTH(DATA), .BURST_WIDTH(BITS),
                                 .MAX_BURST(BURST)) checker_ (
                    .clk(clk), .rst(now == 0), .host_rst(1'b0), .memory_rst(rst),
                    .address(read_address[32*g +: 32]), .read(read_read[g]), .write(1'b0),
                    .burstcount(read_burstcount[BITS*g +: BITS]), .writedata({DATA{1'b0}}),
                    .byteenable({LANES{1'b0}}), .waitrequest(read_waitrequest[g]),
                    .readdatavalid(read_readdatavalid[g]), .errors(port_errors[32*g +: 32]),
                    .commands(), .beats(), .bytes(), .waits());
            end else begin : writing
                avalon_checker #(.NAME("write"), .DATA_WIDTH(DATA), .BURST_WIDTH(BITS),
                                 .MAX_BURST(BURST)) checker_ (
                    .clk(clk), .rst(now == 0), .host_rst(1'b0), .memory_rst(rst),
                    .address(write_address), .read(1'b0), .write(write_write),
                    .burstcount(write_burstcount), .writedata(write_writedata),
                    .byteenable(write_byteenable), .waitrequest(write_waitrequest),
                    .readdatavalid(1'b0), .errors(port_errors[32*g +: 32]),
                    .commands(), .beats(), .bytes(), .waits());
            end
        end
    endgenerate

    // The plain memory: the last eight versions of each word.
    reg [DATA-1:0] version [0:(8 << INDEX) - 1];
    reg [31:0]     accepted [0:(1 << INDEX) - 1];   // number of the last version
    reg [31:0]     happened [0:(1 << INDEX) - 1];   // number of the last one that must be seen
    reg [31:0]     known [0:(1 << INDEX) - 1];      // number of the first one known since a reset
    reg [INDEX-1:0] log [0:LOG-1];
    reg [31:0]     logged;

    // Of each host.
    reg [31:0] at [0:HOSTS-1];                  // number of the next burst's first word
    reg [31:0] row_at [0:HOSTS-1];              // of kind 3: column and row of the picture
    reg [INDEX-1:0] due_index [0:QUEUE*READS-1];
    reg [31:0] due_floor [0:QUEUE*READS-1];
    reg [31:0] due_in [0:READS-1], due_out [0:READS-1];
    reg [63:0] begun [0:HOSTS-1];               // when its only command under way was accepted
    reg [HOSTS-1:0] timed;                      // there is such a command
    reg [31:0] longest [0:HOSTS-1];
    reg [31:0] total [0:HOSTS-1];               // words
    reg [31:0] left;                            // words of the write burst, that offered included
    reg [INDEX-1:0] burst_index, word_index;
    reg [31:0] beats_due;                       // of writes accepted, as beats_written will be

    reg [31:0] since_reset, ready_first, ready_longest;     // clocks
    reg        was_ready;
    reg [31:0] wrong, unsure, checked, reset_count, beats_before, rst_left;
    integer    h, k, found;
    reg [31:0] length, number, index32, newest, oldest, got_resets;
    reg [DATA-1:0] value;

    // Number of a word: rows 0 to 3 and the four highest.
    function [31:0] number_of(input [INDEX-1:0] index);
        number_of = {{(32-INDEX){index[INDEX-1]}}, index}
                    & ((32'd1 << (ROWS + 2 + COLUMNS)) - 1);
    endfunction

    function begins(input [7:0] pause, input over);
        begins = pause == 255 ? over && next(0) % 8 == 0 : next(0) % 256 >= {24'd0, pause};
    endfunction

    task begin_burst(input integer host);
        begin
            length = {24'd0, least[8*host +: 8]}
                     + next(0) % ({24'd0, most[8*host +: 8]} - {24'd0, least[8*host +: 8]} + 1);
            case (kind[8*host +: 8])
                1: begin
                    number = next(0);
                    // One in four begins where a row ends.
                    if (number[31:30] == 0)
                        number = (number | ((1 << COLUMNS) - 1)) - number[29:28];
                end
                2: begin
                    number = at[host];
                    at[host] = at[host] + length;
                end
                default: begin
                    // 160 words a row; columns ascend, a new row of the picture follows.
                    number = (row_at[host] + {29'd0, random[2:0]}) * 160 + at[host];
                    at[host] = at[host] + 1;
                    if (at[host] >= 160) begin
                        at[host] = 0;
                        row_at[host] = row_at[host] + 1;
                    end
                end
            endcase
            index32 = number & ((1 << INDEX) - 1);
        end
    endtask

    task accept_read(input integer host);
        begin
            for (k = 0; k < read_burstcount[BITS*host +: BITS]; k = k + 1) begin
                index32 = (read_address[32*host +: 32] / LANES + k) & ((1 << INDEX) - 1);
                due_index[QUEUE*host + due_in[host] % QUEUE] = index32[INDEX-1:0];
                due_floor[QUEUE*host + due_in[host] % QUEUE] = happened[index32];
                due_in[host] = due_in[host] + 1;
            end
            timed[host] = ready && due_in[host] - due_out[host]
                          == {{(32-BITS){1'b0}}, read_burstcount[BITS*host +: BITS]};
            begun[host] = now;
        end
    endtask

    task check_word(input integer host);
        begin
            total[host] = total[host] + 1;
            index32 = {{(32-INDEX){1'b0}}, due_index[QUEUE*host + due_out[host] % QUEUE]};
            oldest = due_floor[QUEUE*host + due_out[host] % QUEUE];
            due_out[host] = due_out[host] + 1;
            newest = accepted[index32];
            value = read_readdata[DATA*host +: DATA];
            if (oldest < known[index32] || newest - oldest > 7)
                unsure = unsure + 1;
            else begin
                checked = checked + 1;
                found = 0;
                for (k = 0; k < 8; k = k + 1)
                    if (oldest + k <= newest && version[index32 * 8 + (oldest + k) % 8] === value)
                        found = 1;
                if (found == 0) begin
                    if (wrong < 20)
                        $display("SDRAM-WRONG port %0d word %h got %h expected %h clock %0d", host,
                                 index32, value, version[index32 * 8 + newest % 8], now);
                    wrong = wrong + 1;
                end
            end
            if (due_out[host] == due_in[host] && timed[host]) begin
                if (now - begun[host] > {32'd0, longest[host]})
                    longest[host] = now[31:0] - begun[host][31:0];
                timed[host] = 0;
            end
        end
    endtask

    task accept_word;
        begin
            total[READS] = total[READS] + 1;
            beats_due = beats_due + BEATS;
            index32 = {{(32-INDEX){1'b0}}, word_index};
            newest = accepted[index32];
            value = version[index32 * 8 + newest % 8];
            for (k = 0; k < LANES; k = k + 1)
                if (write_byteenable[k])
                    value[8*k +: 8] = write_writedata[8*k +: 8];
            accepted[index32] = newest + 1;
            version[index32 * 8 + (newest + 1) % 8] = value;
            if (known[index32] == 32'hFFFFFFFF && (&write_byteenable))
                known[index32] = newest + 1;
            log[logged % LOG] = word_index;
            logged = logged + 1;
            left = left - 1;
            word_index = word_index + 1;
            if (left == 0) begin
                for (k = 0; k < write_burstcount; k = k + 1) begin
                    index32 = ({{(32-INDEX){1'b0}}, burst_index} + k) & ((1 << INDEX) - 1);
                    happened[index32] = accepted[index32];
                end
                if (!timed[READS]) begin
                    timed[READS] = ready && beats_written + BEATS * write_burstcount >= beats_due;
                    begun[READS] = now;
                end else
                    timed[READS] = 0;       // two are under way
            end
        end
    endtask

    task forget;                // the controller is reset
        begin
            for (h = 0; h < READS; h = h + 1)
                due_out[h] = due_in[h];
            for (k = 0; k < LOG; k = k + 1)
                if (k < logged)
                    known[{{(32-INDEX){1'b0}}, log[k]}] = 32'hFFFFFFFF;
            read_read <= 0;
            write_write <= 0;
            left = 0;
            timed = 0;
            reset_count = reset_count + 1;
        end
    endtask

    task prepare;               // words of known content
        integer row, bank, column, beat;
        begin
            for (k = 0; k < (1 << INDEX); k = k + 1) begin
                value = 0;
                for (beat = 0; beat < BEATS; beat = beat + 1) begin
                    number = next(0);
                    value[(DATA/BEATS)*beat +: DATA/BEATS] = number[DATA/BEATS-1:0];
                    row = k >> (2 + COLUMNS);
                    bank = (k >> COLUMNS) & 3;
                    column = (k & ((1 << COLUMNS) - 1)) * BEATS + beat;
                    dut.chip.put((((bank << 3) | row) << (COLUMNS + $clog2(BEATS))) | column,
                                 number[DATA/BEATS-1:0]);
                end
                version[k * 8] = value;
                accepted[k] = 0;
                happened[k] = 0;
                known[k] = 0;
            end
        end
    endtask

    initial begin
        rst = 1; read_read = 0; write_write = 0; read_address = 0; read_burstcount = 0;
        write_address = 0; write_burstcount = 0; write_writedata = 0; write_byteenable = 0;
        since_reset = 0; ready_first = 0; ready_longest = 0; was_ready = 0;
        now = 0; ready_at = 0; wrong = 0; unsure = 0; checked = 0; reset_count = 0; left = 0;
        logged = 0; timed = 0; beats_due = 0; beats_before = 0; rst_left = 3;
        for (h = 0; h < HOSTS; h = h + 1) begin
            at[h] = h << (INDEX - 2); row_at[h] = 0; longest[h] = 0; total[h] = 0; begun[h] = 0;
        end
        for (h = 0; h < READS; h = h + 1) begin
            due_in[h] = 0; due_out[h] = 0;
        end
    end

    always @(posedge clk) begin
        if (now == 0) prepare;
        now <= now + 1;
        // What has come, and what has been accepted, at this edge.
        if (!rst) begin
            for (h = 0; h < READS; h = h + 1)
                if (read_readdatavalid[h] && due_out[h] != due_in[h]) check_word(h);
            for (h = 0; h < READS; h = h + 1)
                if (read_read[h] && !read_waitrequest[h]) accept_read(h);
            if (write_write && !write_waitrequest) accept_word;
            if (timed[READS] && beats_written == beats_due) begin
                if (now - begun[READS] > {32'd0, longest[READS]})
                    longest[READS] = now[31:0] - begun[READS][31:0];
                timed[READS] = 0;
            end
        end
        since_reset = rst ? 0 : since_reset + 1;
        if (!rst && ready && !was_ready) begin
            if (ready_first == 0) ready_first = since_reset;
            else if (since_reset > ready_longest) ready_longest = since_reset;
        end
        was_ready = ready && !rst;
        if (ready && ready_at == 0) begin
            ready_at = now;
            beats_before = beats_read + beats_written;
        end

        // What the hosts do next.
        if (rst_left != 0) begin
            rst_left = rst_left - 1;
            rst <= rst_left != 0;
        end else if (resets != 0 && next(0) % resets[31:0] == 0) begin
            rst_left = 1 + next(0) % 3;
            rst <= 1;
        end
        if (rst) begin
            forget;
            beats_due = beats_written;
        end else begin
            for (h = 0; h < READS; h = h + 1)
                if (!(read_read[h] && read_waitrequest[h])) begin
                    read_read[h] <= 0;
                    if (kind[8*h +: 8] != 0 && begins(gap[8*h +: 8], due_in[h] == due_out[h])
                            && due_in[h] - due_out[h] < QUEUE - 2 * BURST) begin
                        begin_burst(h);
                        read_read[h] <= 1;
                        read_address[32*h +: 32] <= number_of(index32[INDEX-1:0]) * LANES;
                        read_burstcount[BITS*h +: BITS] <= length[BITS-1:0];
                    end
                end
            if (!(write_write && write_waitrequest)) begin
                write_write <= 0;
                if (kind[8*READS +: 8] != 0
                        && begins(gap[8*READS +: 8], left != 0 || !timed[READS])) begin
                    if (left == 0) begin
                        begin_burst(READS);
                        burst_index = index32[INDEX-1:0];
                        word_index = burst_index;
                        left = length;
                        write_address <= number_of(burst_index) * LANES;
                        write_burstcount <= length[BITS-1:0];
                    end
                    write_write <= 1;
                    for (k = 0; k < LANES; k = k + 1)
                        write_writedata[8*k +: 8] <= next(0);
                    number = next(0);
                    write_byteenable <= number[31:30] == 0 ? number[LANES-1:0] : {LANES{1'b1}};
                end
            end
        end

        if (now == LATEST && ready_at == 0) begin
            $display("FAILED the controller is not ready after %0d clocks", now);
            $finish;
        end
        if (now == clocks + ready_at && ready_at != 0) begin
            $display("RESULT violations %0d", violations);
            $display("RESULT wrong %0d", wrong);
            $display("RESULT checked %0d", checked);
            $display("RESULT unsure %0d", unsure);
            $display("RESULT refreshes %0d", refreshes);
            $display("RESULT refresh_most %0d", refresh_most);
            $display("RESULT beats %0d", beats_read + beats_written - beats_before);
            $display("RESULT resets %0d", reset_count);
            $display("RESULT ready_first %0d", ready_first);
            $display("RESULT ready_longest %0d", ready_longest);
            k = 0;
            for (h = 0; h < HOSTS; h = h + 1) begin
                k = k + port_errors[32*h +: 32];
                $display("RESULT words%0d %0d", h, total[h]);
                $display("RESULT longest%0d %0d", h, longest[h]);
            end
            $display("RESULT port_errors %0d", k);
            $display("RESULT trace %0d", trace);
            $display("RESULT total_clocks %0d", now);
            $finish;
        end
    end
endmodule
