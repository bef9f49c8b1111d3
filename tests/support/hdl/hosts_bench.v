// Several hosts of one register file: `register_hosts` with a serial line, a JTAG chain, a bus host
// and programs, each with a script. The register file stalls and answers at random.
//
// The files serial.txt, jtag.txt, bus.txt and program.txt hold lines of three hexadecimal numbers:
//   serial.txt    0 byte bit    send a byte, each bit for so many sixteenths of a clock
//                 1 a           wait for a clocks
//                 2 a           the line is low for a clocks
//   jtag.txt      0 a b         scan 64 bits, a the upper 32                JTAG value
//                 1 a           wait
//                 2 a           the register file takes nothing for a clocks
//                 3 a b         scan only the lower a bits of b
//   bus.txt       0 a b         write b to the register at word address a
//                 1 a           read it                                     BUS value
//                 2 a           wait
//   program.txt   0 a           wait until no program runs, start a
//                 1 a           wait
// Registers hold their address times 65,537, exclusive or A5A5A5A5; reading one whose upper five
// address bits are ones takes 1 off its low byte, unless that is 0.
//
// Lines: those, UART byte, ACCESS clock write address word; then RESULT lines. FAILED if the stop bit
// of a byte is low, two accesses are made at a time, a request changes under waitrequest, or the
// scripts are not over in clock_limit clocks. Plusargs: wait, clocks of 256 in which the
// register file takes nothing; latency, most clocks to an answer; noise: for so many clocks before the
// scripts there are resets, a random line, and random accesses and programs. RESULT trace is a hash of all
// outputs in all clocks.

