// The packetiser before a MAC and RGMII: registers and memory on one side, wires on the other. `clk` is the
// packetiser's and the MAC's, the line's clock is made here; the wire to the chip makes it 2 ns late.

`timescale 1ns/1ps

module ethernet_packets_bench (
    input wire         clk, rst, memory_rst,
    input wire  [9:0]  csr__address,
    input wire         csr__read, csr__write,
    input wire  [31:0] csr__writedata,
    output wire [31:0] csr__readdata,
    output wire        csr__readdatavalid, csr__waitrequest,
    output wire [31:0] bus__address,
    output wire        bus__read,
    output wire [4:0]  bus__burstcount,
    input wire         bus__waitrequest, bus__readdatavalid,
    input wire  [31:0] bus__readdata,
    output wire        tx_clk, tx_en,
    output wire [3:0]  tx_data,
    input wire         rx_clk, rx_dv,
    input wire  [3:0]  rx_data
);
    reg line;
    initial begin
        line = 0;
        forever #4 line = !line;
    end

    wire        valid, ready, last, irq, made;
    wire [1:0]  empty;
    wire [31:0] data;
    assign #2 tx_clk = made;

    packetiser packetiser (
        .clk(clk), .rst(rst), .memory_rst(memory_rst), .irq(irq),
        .csr__address(csr__address), .csr__read(csr__read), .csr__write(csr__write),
        .csr__writedata(csr__writedata), .csr__readdata(csr__readdata),
        .csr__readdatavalid(csr__readdatavalid), .csr__waitrequest(csr__waitrequest),
        .bus__address(bus__address), .bus__read(bus__read), .bus__burstcount(bus__burstcount),
        .bus__waitrequest(bus__waitrequest), .bus__readdata(bus__readdata),
        .bus__readdatavalid(bus__readdatavalid),
        .o__payload({last, empty, data}), .o__valid(valid), .o__ready(ready)
    );

    mac mac (
        .clock_sys(clk), .clock_transmit(line), .clock_late(1'b0), .clock_reset(rst),
        .speed_set(2'd2), .speed_status(),
        .sink_valid(valid), .sink_ready(ready), .sink_last(last), .sink_data(data),
        .sink_last_be(last ? 4'b1000 >> empty : 4'b0), .sink_error(4'b0),
        .source_valid(), .source_ready(1'b1), .source_last(), .source_data(), .source_last_be(),
        .source_error(),
        .wire_clock_tx(made), .wire_tx_ctl(tx_en), .wire_tx_data(tx_data),
        .wire_clock_rx(rx_clk), .wire_rx_ctl(rx_dv), .wire_rx_data(rx_data)
    );
endmodule
