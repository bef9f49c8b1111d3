"""Lists of views in the Verilog: several views of one raw frame, another list with every pass."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_spec.hardware import Hardware
from simulations.view_passes import random_entries, simulate_passes

FOCAL = 25      # pixels of the trained pictures


def cameras():
    """Two small cameras, each with a raw frame of noise."""
    wide = barrel_descriptor((40, 20), (42, 22), 2, bayer="GBRG", fill=(200, 100, 50))
    tele = barrel_descriptor((36, 16), (40, 20), 2, seed=8, strength=.1)
    rng = np.random.default_rng(4)
    return [(replace(d, nodes=8), rng.integers(0, 256, d.geometry.distorted[::-1], np.uint8))
            for d in (wide, tele)]


@cache
def built(**settings):
    corrector = Corrector(cameras()[0][0], Hardware(view=True, **settings))
    return corrector, verilog_of(corrector)


def random_lists(corrector, pair, passes, seed=3):
    """A list of random views for each pass."""
    rng, most = np.random.default_rng(seed), corrector.hardware.views
    return [random_entries(rng, pair[k % 2][0].geometry, FOCAL, corrector.hardware,
                           int(rng.integers(1, most + 1))) for k in range(passes)]


@pytest.mark.longer
@pytest.mark.parametrize("settings,passes", [(dict(views=3), 8)])
def test_another_lens_and_list_with_every_pass(settings, passes):
    pair, (corrector, verilog) = cameras(), built(**settings)
    lists = random_lists(corrector, pair, passes)
    result = simulate_passes(corrector, verilog, pair, lists, memory="hostile")
    assert result.differing == (0,) * passes and result.outside == 0
    assert result.pixels == tuple(sum(entry.view.size[0] * entry.view.size[1] for entry in entries)
                                  for entries in lists)
