"""The Verilog model of a sensor: its files, and its plusargs."""

from dataclasses import dataclass

import numpy as np

from ncdc_sim.runner import hdl_text

__all__ = ["AWAKE", "Light", "Fault", "sensor_sources"]

_FILES = ("sensor.v", "sensor_core.v", "sensor_i2c.v", "sensor_waking.v", "sensor_mt9p031.v",
          "sensor_mt9d111.v", "sensor_ov5640.v", "sensor_imx219.v", "sensor_ov5647.v",
          "csi2_transmitter.v")
AWAKE = 10**6
"""Time scale with which the model needs neither reset nor rest: for simulations of what comes
after them."""


def sensor_sources():
    """List of (file name, text) of the module ``sensor`` and of all below it, and of
    ``csi2_transmitter``."""
    return [(name, hdl_text(name)) for name in _FILES]


@dataclass(frozen=True)
class Light:
    """The light on a sensor, as samples.

    Parameters
    ----------
    frames : array of uint16, shape (frames, height, width)
        Samples of 12 bits, those that the sensor sends with the exposure ``nominal``, a gain of 1
        and no black level.
    left, top : int
        Active pixel of the first column, and row; pixels outside are dark.
    nominal : int
        Pixel clocks; 0: exposure and gain change nothing.
    """
    frames: np.ndarray
    left: int = 0
    top: int = 0
    nominal: int = 0

    def data(self):
        """Bytes of the file that the model reads."""
        return np.ascontiguousarray(self.frames, "<u2").tobytes()

    def plusargs(self, file, time_scale=AWAKE):
        """Plusargs of the model, which reads ``file``; ``time_scale`` divides the times of its
        reset and its rest."""
        height, width = self.frames.shape[1:]
        return [f"+sensor_file={file}", f"+sensor_file_width={width}",
                f"+sensor_file_height={height}", f"+sensor_file_left={self.left}",
                f"+sensor_file_top={self.top}", f"+sensor_nominal={self.nominal}",
                f"+sensor_time_scale={time_scale}"]


@dataclass(frozen=True)
class Fault:
    """A fault of the model, once.

    Parameters
    ----------
    kind : str
        "short_line", "long_line", "glitch", "cut_frame", "clock_stop", in a frame and row;
"nack", "stuck_sda", after a START condition; "unplug", from an external clock on. All
        count from 0.
    frame, row, start : int
    clocks : int
        Pixel clocks of "clock_stop", clocks of SCL of "stuck_sda", external clocks of "unplug"; 0:
        20,000, 9, none.
    """
    kind: str
    frame: int = 0
    row: int = 0
    start: int = 0
    clocks: int = 0

    def plusargs(self):
        """Plusargs of the model."""
        given = {"": self.kind, "_frame": self.frame, "_row": self.row, "_start": self.start}
        if self.clocks:
            given["_clocks"] = self.clocks
        return [f"+sensor_fault{name}={value}" for name, value in given.items()]
