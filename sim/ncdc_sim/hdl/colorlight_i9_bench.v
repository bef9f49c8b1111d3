// A Colorlight i9 from the sensor's pins to the network's cable: the generated top, the SDRAM's model, a
// sensor, an Ethernet chip, see rgmii_chip.v.
//
// Plusargs: those of board_run.v, uart_host.v and of the sensor.
//
// Results: lines "RESULT <name> <value>"; tx.bin, see rgmii_chip.v.

`timescale 1ps/1ps

module colorlight_i9_bench;
    reg clk25 = 0;
    always #20000 clk25 = !clk25;

    // The SDRAM; the module's constant levels are wired to the chip here.
    wire clk, ras_n, cas_n, we_n;
    wire [1:0]  ba;
    wire [10:0] a;
    wire [31:0] dq;
    reg         oe = 0;
    always @(posedge dut.sdram_dq.clk) oe <= dut.sdram_dq.oe;
    sdram_board #(.DQ(32), .HOLD(2000)) sdram (
        .clk(clk), .cke(1'b1), .cs_n(1'b0), .ras_n(ras_n), .cas_n(cas_n), .we_n(we_n), .oe(oe),
        .ba(ba), .dqm(4'b0), .a({2'b0, a}), .dq(dq));

    // The sensor, and its bus.
    wire xclk, sensor_reset_n, pixclk, fval, lval, scl, sda, sda_low;
    wire [11:0] d;
    pullup (scl);
    pullup (sda);
    assign sda = sda_low ? 1'b0 : 1'bz;
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(xclk), .reset_n(sensor_reset_n), .pixclk(pixclk), .frame_valid(fval),
        .line_valid(lval), .data(d), .scl(scl), .sda(sda), .sda_low(sda_low));

    wire rst_n, mdc, mdio, tx_clk, tx_ctl, rx_clk, rx_ctl;
    wire [3:0] tx_data, rx_data;
    pullup (mdio);
    rgmii_chip #(.B50612D(1), .ADDRESS(0)) chip (
        .rst_n(rst_n), .mdc(mdc), .mdio(mdio), .tx_clk(tx_clk), .tx_ctl(tx_ctl), .tx_data(tx_data),
        .rx_clk(rx_clk), .rx_ctl(rx_ctl), .rx_data(rx_data));

    wire following, raw, over;      // there are no buttons
    board_run script (.following(following), .raw(raw), .again(), .over(over));
    wire led, rx, tx;
    uart_host #(.BAUD(`NCDC_BAUD)) host (.receive(tx), .send(rx));
    ncdc_colorlight_i9 dut (
        .clk25_0__io(clk25), .sdram_0__clk__io(clk), .sdram_0__ras__io(ras_n),
        .sdram_0__cas__io(cas_n), .sdram_0__we__io(we_n), .sdram_0__ba__io(ba), .sdram_0__a__io(a),
        .sdram_0__dq__io(dq), .camera_0__pixclk__io(pixclk), .camera_0__fval__io(fval),
        .camera_0__lval__io(lval), .camera_0__d__io(d), .camera_0__scl__io(scl),
        .camera_0__sda__io(sda), .camera_0__reset_n__io(sensor_reset_n),
        .camera_0__xclk__io(xclk), .uart_0__rx__io(rx), .uart_0__tx__io(tx), .led_0__io(led),
        .eth_rgmii_0__rst__io(rst_n), .eth_rgmii_0__mdc__io(mdc), .eth_rgmii_0__mdio__io(mdio),
        .eth_rgmii_0__tx_clk__io(tx_clk), .eth_rgmii_0__tx_ctl__io(tx_ctl),
        .eth_rgmii_0__tx_data__io(tx_data), .eth_rgmii_0__rx_clk__io(rx_clk),
        .eth_rgmii_0__rx_ctl__io(rx_ctl), .eth_rgmii_0__rx_data__io(rx_data));

    always @(posedge over) begin
        sdram.report;
        $display("RESULT failures %0d", dut.core.programs.failures);
        $display("RESULT led %0d", !led);
        $display("RESULT ethernet_errors %0d", chip.errors);
        $display("RESULT ethernet_resets %0d", chip.resets);
        $display("RESULT ethernet_received %0d", chip.frames);
        $display("RESULT ethernet_sent %0d", chip.sent);
        chip.close;
        $fflush;
        $finish;
    end
endmodule
