// An SDRAM on a board, at the FPGA's pins: the chip's model, and the time that signals take.
//
// Data come `ACCESS` ps after the clock's edge at the chip and stay for `HOLD` ps after the next one;
// in between DQ holds the wrong bits. `FLIGHT` ps are the FPGA's outputs and the way to the chip,
// `BACK` ps the way back and the FPGA's input. `oe` is high while the FPGA drives DQ.

// Both may be given from outside: they change with voltage and temperature.

`timescale 1ps/1ps

`ifndef NCDC_FLIGHT
`define NCDC_FLIGHT 3000
`define NCDC_BACK 1500
`endif

module sdram_board #(
    parameter DQ = 16, FLIGHT = `NCDC_FLIGHT, ACCESS = 6000, HOLD = 2700, BACK = `NCDC_BACK
) (
    input wire            clk, cke, cs_n, ras_n, cas_n, we_n, oe,
    input wire [1:0]      ba,
    input wire [DQ/8-1:0] dqm,
    input wire [12:0]     a,
    inout wire [DQ-1:0]   dq
);
    reg            c_clk = 0, c_cke = 0, c_cs_n = 1, c_ras_n = 1, c_cas_n = 1, c_we_n = 1, c_oe = 0;
    reg [1:0]      c_ba = 0;
    reg [DQ/8-1:0] c_dqm = -1;
    reg [12:0]     c_a = 0;
    reg [DQ-1:0]   c_dq = 0;
    wire           chip_drives;
    wire [DQ-1:0]  chip_dq;
    wire [31:0]    violations, refreshes, refresh_most, beats_read, beats_written;

    always @(clk) c_clk <= #(FLIGHT) clk;
    always @(cke, cs_n, ras_n, cas_n, we_n, ba, dqm, a) begin
        c_cke <= #(FLIGHT) cke;
        c_cs_n <= #(FLIGHT) cs_n;
        c_ras_n <= #(FLIGHT) ras_n;
        c_cas_n <= #(FLIGHT) cas_n;
        c_we_n <= #(FLIGHT) we_n;
        c_ba <= #(FLIGHT) ba;
        c_dqm <= #(FLIGHT) dqm;
        c_a <= #(FLIGHT) a;
    end
    always @(oe, dq) begin
        c_oe <= #(FLIGHT) oe;
        c_dq <= #(FLIGHT) dq;
    end
    sdram_chip #(`NCDC_CHIP) chip (
        .clk(c_clk), .controller_rst(1'b0), .cke(c_cke), .cs_n(c_cs_n), .ras_n(c_ras_n),
        .cas_n(c_cas_n), .we_n(c_we_n), .ba(c_ba), .a(c_a), .dqm(c_dqm), .dq_i(c_dq),
        .dq_oe(c_oe), .dq_o(chip_dq), .dq_drives(chip_drives), .violations(violations),
        .refreshes(refreshes), .refresh_most(refresh_most), .beats_read(beats_read),
        .beats_written(beats_written));

    reg [DQ-1:0] read_dq = 0;           // at the FPGA's pin
    reg          read_drives = 0;
    always @(posedge c_clk) begin
        // The chip's outputs of this edge are there a moment later.
        read_drives <= #(HOLD + BACK) 1'b0;
        read_dq <= #(HOLD + BACK) ~read_dq;
    end
    always @(posedge c_clk) begin
        #10;
        if (chip_drives) begin
            read_dq <= #(ACCESS + BACK - 10) chip_dq;
            read_drives <= #(ACCESS + BACK - 10) 1'b1;
        end
    end
    assign dq = read_drives || chip_drives ? read_dq : {DQ{1'bz}};

    task report;
        begin
            $display("RESULT violations %0d", violations);
            $display("RESULT refreshes %0d", refreshes);
            $display("RESULT beats_read %0d", beats_read);
            $display("RESULT beats_written %0d", beats_written);
        end
    endtask
endmodule
