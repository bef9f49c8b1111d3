"""Runs of a camera on the generated Verilog: frames, faults, readers."""

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ncdc_bench.system.readers import simulate_readers
from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.plan import Fixed, plan
from ncdc_model.planner.with_camera import clocks_with_camera, follow_bound_with_camera
from ncdc_sim.sensor.verilog import Fault, Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.camera_port import CSI2, fault_registers
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.catalogue import sensor_named
from ncdc_spec.sensors.framing import camera_of, setup_around

__all__ = ["FAULTS", "Run", "measure", "runs_of"]

VGA, SXGA, FHD, SMALL = (640, 480), (1280, 1024), (1920, 1080), (64, 24)
_EXPOSURE_US = 100.0
_CLOCK_MHZ = 100
_STALL = 200_000        # clocks: 2 ms at 100 MHz

# Fault, and the counter that must report it. The packet is a row of the second frame.
_BAD_CHECKSUM = "+csi2_bad_checksum=40"
_CSI_FAULTS = tuple(name.lower() for name in fault_registers(CSI2).values())
FAULTS = {
    "short_line": (Fault("short_line", 1, 7), "line_faults"),
    "long_line": (Fault("long_line", 1, 7), "line_faults"),
    "glitch": (Fault("glitch", 1, 7), "line_faults"),
    "cut_frame": (Fault("cut_frame", 1, 15), "frames_cut"),
    "clock_stop": (Fault("clock_stop", 1, 9, clocks=60_000), "clock_stops"),
    "memory_stall": (None, "overflows"),
    "nack": (Fault("nack", start=9), "NACK"),
    "stuck_sda": (Fault("stuck_sda", start=9), "LOST"),
    "checksum": (Fault("none"), "csi_checksum"),
}
_PARALLEL_FAULTS = [name for name in FAULTS if name != "checksum"]
_LANE_FAULTS = ["checksum", "cut_frame", "memory_stall", "nack", "stuck_sda"]


@dataclass(frozen=True)
class Run:
    """A camera to be run.

    Parameters
    ----------
    size : (int, int)
        Size of raw and corrected frames.
    memory, data_width, output, format : str, int, str, str
    frames : int
    follow : bool
    degrees : float
        Horizontal view of the lens.
    fault : str
        Name in :data:`FAULTS`; empty: none.
    readers : int
        Raw frames with readers that come and go at random; 0: none.
    camera : str
        Name of the sensor.
    """
    size: tuple
    memory: str = "sdram"
    data_width: int = 32
    output: str = "memory"
    format: str = "BGRX8"
    frames: int = 5
    follow: bool = False
    degrees: float = 105.0
    fault: str = ""
    readers: int = 0
    camera: str = "mt9p031"

    def __str__(self):
        what = f"{self.readers} frames with readers" if self.readers else f"{self.frames} frames"
        return (f"{what} of {self.camera}, {self.size[0]}x{self.size[1]}, on {self.memory}"
                + (", followed" if self.follow else "") + (f", {self.fault}" if self.fault else ""))



def runs_of(camera, quick):
    """The list of :class:`Run` of a sensor by its name; ``quick``: none above 640x480.

    Raises
    ------
    InputError
        If there is no such sensor.
    """
    faults = _LANE_FAULTS if sensor_named(camera).lanes else _PARALLEL_FAULTS
    runs = [Run(VGA), *(Run(SMALL, frames=3, fault=fault) for fault in faults),
            Run(SMALL, readers=100 if quick else 1000)]
    if not quick:
        runs += [Run(FHD, "ddr3", 128, frames=2, degrees=120.0),
                 Run(SXGA, frames=2, format="BGR8"),
                 Run(SXGA, frames=2, follow=True, format="BGR8")]
    return [replace(run, camera=camera) for run in runs]


def measure(runs, progress=lambda run: None):
    """A row for each of ``runs``; rows come one by one.

    Yields
    ------
    dict
        ``width``, ``height``, ``frames``, ``memory``, ``output``, ``format``, ``follow``,
        ``pixels_compared``, ``pixels_different``, ``frames_torn``, ``fault``. ``camera``, and its
        CSI-2 ``lanes``, 0 of a parallel one; ``samples_per_clock``. ``csi_faults``: faults that the
        receiver counted, None without one and with readers.
        ``camera_bytes_dropped``: of the rows in frames that lost samples or were missed.
        ``clocks_per_pixel``: of the slowest frame. ``predicted_clocks_per_pixel``: with the
        camera's own writes; None with early start, faults, readers or lanes, whose rows come in
        bursts that the model does not have. ``follow_latency_clocks``:
        with early start, from the camera's last sample to the interrupt.
        ``follow_bound_clocks``: the planner's bound. ``camera_clocks``: from the first sample to
        the last. ``recovered``: whether the fault was reported and the frames after it are right;
        None without one.
    """
    verilogs = {}
    for run in runs:
        yield _row(run, verilogs, progress(run))


