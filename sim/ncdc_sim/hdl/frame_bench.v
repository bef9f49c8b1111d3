// Runs whole frames through the generated module `ncdc`: memory model, protocol checkers, and a
// program of register accesses played from a file. Self-contained, so that a frame runs at the
// simulator's own speed.
//
// Files, in the working directory: source.bin (raw frame), program.hex (one access per line,
// 2 hex digits of operation, 6 of word address, 8 of data), output.bin (written at the end).
//
// Operations: 00 end, 01 write, 02 read and compare, 03 wait for irq, 04 read and report, 05 wait
// for some clocks, 06 wait until so many bytes are out, 07 reset the module for some clocks,
// 08 read until the value comes, 09 the camera begins a frame at the byte address, 0a reset the
// module and the memory, 0b the ranges in memory that may be used: the address is 0, 1 for begin and
// end of what may be read, 2, 3 of what may be written. The clocks of a frame run from the last register write before a wait to the
// irq. A reset of the module alone leaves memory and sink as they are: words under way still come.
// One of both has its clocks in bits 15:0, and in bits 31:16, signed, by how many clocks the
// memory's trails the module's; the memory forgets what it owes.
//
// With a camera (camera_line > 0) the source is not there from the start: the camera writes it into
// the memory, past the ports, a byte per clock and a row every `camera_line` clocks; `camera_rows`
// counts a row once it is in memory. Read commands that begin in a row of the camera's frame which
// is not, are counted.
//
// Settings are decimal plusargs, read below and by the memory. Lines printed: PROGRESS bytes; FRAME
// clocks end output-bytes; READ address data; RESET output-bytes; RESULT name value;
// AVALON-ERROR port rule time; FAILED reason.
//
// Defines: NCDC_DATA_WIDTH, NCDC_READ_PORTS, NCDC_READ_BURST_WIDTH,
// NCDC_WRITE_BURST_WIDTH, NCDC_CSR_ADDRESS_WIDTH, NCDC_MEMORY_BYTES, NCDC_THREE_READ_PORTS,
// NCDC_STREAM (stream instead of memory output, so many pixels per beat).

`timescale 1ns/1ps

module frame_bench (
    input wire clk
);
    localparam DW = `NCDC_DATA_WIDTH;
    localparam PORTS = `NCDC_READ_PORTS;
    localparam BW = `NCDC_READ_BURST_WIDTH;
    localparam WBW = `NCDC_WRITE_BURST_WIDTH;
    localparam PROGRAM = 65536;
    localparam POISON = 8'hA5;          // unwritten bytes
    localparam PIXELS = "output.bin";

    localparam END = 0, WRITE = 1, COMPARE = 2, WAIT_IRQ = 3, REPORT = 4, WAIT = 5, WAIT_OUTPUT = 6,
        RESET = 7, POLL = 8, CAMERA = 9, RESET_ALL = 10,
        ALLOW = 11;

    reg rst = 1;
    reg module_rst = 1;                 // of the module under test
    reg memory_rst = 1;                 // of the memory

    // Settings of this run.
    reg [31:0] source_base, source_bytes, output_base, output_bytes, output_pixels;
    reg [31:0] program_words, clock_limit, progress_step;
    reg [31:0] sink_probability;        // of 256: how often the sink of the stream is ready
    reg [31:0] camera_line;             // clocks of a row of the camera, 0: no camera
    reg [31:0] camera_width, camera_height, camera_pitch;   // bytes, rows, bytes from row to row

    reg [63:0] instructions [0:PROGRAM-1];
    integer file, source;

    initial begin
        if (!$value$plusargs("source_base=%d", source_base)) source_base = 0;
        if (!$value$plusargs("source_bytes=%d", source_bytes)) source_bytes = 0;
        if (!$value$plusargs("output_base=%d", output_base)) output_base = 0;
        if (!$value$plusargs("output_bytes=%d", output_bytes)) output_bytes = 0;
        if (!$value$plusargs("program_words=%d", program_words)) program_words = 1;
        if (!$value$plusargs("clock_limit=%d", clock_limit)) clock_limit = 1000000;
        if (!$value$plusargs("progress_step=%d", progress_step)) progress_step = 1000000;
        if (!$value$plusargs("sink_probability=%d", sink_probability)) sink_probability = 256;
        if (!$value$plusargs("camera_line=%d", camera_line)) camera_line = 0;
        if (!$value$plusargs("camera_width=%d", camera_width)) camera_width = 0;
        if (!$value$plusargs("camera_height=%d", camera_height)) camera_height = 0;
        if (!$value$plusargs("camera_pitch=%d", camera_pitch)) camera_pitch = 1;
        output_pixels = output_bytes / 3;
        $readmemh("program.hex", instructions, 0, program_words - 1);
        source = $fopen("source.bin", "rb");
        if (camera_line == 0)
            memory.load(source, source_base, source_bytes);
        else
            memory.fill(source_base, source_bytes, POISON);
`ifndef NCDC_STREAM
        memory.fill(output_base, output_bytes, POISON);
