"""The user's module, as it is written the first time."""

from ncdc_boards.quartus.names import USER

__all__ = ["user_module"]


def user_module():
    """Verilog of the module: it passes picture and LEDs unchanged."""
    return f"""\
// This file is yours. `ncdc build` writes it once, and does not overwrite it; all other files of
// this folder are written again each time.
//
// The picture goes through this module to the screen, and `lights` to the LEDs. As
// written it changes nothing. With a register in one `_out` of the picture, all need one.

module {USER} (
    input wire        clk,              // of the core; `lights_in` are synchronous to it
    input wire        pixel_clk,        // of the screen; the picture is synchronous to it
    // One pixel per clock.
    input wire        visible_in,       // in the picture; low in the blanking around it
    input wire        hsync_in,         // as on the wire, with the mode's polarity
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
    // 0: memory ready, 1: configured, 2: no answer from the sensor, 3: memory too slow for the
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
