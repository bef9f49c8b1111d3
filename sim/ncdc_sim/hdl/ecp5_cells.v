// Models of the ECP5's cells that a design for a board names itself, written from their descriptions
// in Lattice, "ECP5 and ECP5-5G sysI/O Usage Guide" (FPGA-TN-02032), "... High-Speed I/O Interface"
// (FPGA-TN-02035) and "... sysCLOCK PLL/DLL Design and Usage Guide" (FPGA-TN-02200). No delays but
// those of clocks, of DELAYF, and the time around its clock in which IDDRX2F needs its input stable.

`timescale 1ps/1ps

module IB (input wire I, output wire O);
    assign O = I;
endmodule

module OBZ (input wire I, input wire T, output wire O);
    assign O = T ? 1'bz : I;
endmodule

module BB (input wire I, input wire T, output wire O, inout wire B);
    assign B = T ? 1'bz : I;
    assign O = B;
endmodule

// Input and output registers of a pin's cell.
module IFS1P3DX (input wire D, input wire SP, input wire SCLK, input wire CD, output reg Q);
    initial Q = 0;
    always @(posedge SCLK or posedge CD)
        if (CD) Q <= 0;
        else if (SP) Q <= D;
endmodule

module OFS1P3DX (input wire D, input wire SP, input wire SCLK, input wire CD, output reg Q);
    initial Q = 0;
    always @(posedge SCLK or posedge CD)
        if (CD) Q <= 0;
        else if (SP) Q <= D;
endmodule

// Two bits a clock: D0 while the clock is high, D1 while it is low, both of the rising edge before.
module ODDRX1F (input wire SCLK, input wire RST, input wire D0, input wire D1, output wire Q);
    wire clear = RST === 1'b1;          // left open it is low
    reg d0, d1, later, rises, falls;    // Q's changes at each edge: no pulse of no length
    initial begin d0 = 0; d1 = 0; later = 0; rises = 0; falls = 0; end
    always @(posedge SCLK) begin
        d0 <= clear ? 1'b0 : D0;
        d1 <= clear ? 1'b0 : D1;
        later <= d1;
        rises <= d0 ^ falls;
    end
    always @(negedge SCLK) falls <= later ^ rises;
    assign Q = rises ^ falls;
endmodule

// Two bits a clock: of a rising edge and of the falling one after it, both from the next rising edge.
module IDDRX1F (input wire SCLK, input wire RST, input wire D, output reg Q0, output reg Q1);
    wire clear = RST === 1'b1;
    reg rose, fell;
    initial begin rose = 0; fell = 0; Q0 = 0; Q1 = 0; end
    always @(negedge SCLK) fell <= D;
    always @(posedge SCLK) begin
        rose <= clear ? 1'b0 : D;
        Q0 <= clear ? 1'b0 : rose;
        Q1 <= clear ? 1'b0 : fell;
    end
endmodule

// A delay at a pin that makes up for a clock's way to the registers, which has none here either.
module DELAYG #(parameter DEL_MODE = "USER_DEFINED") (input wire A, output wire Z);
    initial
        if (DEL_MODE != "SCLK_CENTERED") $display("BOARD-ERROR a delay of mode %0s", DEL_MODE);
    assign Z = A;
endmodule

// A delay at a pin that is set while the design runs: 128 steps of 25 ps. LOADN loads DEL_VALUE, the end
// of each pulse of MOVE is a step.
module DELAYF #(
    parameter DEL_MODE = "USER_DEFINED", parameter integer DEL_VALUE = 0
) (
    input wire A, input wire LOADN, input wire MOVE, input wire DIRECTION, output wire Z,
    output wire CFLAG
);
    integer value;
    reg     z0, z1, z2, z3;             // a quarter of the delay each: Verilator delays one change at a time
    initial begin
        value = DEL_VALUE;
        if (DEL_MODE != "USER_DEFINED") $display("BOARD-ERROR a delay of mode %0s", DEL_MODE);
    end
    assign CFLAG = value == (DIRECTION ? 0 : 127);
    always @(negedge MOVE or negedge LOADN)
        if (!LOADN) value = DEL_VALUE;
        else if (!CFLAG) value = value + (DIRECTION ? -1 : 1);
    always @(A) z0 <= #(25 * value / 4) A;
    always @(z0) z1 <= #(25 * value / 4) z0;
    always @(z1) z2 <= #(25 * value / 4) z1;
    always @(z2) z3 <= #(25 * value / 4) z2;
    assign Z = z3;
endmodule

// An edge clock's gate: whole pulses only, three edges after STOP.
module ECLKSYNCB (input wire ECLKI, input wire STOP, output wire ECLKO);
    reg [2:0] open;
    initial open = 0;
    always @(negedge ECLKI) open <= {open[1:0], !STOP};
    assign ECLKO = ECLKI & open[2];
endmodule

module CLKDIVF #(
    parameter GSR = "DISABLED", parameter DIV = "2.0"
) (input wire CLKI, input wire RST, input wire ALIGNWD, output reg CDIVX);
    initial begin
        CDIVX = 0;
        if (DIV != "2.0") $display("BOARD-ERROR a divider by %0s", DIV);
    end
    always @(posedge CLKI or posedge RST)
        if (RST) CDIVX <= 0;
        else CDIVX <= !CDIVX;
endmodule

// Four bits a clock, of both edges of ECLK, which is twice as fast; Q0 came first. An input that changes
// within 0.32 ns of an edge gives a random bit: setup and hold time of GDDRX2_RX.ECLK.Centered
// (FPGA-TN-02035), taken for those of the cell.
module IDDRX2F (
    input wire D, input wire ECLK, input wire SCLK, input wire RST, input wire ALIGNWD,
    output reg Q0, output reg Q1, output reg Q2, output reg Q3
);
    localparam real STABLE = 320;       // ps
    reg [3:0] bits, held;               // the last one highest
    real      changed, edge_at;
    initial begin bits = 0; held = 0; changed = 0; edge_at = 0; {Q3, Q2, Q1, Q0} = 0; end
    task sample;
        begin
            bits = {$realtime - changed < STABLE ? $random : D, bits[3:1]};
            edge_at = $realtime;
        end
    endtask
    always @(D) begin
        changed = $realtime;
        if ($realtime - edge_at < STABLE)
            bits[3] = $random;
    end
    always @(posedge ECLK) begin
        held <= bits;
        sample;
    end
    always @(negedge ECLK) sample;
    always @(posedge SCLK or posedge RST)
        if (RST) {Q3, Q2, Q1, Q0} <= 0;
        else {Q3, Q2, Q1, Q0} <= held;
endmodule

// A flip-flop that is set at once.
module FD1S3BX (input wire D, input wire CK, input wire PD, output reg Q);
    initial Q = 1;
    always @(posedge CK or posedge PD)
        if (PD) Q <= 1;
        else Q <= D;
endmodule

// A clock's gate: whole pulses only.
module DCCA (input wire CLKI, input wire CE, output wire CLKO);
    reg open;
    initial open = 0;
    always @(negedge CLKI) open <= CE;
    assign CLKO = CLKI & open;
endmodule

// A phase-locked loop: from the period of CLKI and the dividers the period of the oscillator, from
// that the outputs. All outputs begin together, with the first edge of CLKI after the lock; with
// CPHASE = divider - 1 an output is in phase.
module EHXPLLL #(
    parameter CLKI_DIV = 1, CLKFB_DIV = 1, CLKOP_DIV = 8, CLKOS_DIV = 8, CLKOS2_DIV = 8,
    parameter CLKOS3_DIV = 8, CLKOP_CPHASE = 0, CLKOS_CPHASE = 0, CLKOS2_CPHASE = 0,
    parameter CLKOS3_CPHASE = 0, CLKOP_FPHASE = 0, CLKOS_FPHASE = 0, CLKOS2_FPHASE = 0,
    parameter CLKOS3_FPHASE = 0, CLKOP_ENABLE = "ENABLED", CLKOS_ENABLE = "DISABLED",
    parameter CLKOS2_ENABLE = "DISABLED", CLKOS3_ENABLE = "DISABLED", FEEDBK_PATH = "CLKOP",
    parameter OUTDIVIDER_MUXA = "DIVA", OUTDIVIDER_MUXB = "DIVB", OUTDIVIDER_MUXC = "DIVC",
    parameter OUTDIVIDER_MUXD = "DIVD", PLLRST_ENA = "DISABLED", INTFB_WAKE = "DISABLED",
    parameter STDBY_ENABLE = "DISABLED", DPHASE_SOURCE = "DISABLED", PLL_LOCK_MODE = 0
) (
    input wire CLKI, CLKFB, RST, STDBY, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG,
    input wire PLLWAKESYNC, ENCLKOP, ENCLKOS, ENCLKOS2, ENCLKOS3,
    output reg CLKOP, CLKOS, CLKOS2, CLKOS3,
    output wire CLKINTFB,
    output reg LOCK
);
    localparam EDGES = 4;               // of CLKI that are looked at before the lock
    localparam FED = FEEDBK_PATH == "INT_OP" ? CLKOP_DIV : FEEDBK_PATH == "INT_OS" ? CLKOS_DIV :
        FEEDBK_PATH == "INT_OS2" ? CLKOS2_DIV : FEEDBK_PATH == "INT_OS3" ? CLKOS3_DIV : 0;
    assign CLKINTFB = 0;

    real last, oscillator;              // ps: the last edge of CLKI; a period of the oscillator
    integer edges;
    initial begin
        CLKOP = 0; CLKOS = 0; CLKOS2 = 0; CLKOS3 = 0; LOCK = 0; edges = 0;
        if (FED == 0) begin
            $display("BOARD-ERROR a loop without feedback");
            $finish;
        end
    end

    always @(posedge CLKI)
        if (!LOCK && !RST) begin
            oscillator = ($realtime - last) * CLKI_DIV / (1.0 * CLKFB_DIV * FED);
            last = $realtime;
            edges = edges + 1;
            if (edges == EDGES) begin
                if (1e6 / oscillator < 400 || 1e6 / oscillator > 800)
                    $display("BOARD-ERROR the oscillator is at %0f MHz", 1e6 / oscillator);
                LOCK <= 1;
            end
        end

    // Edge k of an output comes at its own multiple: no rounding adds up.
    real start;                         // when the outputs began
    integer op, os, os2, os3;
    initial begin
        op = 0;
        @(posedge LOCK);
        start = $realtime;
        #((CLKOP_CPHASE + 1 - CLKOP_DIV) * oscillator);
        forever begin
            CLKOP = !CLKOP;
            op = op + 1;
            #(start + ((CLKOP_CPHASE + 1 - CLKOP_DIV) + op * CLKOP_DIV / 2.0) * oscillator - $realtime);
        end
    end
    initial begin
        os = 0;
        @(posedge LOCK);
        start = $realtime;
        #((CLKOS_CPHASE + 1 - CLKOS_DIV) * oscillator);
        forever begin
            CLKOS = !CLKOS;
            os = os + 1;
            #(start + ((CLKOS_CPHASE + 1 - CLKOS_DIV) + os * CLKOS_DIV / 2.0) * oscillator - $realtime);
        end
    end
    initial begin
        os2 = 0;
        @(posedge LOCK);
        start = $realtime;
        #((CLKOS2_CPHASE + 1 - CLKOS2_DIV) * oscillator);
        forever begin
            CLKOS2 = !CLKOS2;
            os2 = os2 + 1;
            #(start + ((CLKOS2_CPHASE + 1 - CLKOS2_DIV) + os2 * CLKOS2_DIV / 2.0) * oscillator - $realtime);
        end
    end
    initial begin
        os3 = 0;
        @(posedge LOCK);
        start = $realtime;
        if (CLKOS3_ENABLE == "ENABLED") begin
            #((CLKOS3_CPHASE + 1 - CLKOS3_DIV) * oscillator);
            forever begin
                CLKOS3 = !CLKOS3;
                os3 = os3 + 1;
                #(start + ((CLKOS3_CPHASE + 1 - CLKOS3_DIV) + os3 * CLKOS3_DIV / 2.0) * oscillator - $realtime);
            end
        end
    end
endmodule
