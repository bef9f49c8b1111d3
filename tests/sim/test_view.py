"""Views in the Verilog: whole frames, another lens and another view with every frame."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.planner.follow import follow_bound
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.hardware import Hardware
from ncdc_spec.view_matrix import Angles, PlaneCamera
from simulations.lens_change import simulate_lens_change
from views import nonsense_table, nonsense_view, random_view, turning_view

FOCAL = 60      # pixels of the trained pictures


def cameras(nodes=8):
    """Two cameras of different sizes, each with a raw frame of noise."""
    wide = barrel_descriptor((104, 60), (112, 66), 4, bayer="GBRG", strength=.4,
                             fill=(200, 100, 50))
    tele = barrel_descriptor((96, 52), (90, 60), 4, seed=8, strength=.1)
    rng = np.random.default_rng(4)
    return [(replace(d, nodes=nodes), rng.integers(0, 256, d.geometry.distorted[::-1], np.uint8))
            for d in (wide, tele)]


def views_of(pair, frames, seed=3):
    """A view of each frame: every fourth one nonsense, sizes in turn."""
    rng, sizes = np.random.default_rng(seed), ((104, 60), (64, 40), (96, 17))
    return [nonsense_view(rng, sizes[k % 3]) if k % 4 == 3 else
            random_view(rng, pair[k % 2][0].geometry, FOCAL, sizes[k % 3], pan=50, roll=180,
                        zoom=(.5, 4)) for k in range(frames)]


@pytest.mark.longer
@pytest.mark.many_clocks
@pytest.mark.parametrize("settings,nodes,frames", [
    (dict(strip=32), 8, 12),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (dict(data_width=128, output="stream", lanes=4), 16, 60),
        (dict(data_width=64, lanes=2, share=3, multiplier_bits=18), 8, 60)))])
def test_another_lens_and_view_with_every_frame(settings, nodes, frames):
    pair = cameras(nodes)
    corrector = Corrector(pair[0][0], Hardware(view=True, **settings))
    result = simulate_lens_change(corrector, verilog_of(corrector), pair, frames,
                                  views=views_of(pair, frames), memory="hostile")
    assert result.differing == (0,) * frames


@pytest.mark.regress
def test_a_view_of_another_size():
    d, raw = cameras()[0]
    view = random_view(np.random.default_rng(1), d.geometry, FOCAL, (72, 44))
    result = simulate_correction(d, raw, Hardware(view=True), view=view)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.counters["FETCHES"] == result.fetches_expected
    assert not result.blank.all()


@pytest.mark.longer
@pytest.mark.many_clocks
@pytest.mark.parametrize("settings,frames", [
    (dict(output="stream"), 8),
    pytest.param(dict(data_width=64, lanes=4, strip=32), 60, marks=pytest.mark.regress)])
def test_another_table_with_every_frame(settings, frames):
    """Lenses in turn; every fourth table is nonsense, and some views have none."""
    pair = cameras()
    rng, sizes = np.random.default_rng(3), ((104, 60), (64, 40), (96, 20))
    views = [turning_view(rng, pair[k % 2][0].geometry, FOCAL, sizes[k % 3], 9, roll=180)
             for k in range(frames)]
    views = [replace(view, rows=(nonsense_table(rng, 9), view.rows, None, view.rows)[k % 4])
             for k, view in enumerate(views)]
    corrector = Corrector(pair[0][0], Hardware(view=True, view_rows=9, **settings))
    result = simulate_lens_change(corrector, verilog_of(corrector), pair, frames, views=views,
                                  memory="hostile")
    assert result.differing == (0,) * frames


@pytest.mark.regress
@pytest.mark.parametrize("roll", [4, 175])
def test_a_view_that_follows_its_camera(roll):
    d, raw = cameras()[0]
    d = replace(d, provenance={"frame": [FOCAL, 50.0, 30.0]})
    view = PlaneCamera.of(d).looking(Angles(pan=8, roll=roll, zoom=1.3), (72, 44))
    hardware = Hardware(view=True).made_for(d)
    result = simulate_correction(d, raw, hardware, view=view,
                                 follow_line=d.geometry.distorted_width)
    assert result.differing == [] and result.follow["follow_early_reads"] == 0
    bound = follow_bound(d, hardware, memory_timing("sdram"), Corrector(d, hardware).timing,
                         view=view)
    latency = result.follow["follow_latency_clocks"]
    assert bound.clocks - .1 * result.counters["CLOCKS"] < latency <= bound.clocks


@cache
def small():
    """A small camera with its raw frame, the corrector and its Verilog."""
    d = replace(barrel_descriptor((40, 8), (40, 10), 2, fill=(200, 100, 50)), nodes=8)
    corrector = Corrector(d, Hardware(view=True, output="stream"))
    raw = np.random.default_rng(1).integers(0, 256, (10, 40), np.uint8)
    return (d, raw), corrector, verilog_of(corrector)


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("seed", range(10))
def test_a_thousand_frames_of_nonsense(seed):
    """Each second frame has a nonsense matrix. All end, and all are right."""
    camera, corrector, verilog = small()
    rng, size, frames = np.random.default_rng(seed), (16, 8), 1000
    views = [nonsense_view(rng, size) if k % 2 else
             random_view(rng, camera[0].geometry, 25, size) for k in range(frames)]
    result = simulate_lens_change(corrector, verilog, [camera], frames, views=views,
                                  memory="ideal", clock_limit=20_000 * frames)
    assert set(result.differing) == {0}
