"""Clocks of the slowest view of a range: planned, and on the generated Verilog."""

import numpy as np

from ncdc_bench.view.measure import RANGE, random_angles
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.views import ViewPlanner
from ncdc_model.view_range import ViewRange
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.hardware import Hardware

__all__ = ["clocks_of"]

_MEMORY = "ddr3"
_HARDWARE = Hardware(data_width=128, output="stream", view=True)


def clocks_of(descriptor, views, progress=lambda fraction: None):
    """Figures of the slowest view of :data:`~ncdc_bench.view.measure.RANGE`.

    The cache is the one that the planner chooses for the range.

    Parameters
    ----------
    descriptor : Descriptor
    views : int
        Random views of the range, whose predicted clocks are compared with the bound.
    progress : callable
        Called with the fraction of the planning done.

    Returns
    -------
    dict
        ``clocks_per_pixel``, on the generated Verilog, ``predicted_clocks_per_pixel``,
        ``pixels_different`` from the golden model; ``slowest``: pan, tilt, roll and zoom of that
        view; ``bound_clocks_per_pixel``, ``random_clocks_per_pixel``: the planner's bound, and the
        prediction for the slowest of the random views; ``cache_bytes``.
    """
    stated = ViewRange.of(descriptor, RANGE)
    planner = ViewPlanner(descriptor, _MEMORY,
                          lambda hardware: Corrector(descriptor, hardware).timing, stated)
    planned = planner.plan(_HARDWARE, progress=progress)
    report, hardware = planned.report(), planned.hardware
    random = max(planner.plan_of(angles, hardware).clocks_per_pixel
                 for angles in random_angles(views))
    raw = np.random.default_rng(1).integers(0, 256, descriptor.geometry.distorted[::-1], np.uint8)
    simulated = simulate_correction(descriptor, raw, hardware, memory=_MEMORY,
                                    view=stated.view(planned.slowest_at)).report()
    return {"clocks_per_pixel": simulated["clocks_per_pixel"],
            "pixels_different": simulated["pixels_different"],
            "slowest": report["slowest_view"], "random_clocks_per_pixel": random,
            **{name: report[name] for name in ("predicted_clocks_per_pixel",
                                               "bound_clocks_per_pixel", "cache_bytes")}}
