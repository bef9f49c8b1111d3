// A monitor after a video converter ADV7123, at the FPGA's pins. The converter takes colours and
// BLANK with the rising edge of its clock, and shows them with the next one (Analog Devices, ADV7123
// data sheet, pipeline delay); the sync pulses go to the connector as they are. Each clock is written
// as four bytes: red, green, blue, and bit 0 visible, 1 HSYNC, 2 VSYNC. A colour in the blanking is
// what no monitor forgives: it is an error.
//
// Prints "MONITOR-ERROR <reason>" for that, and for inputs that change within SETUP ps before the
// clock's edge or HOLD ps after it; "MONITOR clock <ps>" with the first pixel.

`timescale 1ps/1ps

module vga_monitor #(parameter SETUP = 500, HOLD = 1500) (
    input wire       clock, hsync, vsync, blank_n,
    input wire [7:0] r, g, b
);
    real last, period, changed;
    integer errors, file;
    reg measured = 0;
    reg visible = 0;                    // as the converter shows it
    reg [7:0] red = 0, green = 0, blue = 0;
    initial begin
        last = 0; period = 0; changed = 0; errors = 0;
        file = $fopen("screen.bin", "wb");
    end

    task wrong(input integer reason);
        begin
            errors = errors + 1;
            if (errors < 20)
                case (reason)
                    0: $display("MONITOR-ERROR inputs change before the clock");
                    1: $display("MONITOR-ERROR inputs change after the clock");
                    default: $display("MONITOR-ERROR a colour in the blanking");
                endcase
        end
    endtask

    always @(r, g, b, blank_n) begin
        if (measured && $realtime - last < HOLD) wrong(1);
        changed = $realtime;
    end
    always @(posedge clock) begin
        if (measured && $realtime - changed < SETUP) wrong(0);
        period = $realtime - last;
        last = $realtime;
        if (!measured && visible) begin
            measured = 1;
            $display("MONITOR clock %0f", period);
        end
        if (!visible && {red, green, blue} != 0) wrong(2);
        if (measured)
            $fwrite(file, "%c%c%c%c", red, green, blue, {5'd0, vsync, hsync, visible});
        visible = blank_n;
        red = r;
        green = g;
        blue = b;
    end

    task close;
        $fclose(file);
    endtask
endmodule