def _row(run, verilogs, show):
    descriptor = trained(Lens(run.degrees, run.size, nodes="auto", interpolation="gradient"))
    hardware = Hardware(data_width=run.data_width, output=run.output, format=run.format)
    planned = plan(descriptor, hardware, run.memory,
                   lambda chosen: Corrector(descriptor, chosen).timing,
                   fixed=Fixed(strip=0) if run.follow else Fixed())
    setup, corner = setup_around(run.camera, descriptor.geometry, exposure_us=_EXPOSURE_US)
    system = System(descriptor, planned.hardware, camera=camera_of(setup, corner))
    key = descriptor.digest, system.hardware
    if key not in verilogs:
        verilogs[key] = system_verilog(system)
    width, height = run.size
    noise = np.random.default_rng(1).integers(0, 4096 - setup.sensor.black,
                                              (min(run.frames, 5), height, width), np.uint16)
    asked = setup.settings
    light = Light(noise, asked.left + corner.left, asked.top + corner.top)
    common = {"corner": corner, "verilog": verilogs[key], "memory": run.memory, "progress": show}
    row = {"width": width, "height": height, "memory": run.memory, "output": run.output,
           "format": run.format, "follow": run.follow, "fault": run.fault or None,
           "camera": run.camera, "lanes": setup.sensor.lanes,
           "samples_per_clock": system.camera.samples, "csi_faults": None,
           "predicted_clocks_per_pixel": None, "follow_latency_clocks": None,
           "follow_bound_clocks": None, "camera_clocks": None, "recovered": None}
    if run.readers:
        return row | _readers(simulate_readers(system, setup, light, count=run.readers, seed=1,
                                               **common), width * height)
    fault, counter = FAULTS.get(run.fault, (None, None))
    disturb = (lambda host: host.live.stall(_STALL)) if run.fault == "memory_stall" else None
    result = simulate_camera(system, setup, light, count=run.frames, follow=run.follow, fault=fault,
                             disturb=disturb,
                             more=(_BAD_CHECKSUM,) if run.fault == "checksum" else (), **common)
    row |= _frames(result, setup)
    if counter:
        reported = counter in result.i2c_errors or result.report().get(counter, 0) > 0
        return row | {"recovered": reported and row["pixels_different"] == 0}
    return row | _predicted(run, system, setup, result)


def _predicted(run, system, setup, result):
    """The planner's figures for a run without faults."""
    descriptor, hardware, timing = system.descriptor, system.hardware, setup.timing
    if setup.link:
        return {}
    memory, own = memory_at(run.memory, _CLOCK_MHZ), system.corrector.timing
    ratio = Fraction(_CLOCK_MHZ * 10**6, timing.pixel_clock_hz)
    if not run.follow:
        clocks = clocks_with_camera(descriptor, hardware, memory, own, timing, ratio)
        return {"predicted_clocks_per_pixel": clocks / (run.size[0] * run.size[1])}
    bound = follow_bound_with_camera(descriptor, hardware, memory, own, timing, ratio)
    sent = bound.camera_clocks
    return {"follow_latency_clocks": max(frame.age for frame in result.frames) - sent,
            "follow_bound_clocks": bound.clocks, "camera_clocks": sent}


def _readers(result, pixels):
    """Figures of frames with readers: each that was read whole was compared."""
    whole = result.raw + result.corrected
    return {"frames": result.begun, "pixels_compared": whole * pixels,
            "pixels_different": result.torn * pixels, "frames_torn": result.torn,
            "camera_bytes_dropped": 0, "clocks_per_pixel": None}


def _frames(result, setup):
    """Figures of corrected frames."""
    report, timing = result.report(), setup.timing
    lost = report["overflows"] + report["frames_missed"]
    csi = [report[name] for name in _CSI_FAULTS if name in report]
    return {
        "csi_faults": sum(csi) if csi else None,
        "frames": report["frames"], "pixels_compared": report["pixels_compared"],
        "pixels_different": report["pixels_different"],
        # A frame that lost samples is dropped whole.
        "camera_bytes_dropped": lost * timing.width * timing.height, "frames_torn": 0,
        "clocks_per_pixel": report["clocks_per_pixel"]}
