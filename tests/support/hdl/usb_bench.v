// Numbers both ways through the module `dut`, a UsbFifo, and the model of its chip. Every word is
// made from its number in the row, so that one that is lost, doubled or changed is found at once.
//
// Plusargs: up and down, words to the host and from it; gap and stall, clocks of 256 in which the
// core has no word, or takes none; rx_stall and tx_stall, those of the chip; up_stall and down_gap, those
// of the host; resets, of the core and its side of the bus, each some thousand clocks after the last.
//
// A reset forgets what is under way. The core's next word is then the first of another row; of the
// host's words some may be missing, as many as the queues hold.
//
// Lines: USB-ERROR of the chip; DIFFERENT direction number; RESULT lines, then END.
//
// Defines: NCDC_LANES; NCDC_TIMED with NCDC_OUT_MIN, NCDC_OUT_MAX, NCDC_SETUP, NCDC_HOLD of the chip
// and NCDC_FPGA_OUT of the FPGA, from the chip's clock to its pins, in ps.

`timescale 1ps/1ps

`ifndef NCDC_TIMED
`define NCDC_OUT_MIN 0
`define NCDC_OUT_MAX 0
`define NCDC_SETUP 0
`define NCDC_HOLD 0
`endif

module usb_bench (
    input wire clk,
    input wire extclk                   // of the chip
);
    localparam L = `NCDC_LANES;

    reg [31:0] up, down, gap, stall, rx_stall, tx_stall, up_stall, down_gap, resets;
    initial begin
        if (!$value$plusargs("resets=%d", resets)) resets = 0;
        if (!$value$plusargs("up=%d", up)) up = 1000;
        if (!$value$plusargs("down=%d", down)) down = 1000;
        if (!$value$plusargs("gap=%d", gap)) gap = 0;
        if (!$value$plusargs("stall=%d", stall)) stall = 0;
        if (!$value$plusargs("rx_stall=%d", rx_stall)) rx_stall = 0;
        if (!$value$plusargs("tx_stall=%d", tx_stall)) tx_stall = 0;
        if (!$value$plusargs("up_stall=%d", up_stall)) up_stall = 0;
        if (!$value$plusargs("down_gap=%d", down_gap)) down_gap = 0;
    end

    // The word of a number in the row: any bits, and now and then not all of its bytes.
    function [31:0] mixed(input [31:0] number);
        reg [31:0] x;
        begin
            x = number * 32'h9E3779B1 + 32'h7F4A7C15;
            x = x ^ (x >> 15);
            x = x * 32'h85EBCA77;
            mixed = x ^ (x >> 13);
        end
    endfunction

    function [8*L-1:0] word(input [31:0] number);
        word = mixed(number);
    endfunction

    function [L-1:0] lanes_of(input [31:0] number);
        reg [31:0] x;
        begin
            x = mixed(~number);
            lanes_of = L == 1 || x[7:4] != 0 ? {L{1'b1}} : {L{1'b1}} >> x[1:0];
        end
    endfunction

    // The two sides, each with a random sequence of its own.
    reg [31:0] random = 32'h2545F491, host_random = 32'h51ED270B;
    function [31:0] next(input [31:0] x);
        reg [31:0] y;
        begin
            y = x ^ (x << 13);
            y = y ^ (y >> 17);
            next = y ^ (y << 5);
        end
    endfunction

    reg         rst = 1;
    reg  [31:0] clocks = 0, chip_clocks = 0;
    reg  [31:0] core_sent = 0, core_got = 0, host_sent = 0, host_got = 0, different = 0;
    reg  [31:0] up_first = 0, up_last = 0, down_first = 0, down_last = 0;   // clocks of the chip
    reg  [31:0] up_paused = 0, down_paused = 0;     // of them, those in which the chip paused
    reg  [31:0] reset_at = 3000, resets_done = 0, skipped;
    reg  [31:0] row = 0, host_row = 0;      // of the core's words; of the one that the host got last
    reg         jumped = 0;                 // a reset may have swallowed words of the host's
    reg         core_valid = 0, core_ready = 0, host_valid = 0, host_ready = 0;

    wire             i_ready, o_valid, rxf_n, txe_n, oe_n, rd_n, wr_n, data_oe;
    wire [9*L-1:0]   o_payload;
    wire [8*L-1:0]   data_o, chip_data;
    wire [L-1:0]     be_o, chip_be;
    wire             take, got;
    wire [8*L-1:0]   got_data;
    wire [L-1:0]     got_be;
    wire [31:0]      errors;

    dut dut (
        .clk(clk), .rst(rst),
        .i__valid(core_valid), .i__ready(i_ready),
        .i__payload({lanes_of(row + core_sent), word(row + core_sent)}),
        .o__valid(o_valid), .o__ready(core_ready), .o__payload(o_payload),
        .pins__clock(extclk), .pins__rxf_n(rxf_n), .pins__txe_n(txe_n),
        .pins__data_i(chip_data), .pins__be_i(chip_be), .pins__data_o(data_o), .pins__be_o(be_o),
        .pins__data_oe(data_oe), .pins__oe_n(oe_n), .pins__rd_n(rd_n), .pins__wr_n(wr_n)
    );

