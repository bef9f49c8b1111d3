"""Timing constraints of a board's pins, beyond the oscillator's."""

__all__ = ["constraints"]

# Name of a phase-locked loop's output k, as Quartus derives it.
_OUTPUT = {"Cyclone IV E": "*{pll}*clk\\[{k}\\]*", "Cyclone V": "*{pll}*generic_pll{n}*divclk*"}


def constraints(board):
    """Text for the .sdc of ``board``: derived clocks, SDRAM and video delays in ns.

    The SDRAM samples its inputs at its own clock pin: set-up 1.5 ns, hold 0.8 ns (IS42S16320,
    -7), traces of both boards below 0.5 ns. Its data come at most ``t_ac`` after the clock and are
    held for 2.7 ns.
    """
    sdram_clock = _output(board, "pll_core", 1)
    pixel_clock = _output(board, "pll_pixel", 0)
    lines = ["derive_pll_clocks", "derive_clock_uncertainty",
             f"set sdram_clock [get_clocks {{{sdram_clock}}}]",
             f"set pixel_clock [get_clocks {{{pixel_clock}}}]"]
    outputs = " ".join(f"sdram_0__{name}*" for name in
                       ("a", "ba", "cas_n", "cke", "cs_n", "dq", "ras_n", "we_n"))
    lines += [
        f"set_output_delay -clock $sdram_clock -max 2.0 [get_ports {{{outputs}}}]",
        f"set_output_delay -clock $sdram_clock -min -0.8 [get_ports {{{outputs}}}]",
        f"set_input_delay -clock $sdram_clock -max {board.sdram.t_ac + .5:.1f} "
        "[get_ports {sdram_0__dq*}]",
        "set_input_delay -clock $sdram_clock -min 2.7 [get_ports {sdram_0__dq*}]",
        # The converter's clock is the pixel clock inverted: set-up 0.5 ns, hold 1.5 ns.
        "set_output_delay -clock $pixel_clock -clock_fall -max 0.5 [get_ports {vga_0__*}]",
        "set_output_delay -clock $pixel_clock -clock_fall -min -1.5 [get_ports {vga_0__*}]",
        "set_false_path -from [get_ports {rst_0__io*}]",
        # The queue of the video output is the only way between the two.
        f"set_clock_groups -asynchronous -group [get_clocks {{{_output(board, 'pll_core', 0)}}}] "
        "-group $pixel_clock",
    ]
    return "\n".join(lines) + "\n"


def _output(board, pll, k):
    return _OUTPUT[board.family].format(pll=pll, k=k, n=k + 1)
