// An AXI4 manager's ports on a memory with Avalon-MM ports, of no code of the gateware's: one module
// for reads, one for writes. Without the plusargs they add no clock.
//
// Plusargs: axi_wait, of 256 clocks, those in which a channel is not ready; axi_answer, maximum delay
// of an answer to a write, in clocks; axi_seed; axi_fail, the number of the burst, from 1 on, that is
// answered with SLVERR, of reads and of writes.

`timescale 1ns/1ps

module axi_read_memory #(
    parameter DATA_WIDTH = 32,
    parameter BURST_WIDTH = 5,
    parameter NUMBER = 0
) (
    input  wire                   clk, memory_rst,
    input  wire [31:0]            araddr,
    input  wire [7:0]             arlen,
    input  wire                   arvalid,
    output wire                   arready,
    output wire [DATA_WIDTH-1:0]  rdata,
    output wire [1:0]             rresp,
    output wire                   rlast, rvalid,
    output wire [31:0]            address,
    output wire                   read,
    output wire [BURST_WIDTH-1:0] burstcount,
    input  wire                   waitrequest,
    input  wire [DATA_WIDTH-1:0]  readdata,
    input  wire                   readdatavalid
);
    localparam DEPTH = 64;
    integer    wait_probability, seed, failing;
    reg        open = 1;                // a command may pass
    reg [31:0] random, head, count, beat, bursts;
    reg [7:0]  length [0:DEPTH-1];     // of bursts that are read, the oldest at head

    initial begin
        if (!$value$plusargs("axi_wait=%d", wait_probability)) wait_probability = 0;
        if (!$value$plusargs("axi_seed=%d", seed)) seed = 1;
        if (!$value$plusargs("axi_fail=%d", failing)) failing = 0;
        random = 32'h2545F491 ^ (32'h9E3779B9 * (seed + 3 * NUMBER));
        head = 0; count = 0; beat = 0; bursts = 0;
    end

    assign address = araddr, burstcount = arlen + 1, read = arvalid && open;
    assign arready = open && !waitrequest;
    assign rdata = readdata, rvalid = readdatavalid && count != 0;
    assign rlast = beat == length[head];
    assign rresp = failing != 0 && bursts + 1 == failing ? 2'b10 : 2'b00;

    always @(posedge clk) begin
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        // What has been shown to the memory stays until it is taken.
        if (!read || !waitrequest)
            open <= random[15:8] >= wait_probability;
        if (memory_rst) begin
            count = 0;
            beat = 0;
        end else begin
            if (rvalid) begin
                beat <= rlast ? 0 : beat + 1;
                if (rlast) begin
                    bursts <= bursts + 1;
                    head <= (head + 1) % DEPTH;
                end
            end
            if (arvalid && arready)
                length[(head + count) % DEPTH] <= arlen;
            count <= count + (arvalid && arready) - (rvalid && rlast);
        end
    end
endmodule

module axi_write_memory #(
    parameter DATA_WIDTH = 32,
    parameter BURST_WIDTH = 5
) (
    input  wire                    clk, memory_rst,
    input  wire [31:0]             awaddr,
    input  wire [7:0]              awlen,
    input  wire                    awvalid,
    output wire                    awready,
    input  wire [DATA_WIDTH-1:0]   wdata,
    input  wire [DATA_WIDTH/8-1:0] wstrb,
    input  wire                    wlast, wvalid,
    output wire                    wready,
    output wire                    bvalid,
    output wire [1:0]              bresp,
    input  wire                    bready,
    output wire [31:0]             address,
    output wire                    write,
    output wire [BURST_WIDTH-1:0]  burstcount,
    output wire [DATA_WIDTH-1:0]   writedata,
    output wire [DATA_WIDTH/8-1:0] byteenable,
    input  wire                    waitrequest,
    output wire                    unanswered       // a burst that is begun has no answer yet
);
    localparam DEPTH = 64;
    integer    wait_probability, seed, failing, late;
    reg        named_open = 1, open = 1;        // an address, a word may pass
    reg [31:0] random, now, bursts;
    reg [31:0] head, count;                     // of addresses that are stored
    reg [31:0] stored [0:DEPTH-1];
    reg [7:0]  length [0:DEPTH-1];
    reg [31:0] due_head, due_count;             // of answers
    reg [31:0] due [0:DEPTH-1];                // their earliest clocks
    reg [31:0] last_due;

    initial begin
        if (!$value$plusargs("axi_wait=%d", wait_probability)) wait_probability = 0;
        if (!$value$plusargs("axi_answer=%d", late)) late = 0;
        if (!$value$plusargs("axi_seed=%d", seed)) seed = 1;
        if (!$value$plusargs("axi_fail=%d", failing)) failing = 0;
        random = 32'h5851F42D ^ (32'h9E3779B9 * seed);
        now = 0; bursts = 0; head = 0; count = 0; due_head = 0; due_count = 0; last_due = 0;
    end

    // Of the burst whose words come: an address that comes in this clock counts.
    wire there = count != 0 || awvalid && awready;
    assign awready = named_open && count < 8;
    assign address = count != 0 ? stored[head] : awaddr;
    assign burstcount = (count != 0 ? length[head] : awlen) + 1;
    assign write = wvalid && there && open;
    assign wready = there && open && !waitrequest;
    assign writedata = wdata, byteenable = wstrb;
    assign bvalid = due_count != 0 && due[due_head] <= now;
    assign bresp = failing != 0 && bursts + 1 == failing ? 2'b10 : 2'b00;
    assign unanswered = count != 0 || due_count != 0;

    wire ended = wvalid && wready && wlast;
    wire [31:0] wish = now + 1 + random[31:16] % (late + 1);
    wire [31:0] next_due = wish > last_due ? wish : last_due + 1;

    always @(posedge clk) begin
        now <= now + 1;
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        // An address is stored here if it is taken before its words are; words that were shown stay.
        named_open <= random[7:0] >= wait_probability;
        if (!write || !waitrequest)
            open <= random[15:8] >= wait_probability;
        if (memory_rst) begin
            count <= 0;
            due_count <= 0;
        end else begin
            if (awvalid && awready) begin
                stored[(head + count) % DEPTH] <= awaddr;
                length[(head + count) % DEPTH] <= awlen;
            end
            if (ended) begin
                head <= (head + 1) % DEPTH;
                due[(due_head + due_count) % DEPTH] <= next_due;
                last_due <= next_due;
            end
            if (bvalid && bready) begin
                due_head <= (due_head + 1) % DEPTH;
                bursts <= bursts + 1;
            end
            count <= count + (awvalid && awready) - ended;
            due_count <= due_count + ended - (bvalid && bready);
        end
    end
endmodule

// An Avalon-MM host's accesses to registers on an AXI4-Lite subordinate.
module axi_lite_host #(
    parameter ADDRESS_BITS = 14
) (
    input  wire                    clk, memory_rst,
    input  wire [ADDRESS_BITS-1:0] address,
    input  wire                    read, write,
    input  wire [31:0]             writedata,
    output reg  [31:0]             readdata,
    output reg                     readdatavalid,
    output reg                     waitrequest,
    output wire [ADDRESS_BITS+1:0] awaddr, araddr,
    output wire [31:0]             wdata,
    output reg                     awvalid, wvalid, arvalid, rready, bready,
    input  wire                    awready, wready, arready, rvalid, bvalid,
    input  wire [31:0]             rdata,
    input  wire [1:0]              rresp, bresp
);
    integer    wait_probability;
    reg [31:0] random;
    reg        named, given, asked, over;       // what the access has done

    initial begin
        if (!$value$plusargs("axi_wait=%d", wait_probability)) wait_probability = 0;
        random = 32'h1B873593;
        {named, given, asked, over} = 0;
        {awvalid, wvalid, arvalid, rready, bready, readdatavalid} = 0;
        waitrequest = 1;
    end

    assign awaddr = {address, 2'b00}, araddr = {address, 2'b00}, wdata = writedata;

    always @(posedge clk) begin
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        readdatavalid <= 0;
        waitrequest <= 1;
        if (memory_rst) begin
            {named, given, asked, over} <= 0;
            {awvalid, wvalid, arvalid, rready, bready} <= 0;
        end else begin
            rready <= random[23:16] >= wait_probability;
            bready <= random[31:24] >= wait_probability;
            if (awvalid && awready) awvalid <= 0;
            if (wvalid && wready) wvalid <= 0;
            if (arvalid && arready) arvalid <= 0;
            if (write && waitrequest && !over) begin
                if (!named && random[7:0] >= wait_probability) begin
                    awvalid <= 1;
                    named <= 1;
                end
                if (!given && random[15:8] >= wait_probability) begin
                    wvalid <= 1;
                    given <= 1;
                end
            end
            if (read && waitrequest && !over && !asked && random[7:0] >= wait_probability) begin
                arvalid <= 1;
                asked <= 1;
            end
            if (bvalid && bready || rvalid && rready) begin
                waitrequest <= 0;
                over <= 1;
                readdata <= rdata;
                if (bvalid && bready ? bresp != 0 : rresp != 0)
                    $display("AXI-ERROR csr response %0t", $time);
            end
            if (over && !waitrequest) begin
                readdatavalid <= asked;
                {named, given, asked, over} <= 0;
            end
        end
    end
endmodule