`ifdef NCDC_TIMED
    wire #(`NCDC_FPGA_OUT) late_oe_n = oe_n, late_rd_n = rd_n, late_wr_n = wr_n;
    wire #(`NCDC_FPGA_OUT) late_oe = data_oe;
    wire [8*L-1:0] #(`NCDC_FPGA_OUT) late_data = data_o;
    wire [L-1:0] #(`NCDC_FPGA_OUT) late_be = be_o;
`else
    wire late_oe_n = oe_n, late_rd_n = rd_n, late_wr_n = wr_n, late_oe = data_oe;
    wire [8*L-1:0] late_data = data_o;
    wire [L-1:0]   late_be = be_o;
`endif

    ft245_chip #(
        .LANES(L), .OUT_MIN(`NCDC_OUT_MIN), .OUT_MAX(`NCDC_OUT_MAX), .SETUP(`NCDC_SETUP),
        .HOLD(`NCDC_HOLD)
    ) chip (
        .clk(extclk), .rxf_n(rxf_n), .txe_n(txe_n), .oe_n(late_oe_n), .rd_n(late_rd_n),
        .wr_n(late_wr_n), .data_o(chip_data), .be_o(chip_be), .data_i(late_data), .be_i(late_be),
        .data_driven(late_oe), .rx_stall(rx_stall[7:0]), .tx_stall(tx_stall[7:0]),
        .host_valid(host_valid), .host_data(word(~host_sent)), .host_be(lanes_of(~host_sent)),
        .host_ready(take), .device_valid(got), .device_ready(host_ready), .device_data(got_data),
        .device_be(got_be), .errors(errors)
    );

    // The core.
    always @(posedge clk) begin
        clocks <= clocks + 1;
        rst <= clocks < 20 || clocks >= reset_at && resets_done < resets;
        random <= next(random);
        if (clocks == reset_at + 6 && resets_done < resets) begin
            resets_done <= resets_done + 1;
            reset_at <= clocks + 32'd2000 + {22'd0, random[9:0]};
        end
        if (rst && clocks > 40) begin
            core_valid <= 0;
            core_sent <= 0;
            row <= (resets_done + 1) << 24;
            jumped <= 1;
        end
        if (!rst) begin
            if (core_valid && i_ready)
                core_sent <= core_sent + 1;
            core_valid <= core_sent + {31'd0, core_valid && i_ready} < up
                && (core_valid && !i_ready || {24'd0, random[7:0]} >= gap);
            core_ready <= {24'd0, random[15:8]} >= stall;
            if (o_valid && core_ready) begin
                skipped = 0;
                while (jumped && skipped < 2000
                       && o_payload !== {lanes_of(~(core_got + skipped)), word(~(core_got + skipped))})
                    skipped = skipped + 1;
                if (o_payload !== {lanes_of(~(core_got + skipped)), word(~(core_got + skipped))}) begin
                    if (different < 20) $display("DIFFERENT down %0d", core_got);
                    different = different + 1;
                end
                core_got <= core_got + skipped + 1;
                jumped <= 0;
            end
        end
    end

    // The host.
    always @(posedge extclk) begin
        chip_clocks <= chip_clocks + 1;
        host_random <= next(host_random);
        begin                           // a reset is nothing to the host
            if (host_valid && take)
                host_sent <= host_sent + 1;
            host_valid <= host_sent + {31'd0, host_valid && take} < down
                && (host_valid && !take || {24'd0, host_random[7:0]} >= down_gap);
            host_ready <= {24'd0, host_random[15:8]} >= up_stall;
            if (got) begin
                if (host_row != row
                        && {got_be, got_data} === {lanes_of(row), word(row)}) begin
                    host_row <= row;
                    host_got <= 1;
                end else begin
                    if ({got_be, got_data} !== {lanes_of(host_row + host_got),
                                                word(host_row + host_got)}) begin
                        if (different < 20) $display("DIFFERENT up %0d", host_got);
                        different = different + 1;
                    end
                    host_got <= host_got + 1;
                end
                if (host_got == 0) up_first <= chip_clocks;
                up_last <= chip_clocks;
            end
            if (host_got != 0 && host_got < up && txe_n)
                up_paused <= up_paused + 1;
            if (!rd_n && !rxf_n) begin
                if (down_first == 0) down_first <= chip_clocks;
                down_last <= chip_clocks;
            end
            if (down_first != 0 && rxf_n)
                down_paused <= down_paused + 1;
        end
        if (resets_done == resets && host_row == row
                && host_got >= up && core_got >= down && core_sent == up && host_sent == down
                || chip_clocks > 32'd4000 + (up + down) * 32'd40) begin
            $display("RESULT up %0d", host_got);
            $display("RESULT down %0d", core_got);
            $display("RESULT up_clocks %0d", up_last - up_first + 1);
            $display("RESULT down_clocks %0d", down_last - down_first + 1);
            $display("RESULT up_paused %0d", up_paused);
            $display("RESULT down_paused %0d", down_paused);
            $display("RESULT different %0d", different);
            $display("RESULT errors %0d", errors);
            $display("END %0d", chip_clocks);
            $finish;
        end
    end
endmodule
