// The core of a board with a processor, `board_core`, between a sensor, its SDRAM at the core's clock
// and a gigabit network. Whoever runs this program replaces the processor: registers are read and
// written through its input and output, while time stands still.
//
// A command is a line of four hexadecimal numbers, operation, a, b and c; it is answered by one line:
//   0          end                                        RESULT lines, then END
//   1 a b      write b to the register at word address a  DONE
//   2 a        read                                       READ value
//   3 a        wait for a clocks                          DONE
//   4 a b c    read again and again until the value, masked with b, is c; LATE if it is not for
//              `timeout` clocks                           READ value
//   5          look at the counters                       COUNTS clocks reads writes
// An access begins `pace` clocks after the one before it, if not later, those of operation 4
// `poll` clocks: a processor's program takes time.
//
// Clocks come from bench_main.cpp: the core's, the line's of 125 MHz, the sensor's, the screen's.
// Between core and SDRAM is a register each way, as in the pins' cells of a board.
//
// wire.bin is what the line carries: for each frame its first byte's clock of the line and that after
// its last one (four bytes each), the bytes, how many of them were signalled as wrong (two each), and the
// bytes from the preamble to the check sequence; big endian.
//
// Defines: NCDC_CHIP, parameters of sdram_chip; NCDC_SENSOR, the sensor's name; NCDC_DQ, NCDC_MASKS.

