"""The header of a Colorlight i9's extension board.

    python -m ncdc_bench.figures.header_diagram PNG
"""

import sys

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ncdc_bench.figures.box_drawing import write_figure
from ncdc_boards.colorlight_i9.platform import CAMERA_WIRES

__all__ = ["draw_header"]

_PINS = 30
_SUPPLY = {1: "3.3 V", 2: "3.3 V", 19: "3.3 V", 20: "3.3 V", 3: "ground", 4: "ground", 15: "ground",
           21: "ground", 22: "ground", 16: "5 V: never"}
_FILL = {"3.3 V": "#f4d9d9", "ground": "#dddddd", "5 V: never": "#e08080", "": "#ffffff"}
_LINE, _SIGNAL = "#30507a", "#cfdff2"


def draw_header(path):
    """Write a drawing of the header P2, seen from above, and of the camera's wire at each pin."""
    signals = {number: name.upper() + (str(k) if len(numbers) > 1 else "")
               for name, numbers in CAMERA_WIRES.items() for k, number in enumerate(numbers)}
    figure = Figure(figsize=(12.5, 2.9))
    axes = figure.subplots()
    for pin in range(1, _PINS + 1):
        # Pin 1 is at the right; odd pins are in the outer row.
        column, row = _PINS // 2 - (pin + 1) // 2, pin % 2
        text = signals.get(pin, _SUPPLY.get(pin, ""))
        fill = _SIGNAL if pin in signals else _FILL[text]
        axes.add_patch(Rectangle((column, row), .94, .6, facecolor=fill, edgecolor=_LINE))
        axes.text(column + .47, row + .3, str(pin), ha="center", va="center", fontsize=9)
        axes.text(column + .47, row + (.68 if row else -.06), text, ha="center", fontsize=8,
                  va="bottom" if row else "top", rotation=30)
    axes.set_xlim(-.2, _PINS / 2 + .2)
    axes.set_ylim(-.8, 2.5)
    axes.set_axis_off()
    write_figure(path, figure)


if __name__ == "__main__":
    draw_header(sys.argv[1])
