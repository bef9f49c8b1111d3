"""The drawing of ``docs/reference/axi.md``.

    python -m ncdc_bench.figures.axi_diagram docs/figures/axi.png
"""

import sys

from ncdc_bench.figures.box_drawing import draw_boxes

__all__ = ["DRAWING", "draw"]

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


DRAWING = (tuple(_BOXES.values()), _ARROWS,
           "aclk, aresetn: from the same clock and reset block as the interconnect")


def draw(path):
    """Write the drawing of a corrector in the programmable logic next to its processor."""
    draw_boxes(path, *DRAWING)


if __name__ == "__main__":
    draw(sys.argv[1])
