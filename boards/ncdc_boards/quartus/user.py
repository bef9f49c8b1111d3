"""The module that is the user's, as it is written the first time."""

from ncdc_boards.quartus.names import USER

__all__ = ["user_module"]


def user_module():
    """Verilog of the module: it passes picture and lights on as they are."""
    return f"""\
// This file is yours. `ncdc build` writes it once, and never again when it is there; all else in
// this folder is made anew each time.
//
// The picture goes through this module on its way to the screen, and the lights on theirs. As it is
// it changes nothing. A register in one of the `_out` of the picture needs one in all of them.

module {USER} (
    input wire        clk,              // of the core; `lights_in` belong to it
    input wire        pixel_clk,        // of the screen; the picture belongs to it
    // One pixel per clock.
    input wire        visible_in,       // in the picture; low in the blanking around it
    input wire        hsync_in,         // as on the wire: low or high, as the mode has it
    input wire        vsync_in,
    input wire  [7:0] r_in,
    input wire  [7:0] g_in,
    input wire  [7:0] b_in,
    output wire       visible_out,
    output wire       hsync_out,
    output wire       vsync_out,
    output wire [7:0] r_out,            // 0 in the blanking
    output wire [7:0] g_out,
    output wire [7:0] b_out,
    // 0: memory ready, 1: set-up over, 2: no answer from the sensor, 3: memory too slow for the
    // screen, from 4 on: number of the lens.
    input wire  [7:0] lights_in,
    output wire [7:0] lights_out
);
    assign visible_out = visible_in;
    assign hsync_out = hsync_in;
    assign vsync_out = vsync_in;
    assign r_out = r_in;
    assign g_out = g_in;
    assign b_out = b_in;
    assign lights_out = lights_in;
endmodule
"""
