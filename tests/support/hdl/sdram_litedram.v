// LiteDRAM's controller and PHY in front of our model of the chip: rounds of random writes, each
// followed by reads of the same addresses, and a pause now and then.
//
// The pads of LiteDRAM are three-state; whether it drives is asked of its PHY. The chip has its
// clock half a period late, as boards with this PHY do.
//
// CHIP_PARAMETERS is put in by the test. Plusargs: rounds. Results: lines "RESULT <name> <value>".

`timescale 1ns/1ps

module sdram_bench(input wire clk);
    localparam COUNT = 64;              // words of a round
    localparam STORED = 3;

    reg [31:0] rounds;
    initial if (!$value$plusargs("rounds=%d", rounds)) rounds = 10;

    wire        ready, cmd_ready, wdata_ready, rdata_valid, drives;
    wire        cke, cs_n, ras_n, cas_n, we_n;
    wire [12:0] a;
    wire [1:0]  ba, dm;
    wire [15:0] dq, dq_chip, rdata;
    reg         cmd_valid = 0, cmd_we = 0, wdata_valid = 0;
    reg  [23:0] addr = 0;
    reg  [15:0] wdata = 0;
    wire [31:0] violations, refreshes, refresh_most, beats_read, beats_written;

    assign dq = drives ? dq_chip : 16'bz;

    litedram_sdr dut (
        .sys_clk(clk), .ready(ready), .cmd_valid(cmd_valid), .cmd_ready(cmd_ready),
        .cmd_payload_we(cmd_we), .cmd_payload_addr(addr), .wdata_valid(wdata_valid),
        .wdata_ready(wdata_ready), .wdata_payload_data(wdata), .wdata_payload_we(2'b11),
        .rdata_valid(rdata_valid), .rdata_ready(1'b1), .rdata_payload_data(rdata),
        .pads_a(a), .pads_ba(ba), .pads_dm(dm), .pads_dq(dq), .pads_cke(cke), .pads_cs_n(cs_n),
        .pads_ras_n(ras_n), .pads_cas_n(cas_n), .pads_we_n(we_n)
    );
    // Its registers are X until the first edges.
    reg [31:0] now = 0;
    wire       awake = now > 4;
    sdram_chip #(CHIP_PARAMETERS) chip (
        .clk(!clk), .controller_rst(!ready), .cke(awake ? cke : 1'b1), .cs_n(awake ? cs_n : 1'b1),
        .ras_n(ras_n | !awake), .cas_n(cas_n | !awake), .we_n(we_n | !awake), .ba(ba), .a(a),
        .dqm(dm), .dq_i(dq), .dq_oe(awake && dut.inferedsdrtristate0_oe), .dq_o(dq_chip),
        .dq_drives(drives), .violations(violations), .refreshes(refreshes),
        .refresh_most(refresh_most), .beats_read(beats_read), .beats_written(beats_written)
    );

    reg [15:0] plain [0:(1 << (STORED + 11)) - 1];
    reg [13:0] addresses [0:COUNT-1];
    reg [31:0] random = 32'd12345;
    reg [31:0] asked = 0, sent = 0, got = 0, wrong = 0, checked = 0, round = 0, idle = 0;
    reg [31:0] k;
    reg        writing = 1;

    function [31:0] next(input [31:0] value);
        begin
            next = value ^ (value << 13);
            next = next ^ (next >> 17);
            next = next ^ (next << 5);
        end
    endfunction

    // Some addresses in few rows, so that rows are hit, and closed, often.
    task draw;
        for (k = 0; k < COUNT; k = k + 1) begin
            random = next(random);
            addresses[k] = random[31:18];
            if (k != 0 && random[1:0] != 0) addresses[k] = addresses[k - 1] + 1;
        end
    endtask

    always @(posedge clk) begin
        now <= now + 1;
        if (now == 0) draw;
        if (idle != 0)
            idle <= idle - 1;
        else if (ready) begin
            if (cmd_valid && cmd_ready) asked = asked + 1;
            cmd_valid <= asked < COUNT;
            cmd_we <= writing;
            addr <= {{10{1'b0}}, addresses[asked % COUNT]};
            if (wdata_valid && wdata_ready) begin
                plain[addresses[sent]] = wdata;
                sent = sent + 1;
            end
            wdata_valid <= writing && sent < COUNT;
            wdata <= {addresses[sent % COUNT], 2'b00} ^ {round[7:0], sent[7:0]};
            if (rdata_valid) begin
                checked = checked + 1;
                if (rdata !== plain[addresses[got]]) wrong = wrong + 1;
                got = got + 1;
            end
            if (writing && sent == COUNT && asked == COUNT) begin
                writing = 0;
                asked = 0;
                cmd_valid <= 0;
            end else if (!writing && got == COUNT) begin
                writing = 1;
                asked = 0; sent = 0; got = 0;
                cmd_valid <= 0;
                random = next(random);
                idle <= random[3:0] == 0 ? 1000 : random[6:3];
                round = round + 1;
                draw;
            end
        end
        if (round == rounds || now == 32'd4000 * (rounds + 10)) begin
            $display("RESULT violations %0d", violations);
            $display("RESULT wrong %0d", wrong);
            $display("RESULT checked %0d", checked);
            $display("RESULT refreshes %0d", refreshes);
            $display("RESULT refresh_most %0d", refresh_most);
            $finish;
        end
    end
endmodule