`timescale 1ns/1ps

module hosts_bench (input wire clk);
    localparam BITS = `NCDC_ADDRESS_BITS;
    localparam DIVISOR = `NCDC_DIVISOR;

    reg [31:0] clock_limit, wait_, latency, noise, random = 32'h2545F491, clocks = 0;
    integer serial, jtag, bus, program_, got, k;
    initial begin
        if (!$value$plusargs("clock_limit=%d", clock_limit)) clock_limit = 0;
        if (!$value$plusargs("wait=%d", wait_)) wait_ = 0;
        if (!$value$plusargs("latency=%d", latency)) latency = 1;
        if (!$value$plusargs("noise=%d", noise)) noise = 0;
        serial = $fopen("serial.txt", "r");
        jtag = $fopen("jtag.txt", "r");
        bus = $fopen("bus.txt", "r");
        program_ = $fopen("program.txt", "r");
    end
    wire       begins = clocks > noise + 16;    // the scripts

    reg             rst = 1, line = 1, tck = 0, tdi = 0, capture = 0, shift = 0, update = 0;
    wire            send, tdo, busy;
    reg             start = 0;
    reg  [2:0]      which = 0;
    wire [7:0]      failures;
    reg  [BITS-1:0] bus_address = 0;
    reg             bus_read = 0, bus_write = 0;
    reg  [31:0]     bus_writedata = 0;
    wire [31:0]     bus_readdata;
    wire            bus_valid, bus_waitrequest;
    wire [BITS-1:0] address;
    wire            read, write;
    wire [31:0]     writedata;
    reg  [31:0]     readdata = 0;
    reg             valid = 0, waitrequest = 1;
    register_hosts dut (
        .clk(clk), .rst(rst), .receive(line), .send(send), .tck(tck), .scan__tdi(tdi),
        .scan__tdo(tdo), .scan__capture(capture), .scan__shift(shift), .scan__update(update),
        .start(start), .which(which), .busy(busy), .failures(failures),
        .agent__address(bus_address), .agent__read(bus_read), .agent__write(bus_write),
        .agent__writedata(bus_writedata), .agent__readdata(bus_readdata),
        .agent__readdatavalid(bus_valid), .agent__waitrequest(bus_waitrequest),
        .bus__address(address), .bus__read(read), .bus__write(write), .bus__writedata(writedata),
        .bus__readdata(readdata), .bus__readdatavalid(valid), .bus__waitrequest(waitrequest)
    );

    // All outputs in all clocks, as far as they are valid.
    wire [63:0] trace;
    digest #(.WORDS(4)) digest (.clk(clk), .sum(trace), .value({
        bus_valid ? bus_readdata : 32'd0, write ? writedata : 32'd0,
        read || write ? {{(32-BITS){1'b0}}, address} : 32'd0, failures, 17'd0, busy, send, read,
        write, bus_valid, bus_waitrequest && (bus_read || bus_write), tdo}));

    task fail(input [8*40-1:0] reason);
        begin
            $display("FAILED %0s in clock %0d", reason, clocks);
            $finish;
        end
    endtask

    // The register file.
    reg [31:0]    store [0:(1<<BITS)-1];
    reg [31:0]    left = 0, hold = 0;       // clocks to the answer; clocks in which it takes nothing
    reg           due = 0, asked = 0;
    reg [BITS+33:0] request, was = 0;
    reg [31:0]    word;
    integer       i;
    always @(posedge clk) begin
        clocks = clocks + 1;
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        rst <= clocks < 8 || clocks < noise && random[28:20] == 0
               || clocks >= noise && clocks < noise + 8;
        if (clocks == noise + 4)
            for (i = 0; i < 1 << BITS; i = i + 1) store[i] = (i * 32'h10001) ^ 32'hA5A5A5A5;
        valid <= 0;
        readdata <= random;                 // unless it is an answer
        request = {read, write, address, writedata};
        if (!rst) begin
            if (read && write || due && (read || write)) fail("two accesses at a time");
            if (asked && request != was) fail("a request changes under waitrequest");
            asked = (read || write) && waitrequest;
            was = request;
            if ((read || write) && !waitrequest) begin
                if (clocks >= noise + 8)
                    $display("ACCESS %0d %0d %0d %0d", clocks, write, address,
                             write ? writedata : store[address]);
                word = store[address];
                if (write) store[address] = writedata;
                else begin
                    due = 1;
                    left = random[30:16] % latency;
                    if (&address[BITS-1 -: 5] && store[address][7:0] != 0)
                        store[address] = store[address] - 1;
                end
            end
            if (due && left == 0) begin
                valid <= 1;
                readdata <= word;
                due = 0;
            end else if (due) left = left - 1;
        end else begin
            due = 0;
            asked = 0;
        end
        if (hold != 0) hold = hold - 1;
        waitrequest <= random[15:8] < wait_ || hold != 0;
    end

    // What comes before the scripts.
    reg n_reading = 0;
    always @(posedge clk) if (clocks <= noise) begin
        if (random[3:0] == 0) line <= random[8];
        if (clocks + 20 * DIVISOR > noise) line <= 1;
        start <= random[9:0] == 0;
        which <= random[12:10];
        if (rst || clocks == noise) begin
            bus_read <= 0;
            bus_write <= 0;
            n_reading = 0;
        end else if (bus_read || bus_write) begin
            if (!bus_waitrequest) begin
                n_reading = bus_read;
                bus_read <= 0;
                bus_write <= 0;
            end
        end else if (n_reading) n_reading = !bus_valid;
        else if (random[20:17] == 0) begin
            bus_address <= {2'b11, random[10 +: BITS-2]};
            bus_writedata <= random;
            bus_read <= random[21];
            bus_write <= !random[21];
        end
    end

    // The serial line: a byte that is sent, and one that comes.
    reg [31:0] s_op = 0, s_a = 0, s_b = 0, s_wait = 0, s_bit = 0, s_part = 0;
    reg        s_asked = 0, s_over = 0;
    reg [9:0]  s_bits = 0;
    always @(posedge clk) if (begins && !s_over) begin
        if (!s_asked) begin
            got = $fscanf(serial, "%h %h %h", s_op, s_a, s_b);
            if (got != 3) s_over = 1;
            s_asked = 1;
            s_wait = 0;
            s_bit = 0;
            s_part = 0;
            s_bits = {1'b1, s_a[7:0], 1'b0};
        end
        s_wait = s_wait + 1;
        if (s_over) line <= 1;
        else if (s_op == 0) begin
            line <= s_bits[0];
            s_part = s_part + 16;
            if (s_part >= s_b) begin
                s_part = s_part - s_b;
                s_bits = s_bits >> 1;
                s_bit = s_bit + 1;
                if (s_bit == 10) s_asked = 0;
            end
        end else begin
            line <= s_op != 2;
            if (s_wait >= s_a) s_asked = 0;
        end
    end
    reg [31:0] r_left = 0, r_bit = 0;
    reg [7:0]  r_byte = 0;
    reg        r_on = 0;
    always @(posedge clk) if (rst) r_on = 0;
    else begin
        if (!r_on) begin
            if (!send) begin
                r_on = 1;
                r_left = DIVISOR / 2;
                r_bit = 0;
            end
        end else if (r_left != 0) r_left = r_left - 1;
        else begin
            r_left = DIVISOR - 1;
            if (r_bit == 0 && send) fail("a start bit is short");
            if (r_bit == 9) begin
                if (!send) fail("a stop bit is low");
                if (begins) $display("UART %02x", r_byte);
                r_on = 0;
            end else if (r_bit != 0) r_byte = {send, r_byte[7:1]};
            r_bit = r_bit + 1;
        end
    end

    // The chain: a clock in 4 of the core's, only in scans.
    reg [31:0] j_op = 0, j_a = 0, j_b = 0, j_wait = 0, j_count = 0;
    reg        j_asked = 0, j_over = 0;
    reg [63:0] j_in = 0, j_out = 0;
    always @(posedge clk) if (begins && !j_over) begin
        if (!j_asked) begin
            got = $fscanf(jtag, "%h %h %h", j_op, j_a, j_b);
            if (got != 3) j_over = 1;
            j_asked = 1;
            j_wait = 0;
            j_in = j_op == 3 ? {32'd0, j_b} : {j_a, j_b};
            j_count = j_op == 3 ? j_a : 64;
        end
        if (j_op == 0 || j_op == 3) begin
            // Clock 0 is idle, 1 captures, then the bits, one is idle, one updates.
            case (j_wait % 4)
                0: begin
                    capture <= j_wait / 4 == 1;
                    shift <= j_wait / 4 >= 2 && j_wait / 4 < 2 + j_count;
                    update <= j_wait / 4 == 3 + j_count;
                    tdi <= j_wait / 4 >= 2 && j_in[(j_wait / 4 - 2) & 63];
                end
                1: if (j_wait / 4 >= 2 && j_wait / 4 < 2 + j_count) j_out[(j_wait / 4 - 2) & 63] = tdo;
                2: tck <= 1;
                3: begin
                    tck <= 0;
                    if (j_wait / 4 == 3 + j_count) begin
                        if (j_op == 0) $display("JTAG %016x", j_out);
                        j_asked = 0;
                    end
                end
            endcase
        end else begin
            if (j_op == 2 && j_wait == 0) hold = j_a;
            if (j_op == 2 || j_wait >= j_a) j_asked = 0;
        end
        j_wait = j_wait + 1;
    end

    // The bus host.
    reg [31:0] b_op = 0, b_a = 0, b_b = 0, b_wait = 0;
    reg        b_asked = 0, b_over = 0, b_reading = 0;
    always @(posedge clk) if (begins && !b_over) begin
        if (!b_asked) begin
            got = $fscanf(bus, "%h %h %h", b_op, b_a, b_b);
            if (got != 3) begin
                b_over = 1;
                b_op = 2;
            end
            b_asked = 1;
            b_wait = 0;
        end
        b_wait = b_wait + 1;
        case (b_op)
            0: begin
                bus_address <= b_a[BITS-1:0];
                bus_writedata <= b_b;
                bus_write <= 1;
                if (bus_write && !bus_waitrequest) begin
                    bus_write <= 0;
                    b_asked = 0;
                end
            end
            1: begin
                bus_address <= b_a[BITS-1:0];
                bus_read <= !b_reading;
                if (bus_read && !bus_waitrequest) begin
                    bus_read <= 0;
                    b_reading = 1;
                end
                if (bus_valid) begin
                    bus_read <= 0;
                    b_reading = 0;
                    $display("BUS %0d", bus_readdata);
                    b_asked = 0;
                end
            end
            default: if (b_wait >= b_a) b_asked = 0;
        endcase
    end

    // The programs.
    reg [31:0] p_op = 1, p_a = 0, p_b = 0, p_wait = 0, rests = 0;
    reg        p_asked = 0, p_over = 0;
    always @(posedge clk) if (begins) begin
        start <= 0;
        if (!p_asked && !p_over) begin
            got = $fscanf(program_, "%h %h %h", p_op, p_a, p_b);
            if (got != 3) p_over = 1;
            p_asked = 1;
            p_wait = 0;
        end
        if (!p_over) begin
            p_wait = p_wait + 1;
            if (p_op == 0 && !busy && p_wait > 4) begin
                start <= 1;
                which <= p_a[2:0];
                p_asked = 0;
            end
            if (p_op == 1 && p_wait >= p_a) p_asked = 0;
        end
        rests = s_over && j_over && b_over && p_over && !busy ? rests + 1 : 0;
        if (rests > 30 * DIVISOR) begin
            $display("RESULT failures %0d", failures);
            $display("RESULT trace %0d", trace);
            $display("RESULT total_clocks %0d", clocks);
            $finish;
        end
        if (clocks == clock_limit) fail("the scripts are not over");
    end
endmodule
