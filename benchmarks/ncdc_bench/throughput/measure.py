"""Whole frames on the generated Verilog: clocks and bytes per pixel of both fetchers."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.planner.lookups import frame_windows
from ncdc_model.planner.plan import CLOCK_MHZ, Fixed, plan
from ncdc_model.planner.traffic import distinct_bytes
from ncdc_sim.memory.litedram import LITEDRAM
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DEFAULT as WIDE

__all__ = ["ALL", "DEFAULT", "GOALS", "PAPER", "QUICK", "Run", "goal_rows", "measure",
           "table_four"]

VGA, SXGA, FHD = (640, 480), (1280, 1024), (1920, 1080)
ROTATIONS = 0, 2, 5, 45, 90

# Fetcher, memory, resolution, frames per second, as printed in Table IV of the paper.
PAPER = (("paper, DE2-115", "SDRAM", SXGA, 0.47), ("paper, FAKA2", "DDR3", FHD, 8.21))


@dataclass(frozen=True)
class Run:
    """One frame to be measured.

    Parameters
    ----------
    fetch : str
        "cache" or "multiport".
    lens : Lens
    memory : str
    output : str
        "stream" or "memory".
    cache_bytes, strip : int, optional
        Settings of the cache; planned if absent.
    lanes : int
        Pixels per clock.
    """
    fetch: str
    lens: Lens
    memory: str = "ddr3"
    output: str = "stream"
    cache_bytes: int | None = None
    strip: int | None = None
    lanes: int = 1

    @property
    def data_width(self):
        """Of the memory port: 128 bits before DDR3, 64 before the hard processor's, as wide as the
        memory elsewhere."""
        return {"ddr3": 128, "hps": 64}.get(self.memory, 32)

    @property
    def hardware(self):
        """The hardware of the run, without the choice of its tile cache."""
        return Hardware(data_width=self.data_width, output=self.output, fetcher=self.fetch,
                        lanes=self.lanes)

    @property
    def planned_memory(self):
        """The memory as given to the planner, which has no model of LiteDRAM's controller."""
        return "sdram" if self.memory in LITEDRAM else self.memory

    @property
    def settings(self):
        """The part of its row that is known before it is planned."""
        width, height = self.lens.corrected
        return {"fetch": self.fetch, "memory": self.memory, "width": width, "height": height,
                "lens": self.lens.degrees, "rotation": self.lens.rotation,
                "interpolation": self.lens.interpolation, "output": self.output,
                "data_width": self.data_width, "pixels_per_clock": self.lanes}

    def __str__(self):
        width, height = self.lens.corrected
        return (f"{self.fetch} on {self.memory} to {self.output}, {width}x{height}, lens "
                f"{self.lens} at {self.lens.rotation:g} degrees, {self.lens.interpolation}")


def _both(lens, memory, output):
    return [Run(fetch, lens, memory, output) for fetch in ("cache", "multiport")]


_FHD, _SXGA = Lens(120, FHD), Lens(105, SXGA)
_WIDE_FHD, _WIDE_SXGA = (Lens(lens.degrees, lens.size, interpolation=WIDE.name)
                         for lens in (_FHD, _SXGA))     # with windows of 6x6 samples
QUICK = [*_both(Lens(105, VGA), "ddr3", "stream"), *_both(Lens(105, VGA), "sdram", "stream"),
         Run("cache", Lens(105, VGA), "fixed:100:4"), Run("cache", Lens(105, VGA), output="memory")]
DEFAULT = [Run("cache", _FHD, cache_bytes=32768), Run("multiport", _FHD),
           Run("cache", _FHD, "fixed:100:4", cache_bytes=32768),
           Run("cache", _FHD, output="memory", cache_bytes=8192),
           Run("multiport", _FHD, output="memory"),
           *_both(_SXGA, "sdram", "stream"), *_both(_SXGA, "sdram", "memory"),
           Run("cache", _FHD, cache_bytes=32768, lanes=2),
           Run("cache", Lens(105, VGA), "litedram"),
           *(Run("cache", _WIDE_FHD, cache_bytes=32768, lanes=lanes) for lanes in (1, 2)),
           Run("cache", _WIDE_FHD, lanes=4),
           Run("cache", _WIDE_SXGA, "sdram", cache_bytes=32768)]