`timescale 1ns/1ps

module network_bench (input wire clk, line, extclk, pixel);
    localparam STDIN = 32'h80000000;
    localparam END = 0, WRITE = 1, READ = 2, WAIT = 3, UNTIL = 4, COUNTS = 5;

    reg rst = 1;

    // The sensor, and the two lines of its bus.
    wire        pixclk, frame_valid, line_valid, scl_low, sda_low, sensor_sda_low, sensor_reset_n;
    wire [11:0] data;
    wire        scl = !scl_low, sda = !(sda_low || sensor_sda_low);
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(extclk), .reset_n(sensor_reset_n), .pixclk(pixclk), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .scl(scl), .sda(sda), .sda_low(sensor_sda_low));

    // The SDRAM, after registers.
    wire                  cke, cs_n, ras_n, cas_n, we_n, dq_oe, chip_drives;
    wire [1:0]            ba;
    wire [12:0]           a_pins;
    wire [`NCDC_MASKS-1:0] dqm;
    wire [`NCDC_DQ-1:0]   dq_o, chip_dq;
    wire [31:0]           violations, refreshes, refresh_most, beats_read, beats_written;
    reg                   c_cke = 0, c_cs_n = 1, c_ras_n = 1, c_cas_n = 1, c_we_n = 1, c_oe = 0;
    reg [1:0]             c_ba = 0;
    reg [12:0]            c_a = 0;
    reg [`NCDC_MASKS-1:0] c_dqm = -1;
    reg [`NCDC_DQ-1:0]    c_dq = 0, dq_i = 0;
    always @(posedge clk) begin
        {c_cke, c_cs_n, c_ras_n, c_cas_n, c_we_n} <= {cke, cs_n, ras_n, cas_n, we_n};
        {c_ba, c_a, c_dqm, c_dq, c_oe} <= {ba, a_pins, dqm, dq_o, dq_oe};
        // Undriven data are none of the chip's words.
        dq_i <= chip_drives ? chip_dq : ~chip_dq;
    end
    sdram_chip #(`NCDC_CHIP) chip (
        .clk(clk), .controller_rst(1'b0), .cke(c_cke), .cs_n(c_cs_n), .ras_n(c_ras_n),
        .cas_n(c_cas_n), .we_n(c_we_n), .ba(c_ba), .a(c_a), .dqm(c_dqm), .dq_i(c_dq),
        .dq_oe(c_oe), .dq_o(chip_dq), .dq_drives(chip_drives), .violations(violations),
        .refreshes(refreshes), .refresh_most(refresh_most), .beats_read(beats_read),
        .beats_written(beats_written));

    // The core.
    reg  [15:0] adr = 0;
    reg  [31:0] dat_w = 0;
    reg         cyc = 0, we = 0;
    wire [31:0] dat_r, packet_data;
    wire        ack, packet_valid, packet_ready, packet_last;
    wire [1:0]  packet_empty;
    board_core core (
        .clk(clk), .rst(rst), .pixel_clk(pixel), .pixel_rst(rst),
        .sensor_clock(pixclk), .sensor__frame_valid(frame_valid), .sensor__line_valid(line_valid),
        .sensor__data(data), .sensor_reset_n(sensor_reset_n), .scl(scl), .sda(sda),
        .scl_low(scl_low), .sda_low(sda_low),
        .sdram__cke(cke), .sdram__cs_n(cs_n), .sdram__ras_n(ras_n), .sdram__cas_n(cas_n),
        .sdram__we_n(we_n), .sdram__ba(ba), .sdram__a(a_pins), .sdram__dqm(dqm),
        .sdram__dq_o(dq_o), .sdram__dq_oe(dq_oe), .sdram__dq_i(dq_i),
        .picture(), .receive(1'b1), .send(), .following(1'b0), .previous(1'b0), .raw(1'b0),
        .again(1'b0),
        .leds(), .jtag_clk(1'b0), .scan__tdi(1'b0), .scan__tdo(), .scan__capture(1'b0),
        .scan__shift(1'b0), .scan__update(1'b0),
        .processor__registers__adr(adr), .processor__registers__dat_w(dat_w),
        .processor__registers__sel(4'hF), .processor__registers__cyc(cyc),
        .processor__registers__stb(cyc), .processor__registers__we(we),
        .processor__registers__dat_r(dat_r), .processor__registers__ack(ack),
        .processor__registers__err(),
        .processor__frames__adr(26'd0), .processor__frames__dat_w(32'd0),
        .processor__frames__sel(4'hF), .processor__frames__cyc(1'b0),
        .processor__frames__stb(1'b0), .processor__frames__we(1'b0),
        .processor__frames__dat_r(), .processor__frames__ack(), .processor__frames__err(),
        .processor__irq(), .processor__packet_valid(packet_valid),
        .processor__packet_ready(packet_ready), .processor__packet_data(packet_data),
        .processor__packet_empty(packet_empty), .processor__packet_last(packet_last));

    // The line.
    wire [3:0] tx_data;
    wire       tx_ctl;
    mac mac (
        .clock_sys(clk), .clock_reset(rst), .clock_transmit(line),
        .packet_valid(packet_valid), .packet_ready(packet_ready), .packet_last(packet_last),
        .packet_data(packet_data), .packet_empty(packet_empty),
        .line_rx(line), .line_tx(), .wire_rx_data(4'd0), .wire_rx_ctl(1'b0),
        .wire_tx_data(tx_data), .wire_tx_ctl(tx_ctl));

    // While the line's clock is high the lower half of a byte is there, then the upper one.
    reg [3:0]  low = 0;
    reg        enable = 0;
    reg [31:0] line_clocks = 0, begun = 0;
    reg [15:0] count = 0, wrong = 0;
    reg [7:0]  frame [0:65535];
    integer    log, k;
    initial begin
        log = $fopen("wire.bin", "wb");
        if (log == 0) $display("FAILED wire.bin cannot be written");
    end
    task put(input [31:0] value, input integer bytes);
        repeat (bytes) begin
            bytes = bytes - 1;
            $fwrite(log, "%c", value[8 * bytes +: 8]);
        end
    endtask
    always @(negedge line) begin
        low <= tx_data;
        enable <= tx_ctl;
    end
    always @(posedge line) begin
        if (enable) begin
            if (count == 0) begun = line_clocks;
            frame[count] = {tx_data, low};
            count = count + 1;
            if (!tx_ctl) wrong = wrong + 1;
        end else if (count != 0) begin
            put(begun, 4);
            put(line_clocks, 4);
            put({16'd0, count}, 2);
            put({16'd0, wrong}, 2);
            for (k = 0; k < count; k = k + 1) put({24'd0, frame[k]}, 1);
            count = 0;
            wrong = 0;
        end
        line_clocks = line_clocks + 1;
    end

    // The host.
    reg [31:0] pace, poll, timeout;
    initial begin
        if (!$value$plusargs("pace=%d", pace)) pace = 1;
        if (!$value$plusargs("poll=%d", poll)) poll = 1;
        if (!$value$plusargs("timeout=%d", timeout)) timeout = 1;
    end
    reg [31:0] clocks = 0, since = 0, waited = 0, operation = 0, a = 0, b = 0, c = 0;
    reg        asked = 0;               // a command is under way
    integer    got;

    task answer(input [8*6-1:0] kind, input [31:0] value);
        begin
            $display("%0s %0d", kind, value);
            $fflush;
            asked = 0;
        end
    endtask

    task ends;
        begin
            $display("RESULT violations %0d", violations);
            $display("RESULT refreshes %0d", refreshes);
            $display("RESULT refresh_most %0d", refresh_most);
            $display("RESULT clocks %0d", clocks);
            $display("END");
            $fflush;
            $fclose(log);
            $finish;
        end
    endtask

    // An access is over: its word is `dat_r`.
    task accessed;
        case (operation)
            WRITE: answer("DONE", 0);
            READ: answer("READ", dat_r);
            default:
                if ((dat_r & b) == c) answer("READ", dat_r);
                else if (waited > timeout) answer("LATE", dat_r);
        endcase
    endtask

    always @(posedge clk) begin
        clocks = clocks + 1;
        since = since + 1;
        rst <= clocks < 16;
        if (clocks > 32) begin
            if (!asked) begin
                got = $fscanf(STDIN, "%h %h %h %h", operation, a, b, c);
                asked = 1;
                waited = 0;
                if (got != 4) begin
                    $display("FAILED no command");
                    $finish;
                    operation = WAIT;
                end
            end
            waited = waited + 1;
            case (operation)
                END: ends;
                WAIT: if (waited >= a) answer("DONE", 0);
                COUNTS: begin
                    $display("COUNTS %0d %0d %0d", clocks, beats_read, beats_written);
                    $fflush;
                    asked = 0;
                end
                default:
                    if (cyc) begin
                        if (ack) begin
                            cyc <= 0;
                            accessed;
                        end
                    end else if (since >= (operation == UNTIL && waited > 1 ? poll : pace)) begin
                        adr <= a[15:0];
                        dat_w <= b;
                        we <= operation == WRITE;
                        cyc <= 1;
                        since = 0;
                    end
            endcase
        end
    end
endmodule
