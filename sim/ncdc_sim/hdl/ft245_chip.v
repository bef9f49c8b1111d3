// An FTDI chip in 245 synchronous FIFO mode, with its rules.
//
// Read: RXF# low says that a word is there; it is on the bus while OE# is low, and taken at a rising
// edge with RD# and RXF# low. Write: taken at a rising edge with WR# and TXE# low. What is on the bus
// while RXF# is high is nothing. (FTDI, "FT232H", FT_000288 version 2.1, section 4.4.)
//
// With NCDC_TIMED the pins change late: those of the chip somewhere in OUT_MIN .. OUT_MAX after its
// clock, unknown from the edge on, and those of the FPGA must be there SETUP before the edge and stay
// HOLD after it. FT232H, table 4.1: 0 to 9 ns, 7.5 ns, 0 ns, in ps. Times of 0 need no check.
//
// Violations are printed as USB-ERROR rule time, and counted.

`timescale 1ps/1ps

module ft245_chip #(
    parameter LANES = 1,
    parameter OUT_MIN = 0, OUT_MAX = 9000, SETUP = 7500, HOLD = 0
) (
    input  wire               clk,              // of the chip, at its pin
    output reg                rxf_n, txe_n,
    input  wire               oe_n, rd_n, wr_n,
    output wire [8*LANES-1:0] data_o,           // to the FPGA
    output wire [LANES-1:0]   be_o,
    input  wire [8*LANES-1:0] data_i,           // from the FPGA
    input  wire [LANES-1:0]   be_i,
    input  wire               data_driven,      // by the FPGA
    input  wire [7:0]         rx_stall, tx_stall,   // pauses, in clocks of 256
    // The side of USB, in the same clock.
    input  wire               host_valid,
    input  wire [8*LANES-1:0] host_data,
    input  wire [LANES-1:0]   host_be,
    output wire               host_ready,
    output wire               device_valid,
    input  wire               device_ready,
    output wire [8*LANES-1:0] device_data,
    output wire [LANES-1:0]   device_be,
    output reg  [31:0]        errors = 0
);
    reg        rxf = 0, txe = 0;                // what the chip means, before its pins' delay
    reg        oe_before = 0, driven_before = 0, rd_before = 0, wr_before = 0, rxf_before = 0,
               txe_before = 0;
    reg        known = 0;                       // there was an edge before
    reg [31:0] random = 32'h1234ABCD;

    // Words from USB wait here.
    reg [9*LANES-1:0] queue [0:15];
    reg [3:0]  first = 0;
    reg [4:0]  count = 0;
    wire [3:0] tail = first + count[3:0];
    wire       taken = rxf && !rd_n && !oe_n;
    wire [8*LANES-1:0] head = queue[first][8*LANES-1:0];
    wire [LANES-1:0]   head_be = queue[first][8*LANES +: LANES];
    assign host_ready = count < 12;
    assign device_valid = txe && !wr_n;
    assign device_data = data_i;
    assign device_be = be_i;

    task violation(input [8*24-1:0] rule);
        begin
            errors = errors + 1;
            if (errors < 20)
                $display("USB-ERROR %0s %0t", rule, $time);
        end
    endtask

    always @(posedge clk) begin
        random = random ^ (random << 13);
        random = random ^ (random >> 17);
        random = random ^ (random << 5);
        if (known) begin
            if (^{oe_n, rd_n, wr_n, data_driven} === 1'bx) violation("unknown");
            if (!rd_n && !(oe_before && !oe_n)) violation("oe-before-rd");
            if (!oe_n && data_driven) violation("both-drive");
            if (!oe_n && driven_before || data_driven && oe_before) violation("no-rest");
            if (!wr_n && !data_driven) violation("undriven");
            if (!wr_n && !wr_before && !txe_before) violation("wr-before-txe");
            if (!rd_n && !rd_before && !rxf_before) violation("rd-before-rxf");
            if (!wr_n && txe && ^{data_i, be_i} === 1'bx) violation("data-unknown");
        end
        known <= !(^{oe_n, rd_n, wr_n, data_driven} === 1'bx);
        oe_before <= !oe_n;
        rd_before <= !rd_n;
        wr_before <= !wr_n;
        driven_before <= data_driven;
        rxf_before <= rxf;
        txe_before <= txe;
        rxf <= count > {4'd0, taken} && random[7:0] >= rx_stall;
        if (host_valid && host_ready)
            queue[tail] <= {host_be, host_data};
        first <= first + {3'd0, taken};
        count <= count + {4'd0, host_valid && host_ready} - {4'd0, taken};
        txe <= device_ready && random[15:8] >= tx_stall;
    end

`ifdef NCDC_TIMED
    reg [8*LANES-1:0] shown = {8*LANES{1'bx}};
    reg [LANES-1:0]   shown_be = {LANES{1'bx}};
    reg               enabled = 0;
    integer           late;
    initial {rxf_n, txe_n} = 2'b11;
    assign data_o = enabled ? shown : {8*LANES{1'bx}};
    assign be_o = enabled ? shown_be : {LANES{1'bx}};
    always @(posedge clk) begin
        late = OUT_MIN + random[31:16] % (OUT_MAX - OUT_MIN + 1);
        if (late < 2) late = 2;
        #1 begin
            rxf_n <= 1'bx;
            txe_n <= 1'bx;
            shown <= {8*LANES{1'bx}};
            shown_be <= {LANES{1'bx}};
        end
        #(late - 1) begin
            rxf_n <= !rxf;
            txe_n <= !txe;
            shown <= rxf ? head : {8*LANES{1'bx}};
            shown_be <= rxf ? head_be : {LANES{1'bx}};
        end
    end
    always @(oe_n)
        enabled <= #(OUT_MAX) !oe_n;

    // Setup and hold of what the FPGA drives.
    time edge_at = 0, changed = 0;
    always @(posedge clk) begin
        if (known && $time - changed < SETUP) violation("setup");
        edge_at = $time;
    end
    always @(oe_n, rd_n, wr_n, data_i, be_i) begin
        changed = $time;
        if (HOLD != 0 && known && $time - edge_at < HOLD) violation("hold");
    end
`else
    always @* begin
        rxf_n = !rxf;
        txe_n = !txe;
    end
    assign data_o = oe_n || !rxf ? {LANES{8'h5A}} : head;
    assign be_o = oe_n || !rxf ? {LANES{1'b0}} : head_be;
`endif
endmodule
