"""Rows of ``ncdc bench cost``: planned clocks and traffic, and sizes by Yosys."""

from functools import cache

from ncdc.planned_timing import planned_timing
from ncdc_bench.cost.lenses import trained_at
from ncdc_bench.synth.measure import cyclone
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import module_verilog
from ncdc_model.planner.plan import plan
from ncdc_model.planner.scaled import hardware_takes, scaled
from ncdc_spec.hardware import Hardware

__all__ = ["CLOCK_MHZ", "DEGREES", "MEMORY", "QUICK_SIZES", "SIZES", "measure"]

SIZES = (640, 480), (1280, 720), (1920, 1080), (3840, 2160), (7680, 4320)
QUICK_SIZES = SIZES[:1]
DEGREES = 90, 120, 150, 180
MEMORY, CLOCK_MHZ = "ddr3", 100.0
_SYNTHESISED = 120, ((640, 480), (1920, 1080), (3840, 2160))    # lens and sizes of hardware
_WIDE = 1920, 1080              # size that lenses of pictures of 16:9 are trained at


def measure(sizes=SIZES, degrees=DEGREES, synth=True, progress=lambda name: None):
    """A row for each of ``sizes`` and ``degrees``; rows come one by one.

    Parameters
    ----------
    sizes : sequence of (int, int)
    degrees : sequence of int
        Of the lens, across.
    synth : bool
        Whether the planned hardware of one lens is synthesised, for three of the sizes.
    progress : callable
        Called with the name of each row before it; returns a callback with the fraction done.

    Yields
    ------
    dict
        ``width``, ``height``, ``lens`` (degrees), ``hardware_exists``, ``nodes``, the figures of
        :meth:`ncdc_model.planner.plan.Plan.report`; ``alm``, ``m10k`` and ``dsp``, None where
        nothing is synthesised.
    """
    for lens in degrees:
        for size in sizes:
            yield _row(lens, size, synth and lens == _SYNTHESISED[0] and size in _SYNTHESISED[1],
                       progress(f"{size[0]}x{size[1]}, {lens} degrees"))


def _row(degrees, size, synth, show):
    base = size if size[0] * _WIDE[1] != size[1] * _WIDE[0] else _WIDE
    trained = _trained(degrees, base)
    descriptor = trained if size == base else scaled(trained, size)
    planned = plan(descriptor, Hardware(data_width=128, output="stream"), MEMORY,
                   lambda chosen: planned_timing(trained, descriptor, chosen), clock_mhz=CLOCK_MHZ,
                   progress=show or (lambda fraction: None))
    area = dict.fromkeys(("alm", "m10k", "dsp"))
    if synth:
        verilog = module_verilog(Corrector(descriptor, planned.hardware), "block")
        figures = cyclone("cyclonev", verilog, lambda step: None)
        area = {name: figures[name] for name in area}
    return {"width": size[0], "height": size[1], "lens": degrees,
            "hardware_exists": hardware_takes(descriptor.geometry), "nodes": descriptor.nodes,
            **planned.report(), **area}


@cache
def _trained(degrees, size):
    return trained_at(degrees, size)
