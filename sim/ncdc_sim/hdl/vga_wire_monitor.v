// A monitor at VGA pins without a clock, after resistors. Like a real one it knows the mode from the
// sync pulses' lengths alone, here from parameters, divides the time between two HSYNC pulses into the
// mode's pixels, and samples in the middle of each. It writes what vga_monitor.v does; "visible" is
// where the mode has its picture, counted from the pulses. A colour elsewhere is an error.

`timescale 1ps/1ps

module vga_wire_monitor #(
    parameter BITS = 4, H = 0, H_FRONT = 0, H_SYNC = 0, H_BACK = 0,
    parameter V = 0, V_FRONT = 0, V_SYNC = 0, V_BACK = 0, HIGH = 0
) (
    input wire            hsync, vsync,
    input wire [BITS-1:0] r, g, b
);
    localparam TOTAL = H + H_FRONT + H_SYNC + H_BACK;
    wire h = hsync == HIGH, v = vsync == HIGH;
    real last, line;                    // when the last pulse began; time from one to the next
    integer errors, file, pulses, k, rows;
    reg measured = 0, shown;
    initial begin
        last = 0; line = 0; errors = 0; rows = 0; pulses = -1;
        file = $fopen("screen.bin", "wb");
    end
    // Row n of those after a frame's pulse begins with its n-th line pulse.
    always @(posedge v) rows = 0;

    always @(posedge h) begin
        line = $realtime - last;
        last = $realtime;
        rows = rows + 1;
        pulses = pulses + 1;
        if (pulses == 2) begin
            measured = 1;
            $display("MONITOR clock %0f", line / TOTAL);
        end
    end
    always @(posedge h) begin
        #1;
        if (measured) begin
            #(line / TOTAL / 2 - 1);
            for (k = 0; k < TOTAL; k = k + 1) begin
                shown = k >= H_SYNC + H_BACK && k < H_SYNC + H_BACK + H
                    && rows >= V_SYNC + V_BACK && rows < V_SYNC + V_BACK + V;
                if (!shown && {r, g, b} != 0) begin
                    errors = errors + 1;
                    if (errors < 20) $display("MONITOR-ERROR a colour in the blanking");
                end
                $fwrite(file, "%c%c%c%c", {r, {8-BITS{1'b0}}}, {g, {8-BITS{1'b0}}},
                        {b, {8-BITS{1'b0}}}, {5'd0, vsync, hsync, shown});
                if (k != TOTAL - 1) #(last + (k + 1.5) * line / TOTAL - $realtime);
            end
        end
    end

    task close;
        $fclose(file);
    endtask
endmodule
