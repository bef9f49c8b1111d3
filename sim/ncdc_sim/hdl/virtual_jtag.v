// Intel's virtual TAP with a host at the other end of the cable, written from "Virtual JTAG Intel FPGA
// IP Core User Guide" (UG-SLDVRTL): `tck` rises only while the host scans; the virtual states change
// after its rising edge, `tdi` with its falling one, and the host takes `tdo` before the next rise.
//
// From jtag_at_us on the host scans the jtag_count values of jtag_scans, 64 bits each in hexadecimal,
// the first on top, with 20 us between them; each prints "JTAG <what came out>".

`timescale 1ps/1ps

module sld_virtual_jtag #(
    parameter sld_auto_instance_index = "YES", sld_instance_index = 0, sld_ir_width = 1
) (
    output reg                     tck, tdi,
    input wire                     tdo,
    output wire [sld_ir_width-1:0] ir_in,
    input wire [sld_ir_width-1:0]  ir_out,
    output wire                    virtual_state_cdr, virtual_state_sdr, virtual_state_e1dr,
    output wire                    virtual_state_pdr, virtual_state_e2dr, virtual_state_udr,
    output wire                    virtual_state_cir, virtual_state_uir
);
    localparam HALF = 20833;            // ps, of 24 MHz: USB-Blaster II
    localparam [2:0] IDLE = 0, CAPTURE = 1, SHIFT = 2, EXIT = 3, UPDATE = 4;
    reg [2:0]   state;
    reg [1023:0] scans;
    reg [63:0]  value, out;
    integer     at_us, count, k, n;

    assign ir_in = 1;
    assign virtual_state_cdr = state == CAPTURE, virtual_state_sdr = state == SHIFT;
    assign virtual_state_e1dr = state == EXIT, virtual_state_udr = state == UPDATE;
    assign virtual_state_pdr = 0, virtual_state_e2dr = 0, virtual_state_cir = 0;
    assign virtual_state_uir = 0;

    // A clock at whose rise the present state counts; the next one begins after it.
    task clock(input [2:0] next);
        begin
            #HALF tck = 1;
            #1000 state = next;
            #(HALF - 1000) tck = 0;
        end
    endtask

    initial begin
        tck = 0; tdi = 0; state = IDLE;
        if ($value$plusargs("jtag_at_us=%d", at_us) && $value$plusargs("jtag_scans=%h", scans)
            && $value$plusargs("jtag_count=%d", count)) begin
            #(at_us * 1000000.0);
            for (k = count - 1; k >= 0; k = k - 1) begin
                value = scans >> 64 * k;
                clock(CAPTURE);
                clock(SHIFT);
                for (n = 0; n < 64; n = n + 1) begin
                    tdi = value[n];
                    out[n] = tdo;
                    clock(n == 63 ? EXIT : SHIFT);
                end
                clock(UPDATE);
                clock(IDLE);
                $display("JTAG %016x", out);
                #20000000;
            end
        end
    end
endmodule
