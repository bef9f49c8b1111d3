"""Begin and end of a burst at the wires of a CSI-2 lane:
``python -m ncdc_bench.figures.csi2_pins docs/figures/csi2-pins.svg``.
"""

import sys

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ncdc_bench.figures.box_drawing import write_figure
from ncdc_boards.ecp5.csi2_camera import LANE_HZ_MAX
from ncdc_spec.sensors.csi2 import SYNC_BYTE

__all__ = ["draw"]

_LOW_POWER, _HIGH, _LOW = 1.2, .3, .1   # volts of a wire: D-PHY, typical
_THRESHOLD = .6                         # of an input of type LVCMOS12
# Nanoseconds of the parts of a burst, as the transmitter in sim/ncdc_sim/hdl has them.
_STOP, _LPX, _PREPARE, _ZERO, _TRAIL = 60, 50, 60, 130, 70
_SETTLE = 132                           # the middle of T_HS-SETTLE at this rate
_STRETCHED = 4                          # so many times as long bits are drawn
_BITS = [SYNC_BYTE >> k & 1 for k in range(8)] + [1, 1, 0, 1, 0, 1, 0, 0]


def _wires():
    """(Nanoseconds, volts of Dp, volts of Dn) of the changes, and the ends of the parts."""
    parts = np.cumsum([_STOP, _LPX, _PREPARE, _ZERO])
    bit = _STRETCHED * 1e9 / LANE_HZ_MAX
    sent = parts[-1] + bit * np.arange(len(_BITS) + 1)
    points = [(0, _LOW_POWER, _LOW_POWER), (parts[0], 0, _LOW_POWER), (parts[1], 0, 0),
              (parts[2], _LOW, _HIGH)]
    points += [(at, *((_HIGH, _LOW) if one else (_LOW, _HIGH))) for at, one in zip(sent, _BITS)]
    points += [(sent[-1], *((_LOW, _HIGH) if _BITS[-1] else (_HIGH, _LOW))),
               (sent[-1] + _TRAIL, _LOW_POWER, _LOW_POWER),
               (sent[-1] + _TRAIL + _STOP, _LOW_POWER, _LOW_POWER)]
    return np.array(points).T, [*parts, sent[8], sent[-1], sent[-1] + _TRAIL]


def draw(path):
    """Draw into the file ``path``."""
    (times, plus, minus), ends = _wires()
    settled = ends[1] + _SETTLE
    figure = Figure(figsize=(11, 3.6))
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for volts, name, shift in ((plus, "Dp", 1.9), (minus, "Dn", 0)):
        axes.step(times, volts + shift, where="post", color="black", linewidth=1)
        axes.text(-8, shift + .5, name, ha="right")
    axes.axhline(_THRESHOLD, color="grey", linestyle=":", linewidth=.8)
    axes.text(times[-1] + 4, _THRESHOLD, "threshold at GP10", va="center", fontsize=8)
    active = [0, 0, 1, 1, 0, 0]
    axes.step([0, settled, settled, ends[-1], ends[-1], times[-1]],
              np.array(active) * .6 - 1.1, where="post", color="tab:blue", linewidth=1.4)
    axes.text(-8, -.9, "active", ha="right", color="tab:blue")
    names = "stop", "LP-01", "prepare", "zeros", "sync byte", "header, ...", "trail", "stop"
    for begin, end, name in zip([0, *ends], [*ends, times[-1]], names):
        axes.axvline(end, color="grey", linewidth=.4)
        axes.text((begin + end) / 2, 3.35, name, ha="center", fontsize=8)
    axes.annotate("", (settled, -.2), (ends[1], -.2), arrowprops={"arrowstyle": "<->"})
    axes.text((ends[1] + settled) / 2, -.42, "settle", ha="center", fontsize=8)
    axes.set(xlim=(-40, times[-1] + 70), ylim=(-1.2, 3.7), yticks=[],
             xlabel="ns; bits of 456 Mb/s are drawn four times as long")
    axes.spines[["left", "right", "top"]].set_visible(False)
    write_figure(path, figure)


if __name__ == "__main__":
    draw(sys.argv[1])
