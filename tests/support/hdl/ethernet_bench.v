// A MAC with its interface to a PHY, between streams and wires, and its clocks: 100 MHz for the
// streams, 125 MHz for the line. LATE: the device makes the line's transmit clock 2 ns late itself; else
// the wire to the chip does, as the chip's own delay would.

`timescale 1ns/1ps

`ifdef GMII
`define DATA 8
`else
`define DATA 4
`endif

module ethernet_bench (
    input wire         rst,
    input wire  [1:0]  speed,
    output wire [3:0]  status,
    input wire         sink_valid, sink_last,
    input wire  [31:0] sink_data,
    input wire  [3:0]  sink_last_be,
    output wire        sink_ready,
    output wire        source_valid, source_last,
    output wire [31:0] source_data,
    output wire [3:0]  source_last_be, source_error,
    output wire        clk, tx_clk, tx_en, tx_er,
    output wire [`DATA-1:0] tx_data,
    input wire         mii_tx_clk, rx_clk, rx_dv, rx_er,
    input wire  [`DATA-1:0] rx_data
);
    reg sys, line, late;
    initial begin
        sys = 0;
        forever #5 sys = !sys;
    end
    initial begin
        line = 0;
        forever #4 line = !line;
    end
    initial begin
        late = 0;
        #2;
        forever #4 late = !late;
    end
    assign clk = sys;

    wire made;              // the transmit clock at the device's pin
`ifdef LATE
    assign tx_clk = made;
`else
    assign #2 tx_clk = made;
`endif

    mac mac (
        .clock_sys(sys), .clock_transmit(line), .clock_late(late), .clock_reset(rst),
        .speed_set(speed), .speed_status(status),
        .sink_valid(sink_valid), .sink_ready(sink_ready), .sink_last(sink_last),
        .sink_data(sink_data), .sink_last_be(sink_last_be), .sink_error(4'b0),
        .source_valid(source_valid), .source_ready(1'b1), .source_last(source_last),
        .source_data(source_data), .source_last_be(source_last_be), .source_error(source_error),
`ifdef RGMII
        .wire_clock_tx(made), .wire_tx_ctl(tx_en), .wire_tx_data(tx_data),
        .wire_rx_ctl(rx_dv), .wire_rx_data(rx_data),
`endif
`ifdef GMII
        .wire_clock_gtx(made), .wire_tx_en(tx_en), .wire_tx_er(tx_er), .wire_tx_data(tx_data),
        .wire_rx_dv(rx_dv), .wire_rx_er(rx_er), .wire_rx_data(rx_data),
`endif
`ifdef MII
        .wire_clock_tx(mii_tx_clk), .wire_tx_en(tx_en), .wire_tx_er(tx_er),
        .wire_tx_data(tx_data),
        .wire_rx_dv(rx_dv), .wire_rx_er(rx_er), .wire_rx_data(rx_data),
`endif
        .wire_clock_rx(rx_clk)
    );
`ifdef MII
    assign made = mii_tx_clk;
`endif
endmodule
