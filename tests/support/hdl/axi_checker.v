// Protocol checker of one AXI4 manager's port, all five channels.
//
// Each violation counts in `errors`; the first 40 print "AXI-ERROR <port> <rule> <time>":
//   held             once valid is high, valid and its payload stay until ready, of each channel
//   in-reset         no valid of the manager in reset, but for its first two clocks
//   burst            INCR, of whole words, aligned, of at most MAX_BURST, not exclusive, ID 0
//   page             no burst crosses the end of 4 KB
//   last             wlast with the last word of its burst and no other
//   no-address       a burst's words do not end before its address is offered
//   outstanding      at most PENDING bursts of a direction wait for their end
//   unrequested      a word or an answer of the memory comes only if it is due
//   answer-early     the answer to a write comes when its last word is accepted, or later
//   read-last        rlast with the last word of its burst and no other; its ID is 0
//   unknown          no X or Z on control out of reset, nor on what it qualifies (four states)
// Unused halves are tied to 0. Counters: bursts, words.

`timescale 1ns/1ps

module axi_checker #(
    parameter NAME = "port",
    parameter DATA_WIDTH = 32,
    parameter MAX_BURST = 16,
    parameter PENDING = 4
) (
    input  wire                    clk,
    input  wire                    resetn,
    input  wire                    arid, arlock, arvalid, arready,
    input  wire [31:0]             araddr,
    input  wire [7:0]              arlen,
    input  wire [2:0]              arsize,
    input  wire [1:0]              arburst,
    input  wire                    rid, rlast, rvalid, rready,
    input  wire [1:0]              rresp,
    input  wire [DATA_WIDTH-1:0]   rdata,
    input  wire                    awid, awlock, awvalid, awready,
    input  wire [31:0]             awaddr,
    input  wire [7:0]              awlen,
    input  wire [2:0]              awsize,
    input  wire [1:0]              awburst,
    input  wire [DATA_WIDTH-1:0]   wdata,
    input  wire [DATA_WIDTH/8-1:0] wstrb,
    input  wire                    wlast, wvalid, wready,
    input  wire                    bid, bvalid, bready,
    input  wire [1:0]              bresp,
    output reg  [31:0]             errors,
    output reg  [31:0]             reads, writes, words_read, words_written
);
    localparam LANES = DATA_WIDTH / 8;
    localparam DEPTH = 64;             // of the queues below
    localparam ADDRESS = 32 + 8 + 3 + 2 + 1 + 1;

    wire [ADDRESS-1:0] ar = {araddr, arlen, arsize, arburst, arlock, arid};
    wire [ADDRESS-1:0] aw = {awaddr, awlen, awsize, awburst, awlock, awid};
    wire [DATA_WIDTH+LANES:0] w = {wdata, wstrb, wlast};
    wire [DATA_WIDTH+3:0] r = {rdata, rresp, rlast, rid};
    wire [2:0] b = {bresp, bid};

    reg ar_waits, aw_waits, w_waits, r_waits, b_waits;      // valid without ready, a clock ago
    reg [ADDRESS-1:0] ar_was, aw_was;
    reg [DATA_WIDTH+LANES:0] w_was;
    reg [DATA_WIDTH+3:0] r_was;
    reg [2:0] b_was;
    reg [7:0]  read_len [0:DEPTH-1];   // of bursts accepted, the oldest at read_head
    reg [31:0] read_head, read_count, read_beat;
    reg [7:0]  write_len [0:DEPTH-1];  // of bursts offered whose words are not complete
    reg [31:0] write_head, write_count, write_beat;
    reg [31:0] complete;                // bursts with address and words accepted, not answered
    reg [31:0] addresses, bodies;       // bursts whose address is accepted, whose words are
    reg [31:0] owed;                    // write bursts offered and not answered
    reg        aw_seen;                 // the address that is offered is in the queue
    reg [1:0]  low;                     // clocks of reset

    task violation(input [8*16-1:0] rule);
        begin
            if (errors < 40)
                $display("AXI-ERROR %0s %0s %0t", NAME, rule, $time);
            errors = errors + 1;
        end
    endtask

    // The rules of one burst's address.
    task address(input [31:0] addr, input [7:0] len, input [2:0] size, input [1:0] burst,
                 input lock, input id);
        begin
            if (burst !== 2'b01 || (1 << size) != LANES || addr % LANES != 0
                    || 32'd0 + len >= MAX_BURST || lock !== 0 || id !== 0)
                violation("burst");
            if (addr[31:12] != ((addr + LANES * (32'd1 + len) - 1) >> 12))
                violation("page");
        end
    endtask

    task forget;
        begin
            ar_waits = 0; aw_waits = 0; w_waits = 0; r_waits = 0; b_waits = 0;
            read_head = 0; read_count = 0; read_beat = 0;
            write_head = 0; write_count = 0; write_beat = 0;
            complete = 0; addresses = 0; bodies = 0; owed = 0; aw_seen = 0;
        end
    endtask

    initial begin
        errors = 0; reads = 0; writes = 0; words_read = 0; words_written = 0; low = 0;
        forget;
    end

    always @(posedge clk) begin
        if (!resetn) begin
            forget;
            if (low == 3) begin
                if (arvalid !== 0 || awvalid !== 0 || wvalid !== 0)
                    violation("in-reset");
            end else
                low = low + 1;
        end else begin
            low = 0;
            if (^{arvalid, awvalid, wvalid, rready, bready, rvalid, bvalid, arready, awready,
                  wready} === 1'bx)
                violation("unknown");
            if ((ar_waits && (arvalid !== 1 || ar !== ar_was))
                    || (aw_waits && (awvalid !== 1 || aw !== aw_was))
                    || (w_waits && (wvalid !== 1 || w !== w_was))
                    || (r_waits && (rvalid !== 1 || r !== r_was))
                    || (b_waits && (bvalid !== 1 || b !== b_was)))
                violation("held");

            // Reads: words of bursts of earlier clocks, then this clock's burst.
            if (rvalid === 1 && rready === 1) begin
                words_read = words_read + 1;
                if (read_count == 0)
                    violation("unrequested");
                else begin
                    if (rlast !== (read_beat == read_len[read_head]) || rid !== 0)
                        violation("read-last");
                    read_beat = read_beat + 1;
                    if (read_beat > read_len[read_head]) begin
                        read_beat = 0;
                        read_head = (read_head + 1) % DEPTH;
                        read_count = read_count - 1;
                    end
                end
            end
            if (arvalid === 1 && !ar_waits) begin
                if (^ar === 1'bx)
                    violation("unknown");
                else
                    address(araddr, arlen, arsize, arburst, arlock, arid);
                if (read_count >= PENDING)
                    violation("outstanding");
            end
            if (arvalid === 1 && arready === 1) begin
                reads = reads + 1;
                read_len[(read_head + read_count) % DEPTH] = arlen;
                read_count = read_count + 1;
            end

            // Writes: answers to what was complete before this clock.
            if (bvalid === 1 && !b_waits) begin
                if (complete == 0)
                    violation(addresses == 0 && bodies == 0 && write_count == 0 ? "unrequested"
                                                                            : "answer-early");
            end
            if (bvalid === 1 && bready === 1 && complete != 0) begin
                complete = complete - 1;
                owed = owed - 1;
            end
            if (awvalid === 1 && !aw_seen) begin
                aw_seen = 1;
                if (^aw === 1'bx)
                    violation("unknown");
                else
                    address(awaddr, awlen, awsize, awburst, awlock, awid);
                if (owed >= PENDING)
                    violation("outstanding");
                owed = owed + 1;
                write_len[(write_head + write_count) % DEPTH] = awlen;
                write_count = write_count + 1;
            end
            if (wvalid === 1 && !w_waits) begin
                if (^{wlast, wstrb} === 1'bx)
                    violation("unknown");
                if (write_count == 0)
                    violation("no-address");
                else if (wlast !== (write_beat == write_len[write_head]))
                    violation("last");
            end
            if (wvalid === 1 && wready === 1) begin
                words_written = words_written + 1;
                write_beat = write_beat + 1;
                if (write_count != 0 && write_beat > write_len[write_head]) begin
                    write_beat = 0;
                    write_head = (write_head + 1) % DEPTH;
                    write_count = write_count - 1;
                    bodies = bodies + 1;
                end
            end
            if (awvalid === 1 && awready === 1) begin
                writes = writes + 1;
                addresses = addresses + 1;
                aw_seen = 0;
            end
            // Words may be accepted before their address.
            if (addresses != 0 && bodies != 0) begin
                addresses = addresses - 1;
                bodies = bodies - 1;
                complete = complete + 1;
            end
            ar_waits = arvalid === 1 && arready !== 1;
            aw_waits = awvalid === 1 && awready !== 1;
            w_waits = wvalid === 1 && wready !== 1;
            r_waits = rvalid === 1 && rready !== 1;
            b_waits = bvalid === 1 && bready !== 1;
            ar_was = ar;
            aw_was = aw;
            w_was = w;
            r_was = r;
            b_was = b;
        end
    end
endmodule
