// A ULX3S from the sensor's pins to the monitor's: the generated top, the SDRAM's model, a sensor, a
// monitor, buttons.
//
// With NCDC_PATTERN the top has a test pattern, and the bench no sensor. With NCDC_CSI2 the sensor has so
// many lanes, and a clock of its own.
//
// Plusargs: those of board_run.v, uart_host.v and of the sensor; csi2_pixel_hz, the clock of a sensor with
// CSI-2, and those of csi2_transmitter.v and csi2_pins.v.
//
// Results: lines "RESULT <name> <value>"; screen.bin, see dvi_monitor.v.

`timescale 1ps/1ps

module ulx3s_bench;
    reg clk25 = 0;
    always #20000 clk25 = !clk25;

    // The SDRAM.
    wire clk, cke, cs_n, ras_n, cas_n, we_n;
    wire [1:0]  ba, dqm;
    wire [12:0] a;
    wire [15:0] dq;
    reg         oe = 0;
    always @(posedge dut.sdram_dq.clk) oe <= dut.sdram_dq.oe;
    sdram_board sdram (
        .clk(clk), .cke(cke), .cs_n(cs_n), .ras_n(ras_n), .cas_n(cas_n), .we_n(we_n), .oe(oe),
        .ba(ba), .dqm(dqm), .a(a), .dq(dq));

`ifndef NCDC_PATTERN
    // The sensor, and its bus.
    wire sensor_reset_n, pixclk, fval, lval, scl, sda, sda_low;
`ifdef NCDC_CSI2
    localparam LANES = `NCDC_CSI2, EMBEDDED = `NCDC_SENSOR == "imx219" ? 2 : 0;
    wire standby = 0;
    reg  xclk = 0;
    reg  [31:0] pixel_hz;
    initial begin
        if (!$value$plusargs("csi2_pixel_hz=%d", pixel_hz)) pixel_hz = 182400000;
        forever #(0.5e12 / pixel_hz) xclk = !xclk;
    end
    wire [8*LANES-1:0] bytes;
    wire [LANES-1:0]   hs, lp_n, pairs, low_power;
    wire byte_clk, pair;
    csi2_transmitter #(.LANES(LANES), .EMBEDDED(EMBEDDED)) transmitter (
        .pixel_clk(pixclk), .reset_n(sensor_reset_n), .frame_valid(fval), .line_valid(lval),
        .data(d), .byte_clk(byte_clk), .bytes(bytes), .hs(hs), .valid(), .lp_p(), .lp_n(lp_n), .idle());
    csi2_pins #(.LANES(LANES)) lanes_of_the_sensor (
        .byte_clk(byte_clk), .bytes(bytes), .hs(hs), .lp_n(lp_n), .pair(pair), .pairs(pairs),
        .low_power(low_power));
`else
    wire xclk, standby;
`endif
    wire [11:0] d;
    pullup (scl);
    pullup (sda);
    assign sda = sda_low ? 1'b0 : 1'bz;
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(xclk), .reset_n(sensor_reset_n && !standby), .pixclk(pixclk), .frame_valid(fval),
        .line_valid(lval), .data(d), .scl(scl), .sda(sda), .sda_low(sda_low));
`endif

    wire [2:0] lanes;
    wire lane_clock;
    dvi_monitor monitor (.clock(lane_clock), .lanes(lanes));

    wire following, raw, again, over;
    board_run script (.following(following), .raw(raw), .again(again), .over(over));
    wire [7:0] led;
    wire rx, tx, wifi;
    uart_host #(.BAUD(`NCDC_BAUD)) host (.receive(tx), .send(rx));
    ncdc_ulx3s dut (
        .clk25_0__io(clk25), .sdram_0__clk__io(clk), .sdram_0__clk_en__io(cke),
        .sdram_0__cs__io(cs_n), .sdram_0__we__io(we_n), .sdram_0__ras__io(ras_n),
        .sdram_0__cas__io(cas_n), .sdram_0__ba__io(ba), .sdram_0__a__io(a),
        .sdram_0__dqm__io(dqm), .sdram_0__dq__io(dq), .hdmi_0__d__p(lanes),
        .hdmi_0__clk__p(lane_clock),
`ifdef NCDC_CSI2
        .csi_camera_0__clock__p(pair), .csi_camera_0__lanes__p(pairs),
        .csi_camera_0__low_power__io(low_power), .csi_camera_0__scl__io(scl),
        .csi_camera_0__sda__io(sda), .csi_camera_0__reset_n__io(sensor_reset_n),
`elsif NCDC_PATTERN
`else
        .camera_0__pixclk__io(pixclk), .camera_0__fval__io(fval), .camera_0__lval__io(lval),
        .camera_0__d__io(d), .camera_0__scl__io(scl), .camera_0__sda__io(sda),
        .camera_0__reset_n__io(sensor_reset_n), .camera_0__standby__io(standby),
        .camera_0__xclk__io(xclk),
`endif
        .uart_0__rx__io(rx), .uart_0__tx__io(tx), .button_right_0__io(following), .button_left_0__io(1'b0),
        .button_fire_0__io(raw), .button_down_0__io(again), .led_0__io(led[0]), .led_1__io(led[1]), .led_2__io(led[2]),
        .led_3__io(led[3]), .led_4__io(led[4]), .led_5__io(led[5]), .led_6__io(led[6]),
        .led_7__io(led[7]), .esp32_0__en__io(wifi));

    always @(led) $display("LED %0d %0d", $time / 1000000, led);
    always @(posedge over) begin
        sdram.report;
        $display("RESULT monitor_errors %0d", monitor.errors);
        $display("RESULT underruns %0d", dut.core.screen.underruns);
        $display("RESULT shown %0d", dut.core.screen.shown);
        $display("RESULT failures %0d", dut.core.programs.failures);
        $display("RESULT led %0d", led);
        $fflush;
        monitor.close;
        $finish;
    end
endmodule
