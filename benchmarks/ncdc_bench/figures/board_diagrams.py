"""The drawings of the pages on boards.

    python -m ncdc_bench.figures.board_diagrams docs/figures
"""

import re
import sys
from pathlib import Path

from matplotlib.figure import Figure

from ncdc_bench.figures.box_drawing import draw_boxes
from ncdc_boards.quartus.de1_soc import BOARD
from ncdc_boards.quartus.sdc import SDRAM_NS
from ncdc_hdl.video.modes import mode_named
from ncdc_sim.runner import HDL

__all__ = ["DRAWING", "draw_all"]

_BOXES = (
    (-.4, 1.5, 2.4, 2.2, "sensor\n\nMT9P031 (D5M),\nOV5640"),
    (4.2, 0, 3.0, 5.2, "camera system\n\ncapture\n\nframe stores\n\ncorrector"),
    (10.0, 0, 2.6, 2.2, "SDRAM controller"),
    (10.0, 3.0, 2.6, 2.2, "scan-out\n\none row early"),
    (15.4, 0, 2.0, 2.2, "SDRAM chip"),
    (15.4, 3.0, 2.0, 2.2, "monitor"),
)
_ARROWS = (
    (2.0, 4.2, 3.2, "pixel clock", "frame, line, data"),
    (4.2, 2.0, 2.0, "I2C", "registers"),
    (7.2, 10.0, 1.4, "write", "raw, corrected"),
    (10.0, 7.2, .6, "read", "raw"),
    (7.2, 10.0, 4.1, "reader", "newest whole frame"),
    (12.6, 15.4, 1.1, "bursts", "whole rows"),
    (12.6, 15.4, 4.1, "VGA, GPDI", "the mode's own rate"),
)
DRAWING = (_BOXES, _ARROWS, "the scan-out reads from memory too, with the highest priority; "
           "buttons choose the lens; registers through a serial port", (12.5, 4.3))
_LINE, _FILL, _TEXT = "#30507a", "#cfdff2", 9


def draw_all(folder):
    """Write both drawings into a folder: the blocks of a board, and the clocks of its SDRAM."""
    draw_boxes(str(Path(folder) / "board.png"), *DRAWING)
    _sdram_clock(Path(folder) / "board-sdram-clock.png")


def _sdram_clock(path):
    """When the SDRAM samples a command, and when the core takes what it answers.

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
    figure.savefig(path, dpi=90, format="png", metadata={"Software": None}, bbox_inches="tight")


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
    draw_all(sys.argv[1])
