// A Quartus board from the sensor's pins to the monitor's: the generated top `NCDC_TOP, its SDRAM of
// `NCDC_DQ bits, a sensor, a monitor, after a video converter if there is `NCDC_DAC, buttons.
//
// With `NCDC_ETHERNET there is an Ethernet chip, see rgmii_chip.v.
//
// Plusargs: those of board_run.v, uart_host.v and of the sensor.
//
// Results: lines "RESULT <name> <value>"; screen.bin, see vga_monitor.v and vga_wire_monitor.v.

`timescale 1ps/1ps

module quartus_bench;
    reg clk50 = 0;
    always #10000 clk50 = !clk50;

    // The SDRAM.
    wire clk, cke, cs_n, ras_n, cas_n, we_n;
    wire [1:0]            ba;
    wire [`NCDC_DQ/8-1:0] dqm;
    wire [12:0]           a;
    wire [`NCDC_DQ-1:0]   dq;
    sdram_board #(.DQ(`NCDC_DQ)) sdram (
        .clk(clk), .cke(cke), .cs_n(cs_n), .ras_n(ras_n), .cas_n(cas_n), .we_n(we_n),
        .oe(dut.sdram_dq.oe[0]), .ba(ba), .dqm(dqm), .a(a), .dq(dq));

    // The sensor, and its bus.
    wire xclk, sensor_reset_n, standby, pixclk, fval, lval, scl, sda, sda_low;
    wire [11:0] d;
    pullup (scl);
    pullup (sda);
    assign sda = sda_low ? 1'b0 : 1'bz;
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(xclk), .reset_n(sensor_reset_n && !standby), .pixclk(pixclk), .frame_valid(fval),
        .line_valid(lval), .data(d), .scl(scl), .sda(sda), .sda_low(sda_low));

    wire hsync, vsync;
`ifdef NCDC_DAC
    wire vga_clk, blank_n, sync_n;
    wire [7:0] r, g, b;
    vga_monitor monitor (
        .clock(vga_clk), .hsync(hsync), .vsync(vsync), .blank_n(blank_n), .r(r), .g(g), .b(b));
`else
    wire [3:0] r, g, b;
    vga_wire_monitor #(`NCDC_MODE) monitor (
        .hsync(hsync), .vsync(vsync), .r(r), .g(g), .b(b));
`endif

`ifdef NCDC_ETHERNET
    wire rst_n, mdc, mdio, tx_clk, tx_ctl, rx_clk, rx_ctl;
    wire [3:0] tx_data, rx_data;
    pullup (mdio);
    rgmii_chip chip (
        .rst_n(rst_n), .mdc(mdc), .mdio(mdio), .tx_clk(tx_clk), .tx_ctl(tx_ctl), .tx_data(tx_data),
        .rx_clk(rx_clk), .rx_ctl(rx_ctl), .rx_data(rx_data));
`endif

    wire following, raw, over;
    board_run script (.following(following), .raw(raw), .again(), .over(over));
    wire [7:0] led;
    wire rx, tx;
    uart_host #(.BAUD(`NCDC_BAUD)) host (.receive(tx), .send(rx));
    `NCDC_TOP dut (
        .clk50_0__io(clk50), .sdram_0__clk__io(clk), .sdram_0__clk_en__io(cke),
        .sdram_0__cs__io(cs_n), .sdram_0__we__io(we_n), .sdram_0__ras__io(ras_n),
        .sdram_0__cas__io(cas_n), .sdram_0__ba__io(ba), .sdram_0__a__io(a),
        .sdram_0__dqm__io(dqm), .sdram_0__dq__io(dq),
`ifdef NCDC_DAC
        .vga_0__clk__io(vga_clk), .vga_0__blank_n__io(blank_n), .vga_0__sync_n__io(sync_n),
`endif
`ifdef NCDC_ETHERNET
        .eth_rgmii_0__rst__io(rst_n), .eth_rgmii_0__mdc__io(mdc), .eth_rgmii_0__mdio__io(mdio),
        .eth_rgmii_0__tx_clk__io(tx_clk), .eth_rgmii_0__tx_ctl__io(tx_ctl),
        .eth_rgmii_0__tx_data__io(tx_data), .eth_rgmii_0__rx_clk__io(rx_clk),
        .eth_rgmii_0__rx_ctl__io(rx_ctl), .eth_rgmii_0__rx_data__io(rx_data),
`endif
        .vga_0__hs__io(hsync), .vga_0__vs__io(vsync), .vga_0__r__io(r), .vga_0__g__io(g), .vga_0__b__io(b),
        .camera_0__pixclk__io(pixclk), .camera_0__fval__io(fval), .camera_0__lval__io(lval),
        .camera_0__d__io(d), .camera_0__scl__io(scl), .camera_0__sda__io(sda),
        .camera_0__reset_n__io(sensor_reset_n), .camera_0__standby__io(standby),
        .camera_0__xclk__io(xclk), .uart_0__rx__io(rx), .uart_0__tx__io(tx),
        .button_0__io(!following), .button_1__io(1'b1), .button_2__io(!raw), .button_3__io(1'b1),
        .led_0__io(led[0]), .led_1__io(led[1]), .led_2__io(led[2]), .led_3__io(led[3]),
        .led_4__io(led[4]), .led_5__io(led[5]), .led_6__io(led[6]), .led_7__io(led[7]));

    always @(led) $display("LED %0d %0d", $time / 1000000, led);
    always @(posedge over) begin
        sdram.report;
        $display("RESULT monitor_errors %0d", monitor.errors);
        $display("RESULT underruns %0d", dut.core.screen.underruns);
        $display("RESULT shown %0d", dut.core.screen.shown);
        $display("RESULT failures %0d", dut.core.programs.failures);
        $display("RESULT led %0d", led);
`ifdef NCDC_ETHERNET
        $display("RESULT ethernet_errors %0d", chip.errors);
        $display("RESULT ethernet_resets %0d", chip.resets);
        $display("RESULT ethernet_received %0d", chip.frames);
        $display("RESULT ethernet_sent %0d", chip.sent);
        chip.close;
`endif
        $fflush;
        monitor.close;
        $finish;
    end
endmodule
