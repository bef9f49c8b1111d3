"""A simulated camera that sends AXI4-Stream video by itself, running."""

from contextlib import contextmanager

import numpy as np

from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_sim.system.host import SystemHost
from ncdc_sim.system.live import Clocks, LiveSystem
from ncdc_sim.system.running import Running
from ncdc_spec.errors import InputError
from ncdc_spec.registers.system_values import memory_bytes
from ncdc_spec.sensors.level import levelled

__all__ = ["video_running"]


@contextmanager
def video_running(system, timing, light, *, clock_hz, verilog=None, **run):
    """A :class:`Running` camera that sends AXI4-Stream video, as a context.

    Its samples have no black level. It begins its first frame once the system is enabled.

    Parameters
    ----------
    system : ncdc_hdl.system.System
        With a camera of the kind ``axis``.
    timing : ncdc_spec.sensors.sensor.Timing
        Samples of a row, rows, and samples per second, of all samples of a beat together.
    light : Light
        Frames of the size of ``timing``, which are sent again and again.
    clock_hz : int
        Clock of the system.
    verilog : str, optional
        The system's text; made if absent.
    run :
        As of :class:`LiveSystem`, but for ``clocks`` and ``camera``.

    Raises
    ------
    InputError
        If a row or a line is not of whole beats.
    """
    beat = system.camera.samples
    for name in ("width", "line_clocks"):
        if (value := getattr(timing, name)) % beat:
            raise InputError(f"{name} of the video is {value}, it must be a multiple of the {beat} "
                             "samples of a beat")
    period = 10**12 * beat / timing.pixel_clock_hz
    clocks = Clocks(clk_period=2 * round(5e11 / clock_hz), extclk_period=2 * round(period / 2))
    lines = (f"+camera_line_clocks={timing.line_clocks // beat}",
             f"+camera_frame_lines={timing.frame_lines}")
    size = memory_bytes(system.descriptor, system.hardware, system.stores)
    with LiveSystem(verilog or system_verilog(system), None, light, size,
                    clocks=clocks, camera=system.camera, more=lines, **run) as live:
        host = SystemHost(live, system)
        frame = timing.frame_clocks // beat * clocks.extclk_period // clocks.clk_period
        host.camera.put(CLOCK_LIMIT=frame // 2)
        host.camera.start()
        live.sensor_power(True)
        mask = (1 << 12) - (1 << max(0, 12 - system.camera.bits))
        yield Running(host, levelled(np.asarray(light.frames) & mask), frame)
