"""The clocks of a board's SDRAM.

    python -m ncdc_bench.figures.sdram_clock_diagram docs/figures/board-sdram-clock.png
"""

import re
import sys

from matplotlib.figure import Figure

from ncdc_bench.figures.box_drawing import write_figure
from ncdc_boards.quartus.de1_soc import BOARD
from ncdc_boards.quartus.sdc import SDRAM_NS
from ncdc_hdl.video.modes import mode_named
from ncdc_sim.runner import HDL

__all__ = ["draw_sdram_clock"]

_LINE, _FILL, _TEXT = "#30507a", "#cfdff2", 9


def draw_sdram_clock(path):
    """Draw when the SDRAM samples a command, and when the core takes what it answers.

    Outputs and inputs of the FPGA take what they take in the simulation by default.
    """
    plan = BOARD.clock_plan(mode_named("640x480"))
    period, late = 1000 / plan.core_mhz, plan.phase_ps / 1000
    out, back = _pins()
    figure = Figure(figsize=(11.5, 3.4))
    axes = figure.subplots()
    end = 3.2 * period
    _clock(axes, 3, 0, period, end)
    _window(axes, 1, out, out + period, "command")
    _clock(axes, 2, late + out - period, period, end)
    first, last = (late + out + back + SDRAM_NS["access"],
                   late + period + out + back + SDRAM_NS["output_hold"])
    _window(axes, 0, first, last, "word that answers")
    for x, rows, text in ((late + out, (1, 2.8), "sampled"), (2 * period, (0, 3.8), "taken")):
        axes.plot((x, x), rows, color="#a03030", linewidth=1, linestyle="--")
        axes.text(x + .2, rows[0] - .06, text, color="#a03030", fontsize=_TEXT, va="top")
    axes.set_yticks((.3, 1.3, 2.3, 3.3), ("data, after the\nFPGA's inputs",
                                          "command at\nthe SDRAM", "clock at\nthe SDRAM",
                                          "core's clock"))
    axes.set_xlabel(
        f"ns; core's clock {plan.core_mhz:g} MHz, the SDRAM's {late:.3f} ns late, outputs take "
        f"{out:g}, inputs {back:g}, CAS latency left out\nthe chip needs a command "
        f"{SDRAM_NS['setup']} before and {SDRAM_NS['hold']} after its edge; gives data within "
        f"{SDRAM_NS['access']}, keeps them {SDRAM_NS['output_hold']} after the next",
        fontsize=_TEXT)
    axes.set_xlim(0, end)
    axes.set_ylim(-.5, 3.9)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    write_figure(path, figure)


def _pins():
    """ns that outputs and inputs take in ``sdram_board.v``."""
    text = (HDL / "sdram_board.v").read_text()
    return tuple(int(re.search(rf"`define NCDC_{name} (\d+)", text)[1]) / 1000
                 for name in ("FLIGHT", "BACK"))


def _clock(axes, row, first, period, end):
    x, y, rise = [0], [row + .6 * (first > period / 2)], first
    while rise < end:
        for at, level in ((rise - period / 2, 0), (rise, .6)):
            if at >= 0:
                x += [at, at]
                y += [y[-1], row + level]
        rise += period
    axes.plot((*x, end), (*y, y[-1]), color=_LINE, linewidth=1.4)


def _window(axes, row, start, end, text):
    axes.fill_between((start, end), row, row + .6, facecolor=_FILL, edgecolor=_LINE)
    axes.text((start + end) / 2, row + .3, text, ha="center", va="center", fontsize=_TEXT)


if __name__ == "__main__":
    draw_sdram_clock(sys.argv[1])
