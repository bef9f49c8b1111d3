"""Clocks of a view's frame: as the planner predicts them, and on the generated Verilog."""

import numpy as np

from ncdc_bench.view.measure import random_angles
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.plan import CLOCK_MHZ, plan
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.frames import FrameAddresses
from ncdc_spec.hardware import Hardware
from ncdc_spec.view_matrix import PlaneCamera

__all__ = ["clocks_of"]

_MEMORY = "ddr3"
_HARDWARE = Hardware(data_width=128, output="stream", view=True)


def clocks_of(descriptor, views):
    """Figures of the slowest of ``views`` random views, on the generated Verilog.

    The cache is the one that the planner chooses for the trained picture.

    Returns
    -------
    dict
        ``clocks_per_pixel``, ``predicted_clocks_per_pixel``, ``pixels_different`` from the golden
        model; ``slowest``: pan, tilt, roll and zoom of that view.
    """
    chosen = plan(descriptor, _HARDWARE, _MEMORY,
                  lambda hardware: Corrector(descriptor, hardware).timing).hardware
    timing = Corrector(descriptor, chosen).timing
    trained, found = PlaneCamera.of(descriptor), []
    for angles in random_angles(views):
        found.append((_predicted(descriptor, chosen, timing, trained.looking(angles)), angles))
    predicted, slowest = max(found, key=lambda pair: pair[0])
    raw = np.random.default_rng(1).integers(0, 256, descriptor.geometry.distorted[::-1], np.uint8)
    report = simulate_correction(descriptor, raw, chosen, view=trained.looking(slowest),
                                 memory=_MEMORY).report()
    return {"clocks_per_pixel": report["clocks_per_pixel"],
            "predicted_clocks_per_pixel": predicted,
            "pixels_different": report["pixels_different"], "slowest": vars(slowest)}


def _predicted(descriptor, hardware, timing, view):
    """Clocks per pixel of a view's frame, by the planner's model of cache and memory."""
    boxes = lookups(frame_windows(descriptor, view=view), hardware.strip, hardware.lanes)
    missed = misses(accesses(boxes), hardware.cache, hardware.split)
    addresses = FrameAddresses.after_reset(view.geometry(descriptor.geometry),
                                           hardware.data_width)
    clocks = predict_clocks(missed, boxes, hardware, memory_at(_MEMORY, CLOCK_MHZ), timing,
                            addresses)
    return clocks.clocks / boxes.pixels
