"""The drawing of ``docs/axi.md``: ``python -m ncdc.report.axi_diagram docs/figures/axi.png``."""

import sys

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

__all__ = ["draw"]

_BOXES = {      # left, bottom, width, height, text
    "ps": (-.6, 0, 2.9, 4.6, "processing system\nof a Zynq or Kria\n\n"
           "Linux, ncdc_driver.py\n/dev/uio0\n\nDDR memory"),
    "core": (5.7, 0, 2.6, 4.6, "ncdc_axi\n\nregisters\n\ncache of tiles,\nnetwork,\n"
             "interpolation\n\nburst writer"),
    "video": (11.2, .9, 2.1, 1.1, "video out,\nVDMA, ..."),
}
_ARROWS = (     # from x, to x, y, text above, text below
    (2.3, 5.7, 4.1, "s_axi", "M_AXI_GP0 / HPM0: registers"),
    (5.7, 2.3, 3.1, "irq", "IRQ_F2P"),
    (5.7, 2.3, 2.1, "m_axi_read0", "S_AXI_HP0: raw frame"),
    (5.7, 2.3, 1.1, "m_axi_write", "S_AXI_HP1: corrected frame"),
    (8.3, 11.2, 1.45, "m_axis", "instead, with --to stream"),
)


def draw(path):
    """Write the drawing of a corrector in the programmable logic beside its processor."""
    figure = Figure(figsize=(11.5, 4.1))
    axes = figure.subplots()
    for left, bottom, width, height, text in _BOXES.values():
        axes.add_patch(Rectangle((left, bottom), width, height, facecolor="#eef3fa",
                                 edgecolor="#30507a", linewidth=1.4))
        axes.text(left + width / 2, bottom + height / 2, text, ha="center", va="center",
                  fontsize=10)
    for start, end, y, above, below in _ARROWS:
        axes.annotate("", (end, y), (start, y), arrowprops={
            "arrowstyle": "-|>", "color": "#30507a", "linewidth": 1.4})
        axes.text((start + end) / 2, y + .08, above, ha="center", va="bottom", fontsize=9.5,
                  family="monospace")
        axes.text((start + end) / 2, y - .1, below, ha="center", va="top", fontsize=8.5)
    axes.text(6.7, -.35, "aclk, aresetn: from the same clock and reset block as the interconnect",
              ha="center", va="top", fontsize=8.5)
    axes.set_xlim(-.7, 13.4)
    axes.set_ylim(-.8, 4.8)
    axes.set_axis_off()
    figure.savefig(path, dpi=90, format="png", metadata={"Software": None}, bbox_inches="tight")


if __name__ == "__main__":
    draw(sys.argv[1])
