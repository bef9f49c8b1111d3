// Runs the generated module `ncdc_system` with a sensor at its pins and a memory at its ports, under a
// host that talks to it through this program's input and output: whoever runs it reads and writes
// registers while sensor, system and memory go on at the simulator's own speed.
//
// A command is a line of three hexadecimal numbers, operation, a and b; it is answered by one line,
// with the clocks since the start as its last number:
//   0        end                                          RESULT lines, then END
//   1 a b    write b to the register at word address a    DONE
//   2 a      read                                         READ value
//   3 a      wait for irq, for at most a clocks           IRQ 1, or 0 if it did not come
//   4 a      wait for a clocks                            DONE
//   5 a b    save memory a .. a + b - 1 in memory.bin     DONE
//   6 a      reset the module alone for a clocks          DONE
//   7 a      reset the module and the memory              DONE
//   8 a      the memory takes nothing for a clocks        DONE, at once
//   9 a      the sensor's reset is released if a is 1     DONE
//   a        flush stream.bin                             STREAM bytes
//   b a      send the first a bytes of usb_send.bin by USB     DONE, at once
//   c        flush usb_got.bin, what has come by USB      STREAM bytes
//   d        counters so far                              RESULT lines, then DONE
// The clocks of the system and of the sensor come from the program around this module, each with
// its own period. Memory that was not written holds 0xA5. SDA and SCL are pulled up.
//
// RESULT trace is a hash of all outputs of the system in all clocks, as far as they are valid; so is
// TRACE, which is printed each time that `trace_every` (plusarg) clocks are over, 0: never.
// Lines that come unasked: AVALON-ERROR port rule time; SENSOR lines; FAILED reason. Plusarg
// clock_limit: the run fails in that clock; 0: never.
//
// Defines: NCDC_DATA_WIDTH, NCDC_READ_PORTS, NCDC_READ_BURST_WIDTH, NCDC_MEMORY_BYTES,
// NCDC_THREE_READ_PORTS, NCDC_STREAM (pixels per beat), NCDC_SENSOR (its name), NCDC_USB (the number
// of the USB side's read port), NCDC_USB_LANES (bytes of a word of the FTDI chip), NCDC_CSI2 (lanes of a
// sensor with CSI-2, whose PHY is left out), NCDC_AXIS (samples of a beat of a camera's AXI4-Stream
// video, instead of a sensor) and NCDC_SAMPLE_BITS (of each). The chip's clock is three fifths of the
// system's; plusargs usb_rx_stall and usb_tx_stall are its pauses, in clocks of 256.

`timescale 1ns/1ps

module system_bench (
    input wire clk,
    input wire extclk                   // of the sensor
`ifdef NCDC_CSI2
    , input wire lane                   // of the bytes of its lanes
`endif
);
    localparam DW = `NCDC_DATA_WIDTH;
    localparam PORTS = `NCDC_READ_PORTS;
    localparam BW = `NCDC_READ_BURST_WIDTH;
    localparam WBW = 5;
    localparam PIXELS = "stream.bin";
    localparam STDIN = 32'h80000000;
    localparam END = 0, WRITE = 1, READ = 2, WAIT_IRQ = 3, WAIT = 4, SAVE = 5, RESET = 6,
        RESET_ALL = 7, STALL = 8, SENSOR = 9, STREAM = 10,
        USB_SEND = 11, USB_GOT = 12, COUNT = 13;

    reg rst = 1, module_rst = 1, memory_rst = 1;
    reg sensor_reset_n = 0;
    reg [31:0] memory_bytes, sink_probability, clock_limit, trace_every;

    initial begin
        if (!$value$plusargs("clock_limit=%d", clock_limit)) clock_limit = 0;
        if (!$value$plusargs("memory_bytes=%d", memory_bytes)) memory_bytes = 0;
        if (!$value$plusargs("trace_every=%d", trace_every)) trace_every = 0;
        if (!$value$plusargs("sink_probability=%d", sink_probability)) sink_probability = 256;
        memory.fill(0, memory_bytes, 8'hA5);
    end

    // The sensor, and the two lines of its bus; or a camera that needs no bus.
    wire scl_low, sda_low, sensor_sda_low;
    wire scl = !scl_low, sda = !(sda_low || sensor_sda_low);
`ifdef NCDC_AXIS
    wire tvalid, tready, tuser, tlast;
    wire [(`NCDC_AXIS*`NCDC_SAMPLE_BITS+7)/8*8-1:0] tdata;
    assign sensor_sda_low = 0;
    axis_camera #(.COUNT(`NCDC_AXIS), .BITS(`NCDC_SAMPLE_BITS)) camera (
        .clk(extclk), .reset_n(sensor_reset_n), .tvalid(tvalid), .tready(tready), .tdata(tdata),
        .tuser(tuser), .tlast(tlast)
    );
`else
    wire pixclk, frame_valid, line_valid;
    wire [11:0] data;
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(extclk), .reset_n(sensor_reset_n), .pixclk(pixclk), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .scl(scl), .sda(sda), .sda_low(sensor_sda_low)
    );
