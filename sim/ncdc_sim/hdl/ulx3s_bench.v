// A ULX3S from the sensor's pins to the monitor's: the generated top, the SDRAM's model, a sensor, a
// monitor, buttons.
//
// The SDRAM's data come `ACCESS` ps behind its clock's edge and stay for `HOLD` ps behind the next
// one; in between DQ holds the wrong bits. `FLIGHT` ps are the FPGA's outputs and the way to the
// chip, `BACK` ps the way back and the FPGA's input.
//
// Plusargs: run_us, how long it runs; press_following_us, press_raw_us, when a button is pressed (0:
// never), for hold_us; those of the sensor.
//
// Results: lines "RESULT <name> <value>"; screen.bin, see dvi_monitor.v.

`timescale 1ps/1ps

module ulx3s_bench;
    localparam FLIGHT = 3000, ACCESS = 6000, HOLD = 2700, BACK = 1500;

    integer run_us, following_us, raw_us, hold_us;
    reg clk25 = 0;
    always #20000 clk25 = !clk25;

    // The SDRAM.
    wire clk, cke, cs_n, ras_n, cas_n, we_n;
    wire [1:0]  ba, dqm;
    wire [12:0] a;
    wire [15:0] dq;
    reg         c_clk = 0, c_cke = 0, c_cs_n = 1, c_ras_n = 1, c_cas_n = 1, c_we_n = 1;
    reg  [1:0]  c_ba = 0, c_dqm = 3;
    reg  [12:0] c_a = 0;
    reg  [15:0] c_dq = 0;
    reg         oe = 0, c_oe = 0;
    wire        chip_drives;
    wire [15:0] chip_dq;
    wire [31:0] violations, refreshes, refresh_most, beats_read, beats_written;

    always @(posedge dut.sdram_dq.clk) oe <= dut.sdram_dq.oe;
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

    reg [15:0] read_dq = 0;             // at the FPGA's pin
    reg        read_drives = 0;
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
    assign dq = read_drives || chip_drives ? read_dq : 16'bz;

    // The sensor, and its bus.
    wire xclk, sensor_reset_n, standby, pixclk, fval, lval, scl, sda, sda_low;
    wire [11:0] d;
    pullup (scl);
    pullup (sda);
    assign sda = sda_low ? 1'b0 : 1'bz;
    sensor #(.SENSOR(`NCDC_SENSOR)) sensor (
        .extclk(xclk), .reset_n(sensor_reset_n && !standby), .pixclk(pixclk), .frame_valid(fval),
        .line_valid(lval), .data(d), .scl(scl), .sda(sda), .sda_low(sda_low));

    wire [2:0] lanes;
    wire lane_clock;
    dvi_monitor monitor (.clock(lane_clock), .lanes(lanes));

    reg following = 0, raw = 0;
    wire [7:0] led;
    wire tx, wifi;
    ncdc_ulx3s dut (
        .clk25_0__io(clk25), .sdram_0__clk__io(clk), .sdram_0__clk_en__io(cke),
        .sdram_0__cs__io(cs_n), .sdram_0__we__io(we_n), .sdram_0__ras__io(ras_n),
        .sdram_0__cas__io(cas_n), .sdram_0__ba__io(ba), .sdram_0__a__io(a),
        .sdram_0__dqm__io(dqm), .sdram_0__dq__io(dq), .hdmi_0__d__p(lanes),
        .hdmi_0__clk__p(lane_clock), .camera_0__pixclk__io(pixclk), .camera_0__fval__io(fval),
        .camera_0__lval__io(lval), .camera_0__d__io(d), .camera_0__scl__io(scl),
        .camera_0__sda__io(sda), .camera_0__reset_n__io(sensor_reset_n),
        .camera_0__standby__io(standby), .camera_0__xclk__io(xclk), .uart_0__rx__io(1'b1),
        .uart_0__tx__io(tx), .button_right_0__io(following), .button_left_0__io(1'b0),
        .button_fire_0__io(raw), .led_0__io(led[0]), .led_1__io(led[1]), .led_2__io(led[2]),
        .led_3__io(led[3]), .led_4__io(led[4]), .led_5__io(led[5]), .led_6__io(led[6]),
        .led_7__io(led[7]), .esp32_0__en__io(wifi));

    initial begin
        if (!$value$plusargs("run_us=%d", run_us)) run_us = 1000;
        if (!$value$plusargs("press_following_us=%d", following_us)) following_us = 0;
        if (!$value$plusargs("press_raw_us=%d", raw_us)) raw_us = 0;
        if (!$value$plusargs("hold_us=%d", hold_us)) hold_us = 25000;
        fork
            if (following_us != 0) begin
                #(following_us * 1000000.0) following = 1;
                #(hold_us * 1000000.0) following = 0;
            end
            if (raw_us != 0) begin
                #(raw_us * 1000000.0) raw = 1;
                #(hold_us * 1000000.0) raw = 0;
            end
            begin
                #(run_us * 1000000.0);
                $display("RESULT violations %0d", violations);
                $display("RESULT refreshes %0d", refreshes);
                $display("RESULT beats_read %0d", beats_read);
                $display("RESULT beats_written %0d", beats_written);
                $display("RESULT monitor_errors %0d", monitor.errors);
                $display("RESULT underruns %0d", dut.screen.underruns);
                $display("RESULT shown %0d", dut.screen.shown);
                $display("RESULT failures %0d", dut.programs.failures);
                $display("RESULT led %0d", led);
                $fflush;
                monitor.close;
                $finish;
            end
        join
    end
endmodule