ALL = DEFAULT + [run for run in (Run("cache", Lens(degrees, size, rotation), "ddr3", output)
                                 for degrees, size in ((105, SXGA), (120, FHD))
                                 for rotation in ROTATIONS for output in ("stream", "memory"))
                 if run not in DEFAULT]


def measure(runs, progress=lambda run: None):
    """A row for each of ``runs``, measured on the generated Verilog; rows come one by one.

    Runs of the same hardware share its Verilog: another lens is another set of register values.

    Parameters
    ----------
    runs : list of Run
    progress : callable
        Called with each run before it; returns a callback of the simulation, or None.

    Yields
    ------
    dict
        ``fetch``, ``memory``, ``scan``, ``width``, ``height``, ``lens`` (degrees of its view),
        ``rotation``, ``interpolation``, ``output``, ``data_width``, ``cache_bytes``,
        ``cache_split``, ``strip``, ``pixels_per_clock``,
        ``clocks_per_pixel``, ``predicted_clocks_per_pixel`` (None of ``multiport`` and
        of LiteDRAM's controller),
        ``bytes_read_per_pixel``, ``amplification``, ``misses``, ``misses_expected``,
        ``frames_per_second`` at 100 MHz, ``pixels_compared``, ``pixels_different``.

    Raises
    ------
    InputError, SimulationError
        As of :func:`ncdc_sim.system.corrector.simulate_correction`.
    """
    tallest = {run.lens.interpolation: run.lens
               for run in sorted(runs, key=lambda run: run.lens.corrected[1])}
    verilogs = {}
    for run in runs:
        show = progress(run)
        descriptor = trained(run.lens)
        planned, hardware = None, run.hardware
        if hardware.cached:
            planned = plan(descriptor, hardware, run.planned_memory,
                           lambda chosen: Corrector(descriptor, chosen).timing,
                           fixed=Fixed(run.cache_bytes, strip=run.strip))
            hardware = planned.hardware
        interpolation = run.lens.interpolation
        built = replace(hardware, split=None, strip=0)
        if (built, interpolation) not in verilogs:
            verilogs[built, interpolation] = corrector_verilog(trained(tallest[interpolation]),
                                                               built)
        simulation = simulate_correction(
            descriptor, _noise(run.lens.size), hardware, verilog=verilogs[built, interpolation],
            progress=show, memory=run.memory)
        yield _row(run, descriptor, planned, simulation)


def _noise(size):
    return np.random.default_rng(1).integers(0, 256, size[::-1], dtype=np.uint8)


def _row(run, descriptor, planned, simulation):
    report = simulation.report()
    if planned:
        plans, distinct = planned.report(), planned.distinct
    else:
        plans = {"scan": "raster", "cache_bytes": 0, "cache_split": 0, "strip": 0,
                 "predicted_clocks_per_pixel": None}
        distinct = distinct_bytes(frame_windows(descriptor), descriptor.geometry)
    return {
        **run.settings, "scan": plans["scan"], "cache_bytes": plans["cache_bytes"],
        "cache_split": plans["cache_split"], "strip": plans["strip"],
        "clocks_per_pixel": report["clocks_per_pixel"],
        "predicted_clocks_per_pixel": (None if run.memory in LITEDRAM
                                       else plans["predicted_clocks_per_pixel"]),
        "bytes_read_per_pixel": report["bytes_read_per_pixel"],
        "amplification": simulation.bytes_read / distinct,
        "misses": report["windows_fetched"], "misses_expected": report["windows_fetched_expected"],
        "frames_per_second": CLOCK_MHZ * 1e6 / report["clocks"],
        "pixels_compared": report["pixels_compared"],
        "pixels_different": report["pixels_different"]}


