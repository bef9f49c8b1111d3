// A packetiser, module `packetiser`, between a memory of frames, a host with a script and a line that
// takes beats at random.
//
// The file script.txt holds lines of three hexadecimal numbers, operation, a and b:
//   0        end
//   1 a b    write b to the register at word address a
//   2 a      read it                                     READ value
//   3 a b    read register b until its bits of a are 0   STATUS value
//   4 a      wait for a clocks
//   5 a b    reset for a clocks, of the memory as well if b is 1
//   6 a      wait for the interrupt                      IRQ
//
// Lines: those, RESULT lines at the end, PACKET first-clock last-clock bytes for each packet. FAILED if a packet
// has a pause, a beat changes while it waits, or the run does not end in clock_limit clocks. The memory
// decodes the lower bits of an address only. RESULT trace is a hash of all outputs in all clocks.
// Plusargs: stall, clocks of 256 in which no beat is taken; clock_limit; those of avalon_memory.

`timescale 1ns/1ps

module packets_bench (input wire clk);
    localparam DW = `NCDC_DATA_WIDTH;
    localparam BYTES = `NCDC_MEMORY_BYTES;
    localparam END = 0, WRITE = 1, READ = 2, UNTIL = 3, WAIT = 4, RESET = 5, IRQ = 6;

    reg [31:0] stall, clock_limit, random = 32'h2545F491;
    integer    script, content, got;
    initial begin
        if (!$value$plusargs("stall=%d", stall)) stall = 0;
        if (!$value$plusargs("clock_limit=%d", clock_limit)) clock_limit = 0;
        script = $fopen("script.txt", "r");
        content = $fopen("content.bin", "rb");
        memory.load(content, 0, BYTES);
    end

    reg         rst = 1, first_rst = 1, memory_rst = 1, ready = 0;
    reg  [9:0]  address = 0;
    reg         read = 0, write = 0;
    reg  [31:0] writedata = 0;
    wire [31:0] readdata, bus_address;
    wire        readdatavalid, waitrequest, valid, bus_read, bus_waitrequest, bus_valid, irq;
    wire [34:0] payload;
    wire [4:0]  bus_burstcount;
    wire [DW-1:0] bus_readdata;
    wire [31:0] memory_errors, bus_errors, csr_errors;

    packetiser dut (
        .clk(clk), .rst(rst), .memory_rst(memory_rst), .irq(irq),
        .csr__address(address), .csr__read(read), .csr__write(write), .csr__writedata(writedata),
        .csr__readdata(readdata), .csr__readdatavalid(readdatavalid),
        .csr__waitrequest(waitrequest),
        .o__valid(valid), .o__ready(ready), .o__payload(payload),
        .bus__address(bus_address), .bus__read(bus_read), .bus__burstcount(bus_burstcount),
        .bus__waitrequest(bus_waitrequest), .bus__readdata(bus_readdata),
        .bus__readdatavalid(bus_valid)
    );
    avalon_memory #(.PORTS(1), .DATA_WIDTH(DW), .BURST_WIDTH(5), .BYTES(BYTES)) memory (
        .clk(clk), .rst(memory_rst), .errors(memory_errors),
        .read_address(bus_address & (BYTES - 1)), .read_read(bus_read), .read_burstcount(bus_burstcount),
        .read_waitrequest(bus_waitrequest), .read_readdata(bus_readdata),
        .read_readdatavalid(bus_valid),
        .write_address(32'd0), .write_write(1'b0), .write_burstcount(5'd1),
        .write_writedata({DW{1'b0}}), .write_byteenable({DW/8{1'b0}}), .write_waitrequest()
    );
    avalon_checker #(.NAME("bus"), .DATA_WIDTH(DW), .BURST_WIDTH(5), .MAX_BURST(16)) bus_checker (
        .clk(clk), .rst(first_rst), .host_rst(rst), .memory_rst(memory_rst),
        .address(bus_address), .read(bus_read), .write(1'b0), .burstcount(bus_burstcount),
        .writedata({DW{1'b0}}), .byteenable({DW/8{1'b0}}), .waitrequest(bus_waitrequest),
        .readdatavalid(bus_valid), .errors(bus_errors), .commands(), .beats(), .bytes(), .waits()
    );
    avalon_checker #(.NAME("csr"), .DATA_WIDTH(32), .BURST_WIDTH(2), .MAX_BURST(1)) csr_checker (
        .clk(clk), .rst(first_rst), .host_rst(rst), .memory_rst(rst),
        .address({20'd0, address, 2'b00}), .read(read), .write(write), .burstcount(2'd1),
        .writedata(writedata), .byteenable(4'hF), .waitrequest(waitrequest),
        .readdatavalid(readdatavalid), .errors(csr_errors), .commands(), .beats(), .bytes(),
        .waits()
    );
    wire [63:0] trace;
    digest #(.WORDS(4)) digest (.clk(clk), .sum(trace), .value({
        valid ? payload[31:0] : 32'd0, bus_read ? bus_address : 32'd0,
        readdatavalid ? readdata : 32'd0,
        6'd0, irq, readdatavalid, waitrequest && (read || write), bus_read,
        bus_read ? bus_burstcount : 5'd0, valid ? payload[34:32] : 3'd0, 13'd0, valid}));

    // The line.
    reg [7:0]  packet [0:65535];
    reg [31:0] count = 0, began = 0, clocks = 0;
    reg        waits = 0;
    reg [34:0] held = 0;
    integer    k;
    task fail(input [8*40-1:0] reason);
        begin
            $display("FAILED %0s in clock %0d", reason, clocks);
            $finish;
        end
    endtask
    always @(posedge clk) begin
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        ready <= random[15:8] >= stall;
        waits <= valid && !ready && !rst;
        held <= payload;
        if (rst) count = 0;
        else begin
            if (count != 0 && !valid) fail("a pause within a packet");
            if (waits && (!valid || held != payload)) fail("a beat changes while it waits");
            if (valid && ready) begin
                if (count == 0) began = clocks;
                if (payload[33:32] != 0 && !payload[34]) fail("bytes are missing within a packet");
                for (k = 0; k < 4 - payload[33:32]; k = k + 1)
                    packet[count + k] = payload[8*k +: 8];
                count = count + 4 - payload[33:32];
                if (count > 65000) fail("a packet does not end");
                if (payload[34]) begin
                    $write("PACKET %0d %0d ", began, clocks);
                    for (k = 0; k < count; k = k + 1) $write("%02x", packet[k]);
                    $write("\n");
                    count = 0;
                end
            end
        end
    end

    // The host.
    reg [31:0] operation = 0, a = 0, b = 0, waited = 0;
    reg        asked = 0, reading = 0;
    always @(posedge clk) begin
        clocks = clocks + 1;
        first_rst <= clocks < 8;
        rst <= clocks < 8 || operation == RESET && asked && waited <= a;
        memory_rst <= clocks < 8 || operation == RESET && asked && waited <= a && b[0];
        if (clocks == clock_limit) fail("the run does not end");
        if (clocks > 16) begin
            if (!asked) begin
                got = $fscanf(script, "%h %h %h", operation, a, b);
                if (got != 3) operation = END;
                asked = 1;
                waited = 0;
            end
            waited = waited + 1;
            case (operation)
                WRITE: begin
                    address <= a[9:0];
                    writedata <= b;
                    write <= 1;
                    if (write && !waitrequest) begin
                        write <= 0;
                        asked = 0;
                    end
                end
                READ, UNTIL: begin
                    address <= operation == READ ? a[9:0] : b[9:0];
                    read <= !reading;
                    if (read && !waitrequest) begin
                        read <= 0;
                        reading = 1;
                    end
                    if (reading && readdatavalid) begin
                        read <= 0;
                        reading = 0;
                        if (operation == READ || (readdata & a) == 0) begin
                            $display("%0s %0d", operation == READ ? "READ" : "STATUS", readdata);
                            asked = 0;
                        end
                    end
                end
                WAIT: if (waited >= a) asked = 0;
                RESET: if (waited > a) asked = 0;
                IRQ: if (irq) begin
                    $display("IRQ");
                    asked = 0;
                end
                default: begin
                    $display("RESULT bus_errors %0d", bus_errors);
                    $display("RESULT csr_errors %0d", csr_errors);
                    $display("RESULT memory_errors %0d", memory_errors);
                    $display("RESULT irq %0d", irq);
                    $display("RESULT trace %0d", trace);
                    $display("RESULT total_clocks %0d", clocks);
                    $finish;
                end
            endcase
        end
    end
endmodule