`endif

`ifdef NCDC_CSI2
    wire [8*`NCDC_CSI2-1:0] lane_bytes;
    wire [`NCDC_CSI2-1:0]   lane_valid, lane_active;
    localparam EMBEDDED = `NCDC_SENSOR == "imx219" ? 2 : 0;
    csi2_transmitter #(.LANES(`NCDC_CSI2), .EMBEDDED(EMBEDDED)) lanes (
        .pixel_clk(pixclk), .reset_n(sensor_reset_n), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .byte_clk(lane), .bytes(lane_bytes), .hs(lane_active),
        .valid(lane_valid), .lp_p(), .lp_n(), .idle());
`endif

    // The system.
    reg  [14:0] csr_address = 0;
    reg         csr_read = 0, csr_write = 0;
    reg  [31:0] csr_writedata = 0;
    wire [31:0] csr_readdata;
    wire        csr_readdatavalid, csr_waitrequest, irq;

    reg  [31:0] stall = 0;              // clocks to come in which the memory takes nothing
    wire        stalled = stall != 0;
`include "bench_buses.vh"

    reg  [31:0] trace_clocks = 1;
    wire        front_end_idle;

    // The hash of the outputs: commands and answers, first addresses of bursts, bytes that are written.
    localparam TRACE = 4 + PORTS + DW / 32;     // words
    reg  [31:0]         trace_left = 0;         // words of a write burst to come
    wire                trace_first = trace_left == 0;
    wire [32*TRACE-1:0] traced;
    wire [63:0]         trace;
    genvar              t;
    assign traced[31:0] = csr_readdatavalid ? csr_readdata : 0;
    assign traced[63:32] = write_write && trace_first ? write_address : 0;
    assign traced[95:64] = {write_write && trace_first ? write_burstcount : 5'd0, write_write,
        irq, scl_low, sda_low, front_end_idle, csr_readdatavalid,
        csr_waitrequest && (csr_read || csr_write)};
    generate
        for (t = 0; t < 32; t = t + 1) begin : trace_bit
            if (t < DW / 8)
                assign traced[96 + t] = write_write && write_byteenable[t];
            else if (t - DW / 8 < PORTS)
                assign traced[96 + t] = read_read[t - DW / 8];
            else
                assign traced[96 + t] = 0;
        end
        for (t = 0; t < PORTS; t = t + 1) begin : trace_read
            assign traced[128 + 32*t +: 32] = read_read[t] ?
                read_address[32*t +: 32] ^ {read_burstcount[BW*t +: BW], {(32-BW){1'b0}}} : 0;
        end
        for (t = 0; t < DW / 8; t = t + 1) begin : trace_write
            assign traced[128 + 32*PORTS + 8*t +: 8] =
                write_write && write_byteenable[t] ? write_writedata[8*t +: 8] : 0;
        end
    endgenerate
    digest #(.WORDS(TRACE)) digest (.clk(clk), .value(traced), .sum(trace));
    always @(posedge clk) begin
        trace_clocks <= trace_clocks == trace_every ? 1 : trace_clocks + 1;
        if (trace_clocks == trace_every && trace_every != 0)
            $display("TRACE %0d", trace);
        if (memory_rst)
            trace_left <= 0;
        else if (write_write && !write_waitrequest)
            trace_left <= (trace_first ? write_burstcount : trace_left) - 1;
    end

`define NCDC_WRITES
    ncdc_system dut (
        .clk(clk), .rst(module_rst), .memory_rst(memory_rst),
`ifdef NCDC_CSI2
        .sensor_clock(lane),
        .sensor_lane0_data(lane_bytes[7:0]), .sensor_lane0_valid(lane_valid[0]),
        .sensor_lane0_active(lane_active[0]),
        .sensor_lane1_data(lane_bytes[15:8]), .sensor_lane1_valid(lane_valid[1]),
        .sensor_lane1_active(lane_active[1]),
`elsif NCDC_AXIS
        .sensor_clock(extclk), .sensor_tvalid(tvalid), .sensor_tready(tready),
        .sensor_tdata(tdata), .sensor_tuser(tuser), .sensor_tlast(tlast),
`else
        .sensor_clock(pixclk), .sensor_frame_valid(frame_valid), .sensor_line_valid(line_valid),
        .sensor_data(data),
`endif
        .scl_low(scl_low), .sda_low(sda_low), .scl(scl), .sda(sda),
        .front_end_idle(front_end_idle),
`ifdef NCDC_USB
        `NCDC_READ_PORT(`NCDC_USB),
        .usb_clock(usb_clk), .usb_rxf_n(usb_rxf_n), .usb_txe_n(usb_txe_n),
        .usb_data_i(usb_data_i), .usb_be_i(usb_be_i), .usb_data_o(usb_data_o),
        .usb_be_o(usb_be_o), .usb_data_oe(usb_data_oe), .usb_oe_n(usb_oe_n),
        .usb_rd_n(usb_rd_n), .usb_wr_n(usb_wr_n),
`endif
`include "bench_connections.vh"
    );

`ifdef NCDC_USB
    // The FTDI chip; a host's bytes wait in a queue, and what it gets goes into a file.
    localparam UL = `NCDC_USB_LANES;
    reg              usb_clk = 0;
    reg  [7:0]       usb_phase = 0;             // of 10, at both edges of the system's clock
    wire             usb_rxf_n, usb_txe_n, usb_data_oe, usb_oe_n, usb_rd_n, usb_wr_n;
    wire [8*UL-1:0]  usb_data_i, usb_data_o, usb_got_data;
    wire [UL-1:0]    usb_be_i, usb_be_o, usb_got_be;
    wire             usb_take, usb_got;
    reg  [7:0]       usb_queue [0:65535];
    reg  [31:0]      usb_put = 0, usb_sent = 0, usb_bytes = 0;  // bytes
    reg  [31:0]      usb_rx_stall, usb_tx_stall;
    wire [31:0]      usb_errors, usb_left = usb_put - usb_sent;
    reg  [8*UL-1:0]  usb_word;
    reg  [UL-1:0]    usb_word_be;
    integer          usb_file, usb_source, usb_lane, usb_byte;
    initial begin
        if (!$value$plusargs("usb_rx_stall=%d", usb_rx_stall)) usb_rx_stall = 0;
        if (!$value$plusargs("usb_tx_stall=%d", usb_tx_stall)) usb_tx_stall = 0;
        usb_file = $fopen("usb_got.bin", "wb");
    end
    always @(posedge clk or negedge clk)
        if (usb_phase >= 4) begin               // 6 of 10 edges
            usb_phase <= usb_phase - 4;
            usb_clk <= !usb_clk;
        end else
            usb_phase <= usb_phase + 6;
    always @* begin
        usb_word_be = 0;
        for (usb_lane = 0; usb_lane < UL; usb_lane = usb_lane + 1) begin
            usb_word[8*usb_lane +: 8] = usb_queue[(usb_sent + usb_lane) & 65535];
            usb_word_be[usb_lane] = usb_left > usb_lane;
        end
    end
    ft245_chip #(.LANES(UL)) usb_chip (
        .clk(usb_clk), .rxf_n(usb_rxf_n), .txe_n(usb_txe_n), .oe_n(usb_oe_n), .rd_n(usb_rd_n),
        .wr_n(usb_wr_n), .data_o(usb_data_i), .be_o(usb_be_i), .data_i(usb_data_o),
        .be_i(usb_be_o), .data_driven(usb_data_oe), .rx_stall(usb_rx_stall[7:0]),
        .tx_stall(usb_tx_stall[7:0]), .host_valid(usb_left != 0), .host_data(usb_word),
        .host_be(usb_word_be), .host_ready(usb_take), .device_valid(usb_got),
        .device_ready(1'b1), .device_data(usb_got_data), .device_be(usb_got_be),
        .errors(usb_errors)
    );
    always @(posedge usb_clk) begin
        if (usb_left != 0 && usb_take)
            usb_sent <= usb_sent + (usb_left < UL ? usb_left : UL);
        if (usb_got)
            for (usb_byte = 0; usb_byte < UL; usb_byte = usb_byte + 1)
                if (usb_got_be[usb_byte]) begin
                    $fwrite(usb_file, "%c", usb_got_data[8*usb_byte +: 8]);
                    usb_bytes = usb_bytes + 1;
                end
    end
    task usb_send(input [31:0] count);
        begin
            usb_source = $fopen("usb_send.bin", "rb");
            for (k = 0; k < count; k = k + 1)
                usb_queue[(usb_put + k) & 65535] = $fgetc(usb_source);
            $fclose(usb_source);
            usb_put = usb_put + count;
        end
    endtask
`endif

    // The host.
    reg [31:0] clocks = 0, waited = 0, operation = 0, a = 0, b = 0;
    reg        asked = 0;               // an operation is under way
    reg        reading = 0;             // a read is accepted, its word has not come
    integer    got, file, k;

    // The answer, and what comes next.
    task done;
        begin
            $display("DONE %0d", clocks);
            $fflush;
            asked = 0;
        end
    endtask

    task counters;
        begin
            for (k = 0; k < PORTS; k = k + 1) begin
                $display("RESULT read%0d_beats %0d", k, read_beats[k]);
                $display("RESULT read%0d_waits %0d", k, read_waits[k]);
                $display("RESULT read%0d_errors %0d", k, read_errors[k]);
            end
            $display("RESULT write_beats %0d", write_beats);
            $display("RESULT write_bytes %0d", write_bytes);
            $display("RESULT write_waits %0d", write_waits);
            $display("RESULT write_errors %0d", write_errors);
            $display("RESULT csr_errors %0d", csr_errors);
            $display("RESULT stream_errors %0d", stream_errors);
            $display("RESULT memory_errors %0d", memory_errors);
`ifdef NCDC_USB
            $display("RESULT usb_errors %0d", usb_errors);
`endif
        end
    endtask

    task ends;
        begin
            counters;
            $display("RESULT trace %0d", trace);
            $display("RESULT total_clocks %0d", clocks);
            $display("END %0d", clocks);
            $fflush;
            $finish;
        end
    endtask

    always @(posedge clk) begin
        clocks = clocks + 1;
        if (clocks == clock_limit) begin
            $display("FAILED the run did not end in %0d clocks", clock_limit);
            $fflush;
            $finish;
        end
        rst <= clocks < 8;
        module_rst <= clocks < 8;
        memory_rst <= clocks < 8;
        if (stall != 0)
            stall <= stall - 1;
        if (clocks > 16) begin
            if (!asked) begin
                got = $fscanf(STDIN, "%h %h %h", operation, a, b);
                asked = 1;
                waited = 0;
                if (got != 3)
                    operation = END;
            end
            waited = waited + 1;
            case (operation)
                WRITE: begin
                    csr_address <= a[14:0];
                    csr_writedata <= b;
                    csr_write <= 1;
                    if (csr_write && !csr_waitrequest) begin
                        csr_write <= 0;
                        done;
                    end
                end
                READ: begin
                    csr_address <= a[14:0];
                    csr_read <= !reading;
                    if (csr_read && !csr_waitrequest) begin
                        csr_read <= 0;
                        reading = 1;
                    end
                    if (csr_readdatavalid) begin
                        csr_read <= 0;
                        reading = 0;
                        $display("READ %0d %0d", csr_readdata, clocks);
                        $fflush;
                        asked = 0;
                    end
                end
                WAIT_IRQ:
                    if (irq || waited > a) begin
                        $display("IRQ %0d %0d", irq, clocks);
                        $fflush;
                        asked = 0;
                    end
                WAIT:
                    if (waited > a)
                        done;
                SAVE: begin
                    file = $fopen("memory.bin", "wb");
                    memory.save(file, a, b);
                    $fclose(file);
                    done;
                end
                RESET, RESET_ALL: begin
                    module_rst <= waited <= a;
                    memory_rst <= operation == RESET_ALL && waited <= a;
                    if (waited > a)
                        done;
                end
                STALL: begin
                    stall <= a;
                    done;
                end
                SENSOR: begin
                    sensor_reset_n <= a[0];
                    done;
                end
`ifdef NCDC_STREAM
                STREAM: begin
                    $fflush(pixels);
                    $display("STREAM %0d %0d", stream_bytes, clocks);
                    $fflush;
                    asked = 0;
                end
`endif
`ifdef NCDC_USB
                USB_SEND: begin
                    usb_send(a);
                    done;
                end
                USB_GOT: begin
                    $fflush(usb_file);
                    $display("STREAM %0d %0d", usb_bytes, clocks);
                    $fflush;
                    asked = 0;
                end
`endif
                COUNT: begin
                    counters;
                    done;
                end
                default: ends;
            endcase
        end
    end
endmodule