def _is(**values):
    return lambda row: all(row[name] == value for name, value in values.items())


_CACHE_FHD = dict(fetch="cache", width=1920, height=1080, lens=120, rotation=0, output="stream",
                  interpolation="fast", pixels_per_clock=1)
# What is asked of rows: name, which rows, figure of a row, limit. The worst row counts.
GOALS = (
    ("clocks per pixel, 1920x1080, lens 120, ddr3, raster to a stream",
     _is(**_CACHE_FHD, memory="ddr3"), "clocks_per_pixel", 1.005),
    ("the same with latency 100 and 4 bytes per clock",
     _is(**_CACHE_FHD, memory="fixed:100:4"), "clocks_per_pixel", 1.06),
    ("read traffic over distinct bytes, raster, 32 KB",
     _is(**_CACHE_FHD, memory="ddr3", cache_bytes=32768), "amplification", 1.02),
    ("read traffic over distinct bytes, strips, 8 KB",
     _is(fetch="cache", scan="strip", rotation=0, lens=120, cache_bytes=8192), "amplification",
     1.15),
    ("clocks per pixel on ddr3, planner's choice, every lens and rotation",
     _is(fetch="cache", memory="ddr3", pixels_per_clock=1), "clocks_per_pixel", 1.02),
    ("clocks per pixel, two pixels per clock (at least 1.9 pixels per clock)",
     _is(fetch="cache", memory="ddr3", pixels_per_clock=2), "clocks_per_pixel", 1 / 1.9),
    (f"clocks per pixel, {WIDE.name}, 1920x1080, lens 120, ddr3, raster to a stream",
     _is(**_CACHE_FHD | {"interpolation": WIDE.name}, memory="ddr3"), "clocks_per_pixel", 1.005),
    (f"clocks per pixel, {WIDE.name}, four pixels per clock (at least 3.9 pixels per clock)",
     _is(interpolation=WIDE.name, memory="ddr3", pixels_per_clock=4), "clocks_per_pixel",
     1 / 3.9),
    ("clocks per pixel, 1280x1024, sdram, to a stream",
     _is(fetch="cache", memory="sdram", width=1280, output="stream"), "clocks_per_pixel", 1.05),
    ("clocks predicted, off by a factor of at most",
     lambda row: row["predicted_clocks_per_pixel"] is not None, "prediction_off", 1.01),
    ("misses that the planner did not count", _is(fetch="cache"), "misses_off", 0),
    ("wrong pixels", lambda row: True, "pixels_different", 0),
)


def goal_rows(rows):
    """(name, worst figure, limit, whether it holds) of each of :data:`GOALS`.

    If none of ``rows`` measures a goal, its figure and whether it holds are None.
    """
    found = []
    for name, which, figure, limit in GOALS:
        worst = max((_figure(row, figure) for row in rows if which(row)), default=None)
        found.append((name, worst, limit, None if worst is None else worst <= limit))
    return found


def _figure(row, name):
    if name == "prediction_off":
        ratio = row["clocks_per_pixel"] / row["predicted_clocks_per_pixel"]
        return max(ratio, 1 / ratio)
    if name == "misses_off":
        return abs(row["misses"] - row["misses_expected"])
    return row[name]


def table_four(rows):
    """Table IV of the paper remade: (method, memory, resolution, output, frames per second), with
    the paper's interpolation."""
    table = [(method, memory, "{}x{}".format(*size), "memory", fps)
             for method, memory, size, fps in PAPER]
    for row in rows:
        if (row["rotation"] == 0 and row["memory"] in ("sdram", "ddr3")
                and row["interpolation"] == "fast"):
            table.append((row["fetch"], row["memory"], f"{row['width']}x{row['height']}",
                          row["output"], row["frames_per_second"]))
    return table
