"""The corrector with all that one core can have: network at nodes, lists of views, colours, gains
of raw samples, early start."""

from dataclasses import replace
from functools import cache

import numpy as np

from cameras import barrel_descriptor
from ncdc_bench.mutation.designs import Bench, Design
from ncdc_hdl.corrector import Corrector
from ncdc_model.golden.tone import tone_named
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.colour import Colour
from ncdc_spec.frames import BGR8
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.registers.register_map import FAULT_ALIGNMENT, FAULT_FORMAT, FAULT_SIZE, FAULT_TARGET
from ncdc_spec.view_list import placed
from simulations.lens_change import simulate_lens_change
from simulations.register_fuzz import simulate_register_fuzz
from simulations.resets import simulate_resets
from simulations.view_passes import (
    random_entries,
    simulate_follow,
    simulate_passes,
    simulate_wrong_lists,
)
from views import random_view

__all__ = ["DESIGN"]

FOCAL = 25          # pixels of the trained pictures
_BETWEEN = 32       # clocks between two frames, in which the view of the second is read
HARDWARE = Hardware(cache=CacheOptions(64, pending=32, outstanding=8, interpolation=GRADIENT),
                    colour=True, raw_balance=True, view=True, views=3)
COLOUR = Colour((461, 200, 358), tone_named("sRGB"), raw_gains=(300, 256, 411))


@cache
def cameras():
    """Two cameras that differ in all that a host can set, each with a raw frame of noise."""
    wide = barrel_descriptor((40, 20), (44, 22), 2, bayer="GBRG", strength=.4,
                             fill=(200, 100, 50), interpolation=GRADIENT)
    tele = barrel_descriptor((36, 16), (42, 20), 2, seed=8, bayer="RGGB", strength=.1,
                             interpolation=GRADIENT)
    rng = np.random.default_rng(4)
    return [(replace(d, nodes=8), rng.integers(0, 256, d.geometry.distorted[::-1], np.uint8))
            for d in (wide, tele)]


def make():
    """The corrector, anew."""
    return Corrector(cameras()[0][0], HARDWARE)


@cache
def corrector():
    """The corrector, made once, for its registers."""
    return make()


def frame(verilog, more):
    """One frame with a view, gains and a tone curve: pixels, counters, sums of the colours."""
    descriptor, raw = cameras()[0]
    view = random_view(np.random.default_rng(1), descriptor.geometry, FOCAL, (40, 20), zoom=(.8, 1))
    result = simulate_correction(descriptor, raw, HARDWARE, verilog=verilog, view=view,
                                 colour=COLOUR, memory="hostile", clock_limit=30_000, more=more)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == result.golden.shape[0] * result.golden.shape[1]
    assert result.counters["CLOCKS"] <= result.clocks_outside <= result.counters["CLOCKS"] + 64
    assert result.sums == result.sums_expected


def lens_change(verilog, more):
    """Another lens and view with every frame, and a host that writes what it must not."""
    rng = np.random.default_rng(3)
    views = [random_view(rng, cameras()[k % 2][0].geometry, FOCAL, (40, 20 - k), pan=50, roll=180,
                         zoom=(.5, 4)) for k in range(4)]
    result = simulate_lens_change(corrector(), verilog, cameras(), len(views), views=views,
                                  memory="hostile", intruder=True, clock_limit=60_000, more=more)
    assert result.differing == (0,) * len(views)
    assert max(result.idle) <= _BETWEEN


def lists(verilog, more):
    """Another lens and list of views with every pass."""
    rng, passes = np.random.default_rng(5), 4
    made = [random_entries(rng, cameras()[k % 2][0].geometry, FOCAL, HARDWARE,
                           int(rng.integers(1, HARDWARE.views + 1))) for k in range(passes)]
    result = simulate_passes(corrector(), verilog, cameras(), made, memory="sdram",
                             clock_limit=100_000, more=more)
    assert result.differing == (0,) * passes and result.outside == 0
    assert result.pixels == tuple(sum(entry.view.size[0] * entry.view.size[1] for entry in entries)
                                  for entries in made)


def wrong_lists(verilog, more):
    """Lists that hold what they must not."""
    camera = cameras()[0]
    word = HARDWARE.data_width // 8
    views = [random_view(np.random.default_rng(k), camera[0].geometry, FOCAL, size)
             for k, size in enumerate(((16, 8), (8, 12), (24, 9)))]
    entries = placed(views, [(0, 0), (16, 0), (0, 12)], (24, 21), BGR8)
    every = 0, 1, 2
    cases = [
        ({"VIEWS": 0}, (), FAULT_SIZE), ({"VIEWS": 4}, (), FAULT_SIZE), ({"VIEWS": 1}, (0,), 0),
        ({"VIEW1_WIDTH": 7}, (0, 2), FAULT_SIZE), ({"VIEW0_HEIGHT": 4097}, (1, 2), FAULT_SIZE),
        ({"VIEW2_STRIP": 33}, (0, 1), FAULT_SIZE),
        ({"VIEW1_PITCH": entries[1].row_bytes - word}, (0, 2), FAULT_SIZE),
        ({"VIEW1_PITCH": 73}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_OFFSET": 50}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_FORMAT": 3}, (0, 2), FAULT_FORMAT),
        ({"VIEW1_OFFSET": 1 << 20}, (0, 2), FAULT_TARGET),
        ({"VIEW1_OFFSET": (1 << 32) - 64}, (0, 2), FAULT_TARGET), ({}, every, 0)]
    differing, outside = simulate_wrong_lists(corrector(), verilog, camera, entries, cases,
                                              clock_limit=200_000, more=more)
    assert differing == (0,) * len(cases) and outside == 0


def early_start(verilog, more):
    """Views of a frame that the camera still writes."""
    camera = cameras()[0]
    rng, line = np.random.default_rng(9), 400
    views = [random_view(rng, camera[0].geometry, FOCAL, (40, 20)) for _ in range(2)]
    entries = placed(views, [(0, 20 * k) for k in range(2)], (40, 40))
    differing, early, clocks = simulate_follow(corrector(), verilog, camera, entries, line,
                                               memory="ideal", clock_limit=60_000, more=more)
    assert (differing, early) == (0, 0)
    assert clocks < 1.5 * line * camera[0].geometry.distorted_height


def resets(forgets):
    """The bench of frames that resets cut short; the memory ``forgets`` its reads or answers."""
    def run(verilog, more):
        raws = [np.random.default_rng(k).integers(0, 256, cameras()[0][1].shape, np.uint8)
                for k in range(2)]
        result = simulate_resets(corrector(), verilog, raws, 8, forgets=forgets, longest=1500,
                                 memory="hostile", clock_limit=200_000, more=more)
        assert result.differing == (0,) * 8
    return run


def fuzz(verilog, more):
    """Frames of random register values, and of right ones, in turn."""
    result = simulate_register_fuzz(corrector(), verilog, cameras()[0][1], 10, memory="fixed:9:4",
                                    clock_limit=150_000, more=more)
    assert result.differing == (0,) * 10 and result.outside == 0


_RUNS = {"frame": frame, "lens change": lens_change, "lists": lists, "wrong lists": wrong_lists,
         "early start": early_start, "resets, memory forgets": resets(True),
         "resets, memory answers": resets(False), "register fuzz": fuzz}

DESIGN = Design("core", "ncdc", make, tuple(Bench(*item) for item in _RUNS.items()))
