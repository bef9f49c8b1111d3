"""A simulated camera, set up and running."""

from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ncdc_hdl.camera.i2c import quarter_clocks
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.system.host import SystemHost
from ncdc_sim.system.live import Clocks, LiveSystem
from ncdc_spec.raw_gains import NO_RAW_GAINS, frame_gains
from ncdc_spec.registers.system_values import memory_bytes
from ncdc_spec.sensors.framing import Crop
from ncdc_spec.sensors.level import levelled
from ncdc_spec.white_balance import gains_word

__all__ = ["Running", "running"]

_I2C_HZ = 400_000


@dataclass(frozen=True)
class Running:
    """A camera that runs.

    Parameters
    ----------
    host : SystemHost
    raw : ndarray of uint8, shape (frames, height, width)
        The raw frames that capture makes of what the sensor sends, again and again.
    frame_clocks : int
        Clocks of the system from frame to frame.
    """
    host: SystemHost
    raw: np.ndarray
    frame_clocks: int

    def sent(self, number):
        """The raw frame of a number, from 1 on; frames that the store never saw count too."""
        index = number - 1 + self.host.get("FRAMES_MISSED")
        return self.raw[index % len(self.raw)]


@contextmanager
def running(system, setup, light, *, corner=(0, 0), clocks=None, verilog=None, registers=None,
            gains=NO_RAW_GAINS, **run):
    """A :class:`Running` camera, as a context.

    The sensor is set up by I2C while the camera is enabled already: its first frame is number 1.

    Parameters
    ----------
    system : ncdc_hdl.system.System
    setup : Setup
        Configuration of the sensor; its pixel clock is the one of the run.
    light : Light
    corner : Crop
        Crop of the sensor's frames in capture, as far as ``system`` supports it; or column and
        row at which the raw frames begin.
    clocks : Clocks, optional
        Clocks of the run; if absent 100 MHz, and the pixel clock of ``setup``.
    verilog : str, optional
        The system's text; made if absent.
    registers : dict, optional
        Written before the camera is enabled.
    gains : tuple of int
        Of the samples at capture, in 256ths.
    run :
        As of :class:`LiveSystem`. And ``quarter``, clocks of a quarter of a bit on the I2C bus; if
        absent those of 400 kHz.
    """
    sensor, quarter = setup.sensor, run.pop("quarter", None)
    lane_hz = setup.link.lane_hz if setup.link else 8e8
    clocks = clocks or Clocks(extclk_period=2 * round(5e11 / setup.timing.pixel_clock_hz),
                              lane_period=2 * round(4e12 / lane_hz))
    frame = setup.timing.frame_clocks * clocks.extclk_period // clocks.clk_period
    crop, geometry = Crop(*corner), system.descriptor.geometry
    raw = np.array(crop.raw(raw_frames(setup, light), geometry.distorted))
    size = memory_bytes(system.descriptor, system.hardware, system.stores)
    with LiveSystem(verilog or system_verilog(system), sensor.name, light, size,
                    clocks=clocks, **run) as live:
        host = SystemHost(live, system)
        live.sensor_power(True)
        live.wait(100)
        host.quarter = quarter or quarter_clocks(10**12 // clocks.clk_period, _I2C_HZ)
        if setup.link:
            host.camera.put(CSI_CHANNEL=0, CSI_TYPE=setup.link.data_type)
        if crop.grid:
            host.camera.put(GRID_WEIGHT=crop.weight, GRID_BIN=crop.binning)
        host.camera.put(SENT_WIDTH=setup.timing.width, SENT_HEIGHT=setup.timing.height,
                        WINDOW_LEFT=crop.left, WINDOW_TOP=crop.top, BLACK_LEVEL=sensor.black,
                        CLOCK_LIMIT=frame // 2, I2C_QUARTER=host.quarter,
                        CAPTURE_GAINS=gains_word(gains), **(registers or {}))
        # Without the waits, which are those of a PLL.
        report = setup.report()
        writes = [write | {"wait_us": 0} for write in report["writes"]]
        host.camera.set_up(report | {"writes": writes[:-1]})
        host.camera.start()
        host.camera.set_up(report | {"writes": writes[-1:]})
        yield Running(host, levelled(raw, sensor.black, gains=frame_gains(geometry, gains)), frame)