`endif
    end

    // The module under test.
    wire [`NCDC_CSR_ADDRESS_WIDTH-1:0] csr_address;
    reg         csr_read = 0, csr_write = 0;
    wire [31:0] csr_writedata, csr_readdata;
    wire        csr_readdatavalid, csr_waitrequest, irq, front_end_idle;

    reg  [12:0]         camera_rows = 0;
    wire                stalled = 0;    // the memory always runs
`include "bench_buses.vh"

`ifdef NCDC_STREAM
    assign write_address = 0, write_write = 0, write_burstcount = 0;
    assign write_writedata = 0, write_byteenable = 0;
    wire [31:0] output_done = 3 * SP * stream_beats;
`else
`define NCDC_WRITES
    wire [31:0] output_done = write_bytes;
`endif

    ncdc dut (
        .clk(clk), .rst(module_rst), .memory_rst(memory_rst),
        .camera_rows(camera_rows), .front_end_idle(front_end_idle),
`include "bench_connections.vh"
    );

    reg [31:0] clocks = 0, started = 0, position = 0, progress = 0, closing = 0;

    // The camera.
    reg [31:0] camera_base, camera_x, camera_y, camera_end = 0, early_reads = 0;
    reg        camera_sends = 0;
    reg [31:0] row_read;                // of the camera's frame
    integer    k;

    // One clock of the camera.
    task send;
        begin
            if (camera_x < camera_width)
                memory.put((camera_base + camera_y * camera_pitch + camera_x) & address_mask,
                           $fgetc(source));
            camera_x = camera_x + 1;
            if (camera_x == camera_width) begin
                // In the file rows are as far from each other as in memory.
                for (k = camera_width; k < camera_pitch; k = k + 1)
                    memory.put((camera_base + camera_y * camera_pitch + k) & address_mask,
                               $fgetc(source));
                camera_y = camera_y + 1;
                camera_rows <= camera_y;
                camera_end = clocks;
            end
            if (camera_x == camera_line) begin
                camera_x = 0;
                camera_sends = camera_y != camera_height;
            end
        end
    endtask

    // A read command is accepted: is its row there?
    task watch(input [31:0] address);
        begin
            row_read = (address - camera_base) / camera_pitch;
            if (address >= camera_base && row_read < camera_height && row_read >= camera_rows)
                early_reads = early_reads + 1;
        end
    endtask

    // What is read and written outside the ranges.
    reg [31:0] allowed [0:3];
    reg [31:0] outside = 0;             // bytes
    reg [31:0] write_at, write_left = 0;
    integer    lane_of;
    initial begin
        allowed[0] = 0;
        allowed[1] = 32'hFFFFFFFF;
        allowed[2] = 0;
        allowed[3] = 32'hFFFFFFFF;
    end

    always @(posedge clk) begin
        for (lane_of = 0; lane_of < PORTS; lane_of = lane_of + 1)
            if (read_read[lane_of] && !read_waitrequest[lane_of]
                    && (read_address[32*lane_of +: 32] < allowed[0]
                        || read_address[32*lane_of +: 32]
                           + DW / 8 * read_burstcount[BW*lane_of +: BW] > allowed[1]))
                outside = outside + DW / 8 * read_burstcount[BW*lane_of +: BW];
        if (write_write && !write_waitrequest) begin
            if (write_left == 0) begin
                write_at = write_address;
                write_left = write_burstcount;
            end
            for (lane_of = 0; lane_of < DW / 8; lane_of = lane_of + 1)
                if (write_byteenable[lane_of] && (write_at + lane_of < allowed[2]
                                                  || write_at + lane_of >= allowed[3]))
                    outside = outside + 1;
            write_at = write_at + DW / 8;
            write_left = write_left - 1;
        end
        if (memory_rst)
            write_left = 0;
    end

    // The register program.
    reg        reading = 0;
    reg [31:0] waited = 0;              // clocks of the present operation
    integer    lead;                    // by which the module's reset precedes the memory's
    reg [63:0] now;
    wire [7:0] operation = now[63:56];
    assign csr_address = now[32 +: `NCDC_CSR_ADDRESS_WIDTH];
    assign csr_writedata = now[31:0];

    task next;
        begin
            position = position + 1;
            waited = 0;
            now <= instructions[position];
        end
    endtask

    task report;
        integer i;
        begin
            for (i = 0; i < PORTS; i = i + 1) begin
                $display("RESULT read%0d_commands %0d", i, read_commands[i]);
                $display("RESULT read%0d_beats %0d", i, read_beats[i]);
                $display("RESULT read%0d_waits %0d", i, read_waits[i]);
                if (read_errors[i] != 0)
                    $display("RESULT read%0d_errors %0d", i, read_errors[i]);
            end
`ifdef NCDC_STREAM
            $display("RESULT output_commands %0d", stream_packets);
            $display("RESULT output_beats %0d", stream_beats);
            $display("RESULT output_waits %0d", stream_waits);
            $fclose(pixels);
`else
            $display("RESULT output_commands %0d", write_commands);
            $display("RESULT output_beats %0d", write_beats);
            $display("RESULT output_waits %0d", write_waits);
            file = $fopen("output.bin", "wb");
            memory.save(file, output_base, output_bytes);
            $fclose(file);
`endif
            $display("RESULT output_bytes %0d", output_done);
            $display("RESULT outside_bytes %0d", outside);
            $display("RESULT memory_errors %0d", memory_errors);
            if (camera_line != 0) begin
                $display("RESULT camera_end %0d", camera_end);
                $display("RESULT early_reads %0d", early_reads);
            end
`ifndef NCDC_LITEDRAM_NATIVE
            $display("RESULT memory_activates %0d", memory.dram_timing.activates);
            $display("RESULT memory_refreshes %0d", memory.dram_timing.refreshes);
`endif
            $display("RESULT total_clocks %0d", clocks);
            $finish;
        end
    endtask

    always @(posedge clk) begin
        clocks = clocks + 1;
        rst <= clocks < 8;
        module_rst <= clocks < 8;
        memory_rst <= clocks < 8;
        if (clocks == 8)
            now <= instructions[0];
        if (camera_line != 0) begin
            for (k = 0; k < PORTS; k = k + 1)
                if (read_read[k] && !read_waitrequest[k])
                    watch(read_address[32*k +: 32]);
            if (camera_sends)
                send;
        end
        if (clocks > 16) begin
            if (output_done - progress >= progress_step) begin
                progress = output_done;
                $display("PROGRESS %0d", output_done);
                $fflush;
            end
            case (operation)
                END: begin
                    // A stream's sink may still be taking pixels that the module has let go.
                    closing = closing + 1;
`ifdef NCDC_STREAM
                    if (closing == 16 + 64 * 256
                            || (closing > 16 && SP * stream_beats >= output_pixels))
`else
                    if (closing == 1024)    // a controller may still have words to write
`endif
                        report;
                end
                WRITE: begin
                    csr_write <= 1;
                    if (csr_write && !csr_waitrequest) begin
                        csr_write <= 0;
                        started = clocks;
                        next;
                    end
                end
                COMPARE, REPORT, POLL: begin
                    csr_read <= !reading;
                    if (csr_read && !csr_waitrequest) begin
                        csr_read <= 0;
                        reading = 1;
                    end
                    if (csr_readdatavalid) begin
                        csr_read <= 0;
                        reading = 0;
                        if (operation == REPORT)
                            $display("READ %0d %0d", csr_address, csr_readdata);
                        else if (operation == COMPARE && csr_readdata !== csr_writedata) begin
                            $display("FAILED register-compare word %0d reads %h instead of %h",
                                     csr_address, csr_readdata, csr_writedata);
                            report;
                        end
                        if (operation != POLL || csr_readdata === csr_writedata)
                            next;
                    end
                end
                WAIT: begin
                    waited = waited + 1;
                    if (waited >= csr_writedata)
                        next;
                end
                CAMERA: begin
                    camera_base = csr_writedata;
                    camera_x = 0;
                    camera_y = 0;
                    camera_rows <= 0;
                    camera_sends = 1;
                    next;
                end
                ALLOW: begin
                    allowed[now[33:32]] = csr_writedata;
                    next;
                end
                WAIT_OUTPUT:
                    if (output_done >= csr_writedata)
                        next;
                RESET: begin
                    if (waited == 0)
                        $display("RESET %0d", output_done);
                    waited = waited + 1;
                    module_rst <= 1;
                    if (waited >= csr_writedata)
                        next;
                end
                RESET_ALL: begin
                    if (waited == 0)
                        $display("RESET %0d", output_done);
                    lead = $signed(csr_writedata[31:16]);
                    module_rst <= waited >= (lead < 0 ? -lead : 0)
                                  && waited < (lead < 0 ? -lead : 0) + csr_writedata[15:0];
                    memory_rst <= waited >= (lead > 0 ? lead : 0)
                                  && waited < (lead > 0 ? lead : 0) + csr_writedata[15:0];
                    waited = waited + 1;
                    if (waited > (lead < 0 ? -lead : lead) + csr_writedata[15:0])
                        next;
                end
                WAIT_IRQ:
                    if (irq) begin
                        $display("FRAME %0d %0d %0d", clocks - started, clocks, output_done);
                        next;
                    end
                default: begin
                    $display("FAILED program-operation %h at %0d", operation, position);
                    report;
                end
            endcase
        end
        if (clocks == clock_limit) begin
            $display("FAILED clock-limit %0d clocks, operation %0d, %0d output bytes",
                     clocks, position, output_done);
            report;
        end
    end
endmodule
