// The buses of the module under test, their checkers, the memory and the stream's sink: for the body
// of a bench that has `clk`, `rst`, `module_rst`, `memory_rst`, `sink_probability`, DW, PORTS, BW, WBW
// and PIXELS, the name of the file for the stream. While `stalled` the memory takes nothing. It decodes
// the bits of an address that are set in the plusarg `address_mask`, by default all.
    wire [PORTS*32-1:0] read_address;
    wire [PORTS-1:0]    read_read, read_waitrequest, read_readdatavalid;
    wire [PORTS*BW-1:0] read_burstcount;
    wire [PORTS*DW-1:0] read_readdata;

    wire [31:0]         write_address;
    wire                write_write, write_waitrequest;
    wire [WBW-1:0]      write_burstcount;
    wire [DW-1:0]       write_writedata;
    wire [DW/8-1:0]     write_byteenable;

`define NCDC_READ_PORT(k) \
        .read``k``_address(read_address[32*k +: 32]), .read``k``_read(read_read[k]), \
        .read``k``_burstcount(read_burstcount[BW*k +: BW]), \
        .read``k``_waitrequest(read_waitrequest[k]), \
        .read``k``_readdata(read_readdata[DW*k +: DW]), \
        .read``k``_readdatavalid(read_readdatavalid[k])

    wire [31:0]      memory_errors;
    wire [PORTS-1:0] memory_read_waitrequest;
    wire             memory_write_waitrequest;
    assign read_waitrequest = memory_read_waitrequest | {PORTS{stalled}};
    assign write_waitrequest = memory_write_waitrequest || stalled;
    reg [31:0]       address_mask;
    initial if (!$value$plusargs("address_mask=%d", address_mask)) address_mask = 32'hFFFFFFFF;
    avalon_memory #(
        .PORTS(PORTS), .DATA_WIDTH(DW), .BURST_WIDTH(BW), .WRITE_BURST_WIDTH(WBW),
        .BYTES(`NCDC_MEMORY_BYTES)
    ) memory (
        .clk(clk), .rst(memory_rst), .errors(memory_errors),
        .read_address(read_address & {PORTS{address_mask}}), .read_read(read_read & {PORTS{!stalled}}),
        .read_burstcount(read_burstcount), .read_waitrequest(memory_read_waitrequest),
        .read_readdata(read_readdata), .read_readdatavalid(read_readdatavalid),
        .write_address(write_address & address_mask), .write_write(write_write && !stalled),
        .write_burstcount(write_burstcount), .write_writedata(write_writedata),
        .write_byteenable(write_byteenable), .write_waitrequest(memory_write_waitrequest)
    );

    wire [31:0] read_errors [0:PORTS-1], read_commands [0:PORTS-1];
    wire [31:0] read_beats [0:PORTS-1], read_waits [0:PORTS-1];
    genvar g;
    generate
        for (g = 0; g < PORTS; g = g + 1) begin : reader
            avalon_checker #(
                .NAME(g == 0 ? "read0" : g == 1 ? "read1" : "read2"),
                .DATA_WIDTH(DW), .BURST_WIDTH(BW), .MAX_BURST(1 << (BW - 1))
            ) checker_of_port (
                .clk(clk), .rst(rst), .host_rst(module_rst),
                .memory_rst(memory_rst), .address(read_address[32*g +: 32]), .read(read_read[g]),
                .write(1'b0), .burstcount(read_burstcount[BW*g +: BW]), .writedata({DW{1'b0}}),
                .byteenable({DW/8{1'b0}}), .waitrequest(read_waitrequest[g]),
                .readdatavalid(read_readdatavalid[g]), .errors(read_errors[g]),
                .commands(read_commands[g]), .beats(read_beats[g]), .bytes(),
                .waits(read_waits[g])
            );
        end
    endgenerate

    wire [31:0] write_errors, write_commands, write_beats, write_bytes, write_waits;
    avalon_checker #(
        .NAME("write"), .DATA_WIDTH(DW), .BURST_WIDTH(WBW), .MAX_BURST(1 << (WBW - 1))
    ) write_checker (
        .clk(clk), .rst(rst), .host_rst(module_rst), .memory_rst(memory_rst),
        .address(write_address), .read(1'b0),
        .write(write_write), .burstcount(write_burstcount), .writedata(write_writedata),
        .byteenable(write_byteenable), .waitrequest(write_waitrequest), .readdatavalid(1'b0),
        .errors(write_errors), .commands(write_commands), .beats(write_beats),
        .bytes(write_bytes), .waits(write_waits)
    );

    wire [31:0] csr_errors;
    avalon_checker #(.NAME("csr"), .DATA_WIDTH(32), .BURST_WIDTH(2), .MAX_BURST(1)) csr_checker (
        .clk(clk), .rst(rst), .host_rst(1'b0), .memory_rst(1'b0),
        .address({csr_address, 2'b00}), .read(csr_read),
        .write(csr_write), .burstcount(2'd1), .writedata(csr_writedata), .byteenable(4'hF),
        .waitrequest(csr_waitrequest), .readdatavalid(csr_readdatavalid),
        .errors(csr_errors), .commands(), .beats(), .bytes(), .waits()
    );

`ifdef NCDC_STREAM
    localparam SP = `NCDC_STREAM;       // pixels of a beat
    wire        stream_valid, stream_startofpacket, stream_endofpacket;
    wire [24*SP-1:0] stream_data;
    reg         stream_ready = 0;
    wire [31:0] stream_errors, stream_beats, stream_packets, stream_waits;
    reg  [31:0] sink_random = 32'h2545F491, stream_bytes = 0;
    stream_checker #(.NAME("stream"), .WIDTH(24 * SP)) stream_checker (
        .clk(clk), .rst(rst), .host_rst(module_rst), .valid(stream_valid), .ready(stream_ready),
        .data(stream_data), .startofpacket(stream_startofpacket), .endofpacket(stream_endofpacket),
        .errors(stream_errors), .beats(stream_beats), .packets(stream_packets),
        .waits(stream_waits)
    );

    integer pixels, lane;
    initial pixels = $fopen(PIXELS, "wb");
    always @(posedge clk) begin
        sink_random = sink_random ^ (sink_random << 13);
        sink_random = sink_random ^ (sink_random >> 17);
        sink_random = sink_random ^ (sink_random << 5);
        stream_ready <= sink_random[15:8] < sink_probability;
        if (!rst && stream_valid && stream_ready)
            for (lane = 0; lane < SP; lane = lane + 1) begin
                $fwrite(pixels, "%c%c%c", stream_data[24*lane+16 +: 8],
                        stream_data[24*lane+8 +: 8], stream_data[24*lane +: 8]);
                stream_bytes = stream_bytes + 3;
            end
    end
`else
    wire [31:0] stream_errors = 0;
`endif
