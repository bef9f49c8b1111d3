// Avalon-MM memory made of a LiteDRAM core: the ports of `avalon_memory`, each bridged to a native
// port of the controller. A word is RATIO native words.
//
// Reads are pipelined: a burst becomes one native command per clock, the next burst follows without
// a gap, and the controller returns the words of a port in order. A write's native words wait in a
// queue until the controller fetches them, some clocks after their commands.
//
// Defines: NCDC_LITEDRAM_NATIVE (bits), NCDC_LITEDRAM_ADDRESS (bits of a native word's address).

`timescale 1ns/1ps

module avalon_memory #(
    parameter PORTS = 1,
    parameter DATA_WIDTH = 32,
    parameter BURST_WIDTH = 5,
    parameter WRITE_BURST_WIDTH = 5,
    parameter BYTES = 65536
) (
    input  wire                          clk,
    input  wire                          rst,
    output reg  [31:0]                   errors,

    input  wire [PORTS*32-1:0]           read_address,  // bytes
    input  wire [PORTS-1:0]              read_read,
    input  wire [PORTS*BURST_WIDTH-1:0]  read_burstcount,
    output wire [PORTS-1:0]              read_waitrequest,
    output reg  [PORTS*DATA_WIDTH-1:0]   read_readdata,
    output reg  [PORTS-1:0]              read_readdatavalid,

    input  wire [31:0]                   write_address, // bytes
    input  wire                          write_write,
    input  wire [WRITE_BURST_WIDTH-1:0]  write_burstcount,
    input  wire [DATA_WIDTH-1:0]         write_writedata,
    input  wire [DATA_WIDTH/8-1:0]       write_byteenable,
    output wire                          write_waitrequest
);
    localparam NATIVE = `NCDC_LITEDRAM_NATIVE;
    localparam ADDRESS = `NCDC_LITEDRAM_ADDRESS;
    localparam LANES = NATIVE / 8;
    localparam RATIO = DATA_WIDTH / NATIVE;
    localparam ALL = PORTS + 1;         // native ports, the last one writes
    localparam QUEUE = 64;              // native words to write

    wire [ALL-1:0]         cmd_valid, cmd_ready, wdata_ready, rdata_valid;
    wire [ALL*ADDRESS-1:0] cmd_addr;
    wire [ALL*NATIVE-1:0]  rdata;

    // Reading.
    reg [31:0] read_word [0:PORTS-1];   // next native word to ask for
    reg [15:0] read_left [0:PORTS-1];   // native words of the burst to ask for
    reg [7:0]  got       [0:PORTS-1];   // native words of the next word that have come
    integer    p;

    genvar g;
    generate
        for (g = 0; g < PORTS; g = g + 1) begin : reader
            assign cmd_valid[g] = read_left[g] != 0;
            assign cmd_addr[ADDRESS*g +: ADDRESS] = read_word[g];
            assign read_waitrequest[g] = rst || read_left[g] > 1
                                         || (read_left[g] == 1 && !cmd_ready[g]);
        end
    endgenerate

    always @(posedge clk) begin
        read_readdatavalid <= 0;
        for (p = 0; p < PORTS; p = p + 1) begin
            if (cmd_valid[p] && cmd_ready[p]) begin
                read_word[p] <= read_word[p] + 1;
                read_left[p] <= read_left[p] - 1;
            end
            if (read_read[p] && !read_waitrequest[p]) begin
                read_word[p] <= read_address[32*p +: 32] / LANES;
                read_left[p] <= read_burstcount[BURST_WIDTH*p +: BURST_WIDTH] * RATIO;
            end
            if (rdata_valid[p]) begin
                read_readdata[DATA_WIDTH*p + NATIVE*got[p] +: NATIVE] <= rdata[NATIVE*p +: NATIVE];
                read_readdatavalid[p] <= got[p] == RATIO - 1;
                got[p] <= got[p] == RATIO - 1 ? 0 : got[p] + 1;
            end
            if (rst) begin
                read_left[p] <= 0;
                got[p] <= 0;
            end
        end
    end

    // Writing: one word is held while its native words are sent.
    reg [DATA_WIDTH-1:0]   data;
    reg [DATA_WIDTH/8-1:0] enable;
    reg [31:0] write_word;              // next native word to send
    reg [15:0] write_left;              // words of the burst still to come
    reg [7:0]  sent;                    // native words of the held word
    reg        held;
    reg [NATIVE+LANES-1:0] queue [0:QUEUE-1];
    reg [31:0] queue_in, queue_out;
    wire       space = queue_in - queue_out < QUEUE;
    wire       sending = held && space && cmd_ready[PORTS];
    wire [NATIVE+LANES-1:0] first = queue[queue_out % QUEUE];

    assign cmd_valid[PORTS] = held && space;
    assign cmd_addr[ADDRESS*PORTS +: ADDRESS] = write_word;
    assign write_waitrequest = rst || (held && !(sending && sent == RATIO - 1));

    always @(posedge clk) begin
        if (sending) begin
            queue[queue_in % QUEUE] <= {enable[LANES*sent +: LANES], data[NATIVE*sent +: NATIVE]};
            queue_in <= queue_in + 1;
            write_word <= write_word + 1;
            sent <= sent + 1;
            if (sent == RATIO - 1)
                held <= 0;
        end
        if (write_write && !write_waitrequest) begin
            data <= write_writedata;
            enable <= write_byteenable;
            held <= 1;
            sent <= 0;
            write_left <= (write_left == 0 ? write_burstcount : write_left) - 1;
            if (write_left == 0)
                write_word <= write_address / LANES;
        end
        if (wdata_ready[PORTS])
            queue_out <= queue_out + 1;
        if (wdata_ready[PORTS] && queue_in == queue_out) begin
            $display("AVALON-ERROR memory write-underrun %0t", $time);
            errors <= errors + 1;
        end
        if (rst) begin
            errors <= 0;
            held <= 0;
            write_left <= 0;
            queue_in <= 0;
            queue_out <= 0;
        end
    end

    litedram_core core (
        .clk(clk), .cmd_valid(cmd_valid), .cmd_ready(cmd_ready), .cmd_we({1'b1, {PORTS{1'b0}}}),
        .cmd_addr(cmd_addr), .wdata_valid({queue_in != queue_out, {PORTS{1'b0}}}),
        .wdata_ready(wdata_ready), .wdata({first[0 +: NATIVE], {PORTS*NATIVE{1'b0}}}),
        .wdata_we({first[NATIVE +: LANES], {PORTS*LANES{1'b0}}}), .rdata_valid(rdata_valid),
        .rdata(rdata)
    );

    // Content, as of `avalon_memory`: byte 0 is the least significant one of a word.
    task load(input integer file, input [31:0] base, input [31:0] bytes);
        integer i, j;
        reg [NATIVE-1:0] value;
        begin
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1) begin
                for (j = 0; j < LANES; j = j + 1)
                    value[8*j +: 8] = $fgetc(file);
                core.poke(i, value);
            end
        end
    endtask

    task fill(input [31:0] base, input [31:0] bytes, input [7:0] value);
        integer i;
        begin
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1)
                core.poke(i, {LANES{value}});
        end
    endtask

    task put(input [31:0] address, input [7:0] value);
        reg [NATIVE-1:0] word;
        begin
            word = core.peek(address / LANES);
            word[8 * (address % LANES) +: 8] = value;
            core.poke(address / LANES, word);
        end
    endtask

    task save(input integer file, input [31:0] base, input [31:0] bytes);
        integer i, j;
        reg [NATIVE-1:0] value;
        begin
            for (i = base / LANES; i < (base + bytes + LANES - 1) / LANES; i = i + 1) begin
                value = core.peek(i);
                for (j = 0; j < LANES; j = j + 4)
                    $fwrite(file, "%u", value[8*j +: 32]);
            end
        end
    endtask
endmodule
