"""Every pair of values of two hardware options in one of few builds, on a small frame."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from coverage import FOLDER, percentages, reached
from ncdc_model.planner.follow import camera_line
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.hardware import Hardware
from pairs import covering, pairs_of

OPTIONS = {
    "data_width": (32, 64, 128), "output": ("memory", "stream"), "fetcher": ("cache", "multiport"),
    "lanes": (1, 2, 4), "hidden": ("multiply", "raster"), "share": (1, 2, 3),
    "multiplier_bits": (27, 18), "strip": (0, 32), "tiles": (16, 64),
    "variant": ("mmhbc", "classic", "table"), "memory": ("hostile", "sdram"),
    "follow": (False, True)}


def allowed(case):
    """Whether there is such a hardware, and the case is not another one's in disguise."""
    return not (case["strip"] and case["output"] == "stream"
                or case["fetcher"] == "multiport" and (case["lanes"] > 1 or case["tiles"] != 64))


@cache
def cases():
    return covering(OPTIONS, allowed)


def test_the_cases_hold_every_pair():
    found, wanted = cases()
    assert set().union(*map(pairs_of, found)) == wanted and all(map(allowed, found))
    assert len(found) < 25
    values = {(name, value) for name, options in OPTIONS.items() for value in options}
    assert {one for pair in wanted for one in pair} == values
    assert len(wanted) > 300


def descriptor(variant):
    d = barrel_descriptor((44, 21), (50, 27), hidden_neurons=3, bayer="GRBG", strength=0.4)
    return replace(d, variant=variant)


@pytest.mark.regress
@pytest.mark.parametrize("number", range(len(cases()[0])), ids=lambda k: "-".join(
    str(value) for value in cases()[0][k].values()))
def test_no_wrong_pixel(number, monkeypatch):
    name = "-".join(map(str, cases()[0][number].values()))
    file = FOLDER / f"{name}.dat"
    file.parent.mkdir(parents=True, exist_ok=True)
    monkeypatch.setenv("NCDC_COVERAGE", str(file))
    case = dict(cases()[0][number])
    d = descriptor(case.pop("variant"))
    follow, memory, tiles = (case.pop(name) for name in ("follow", "memory", "tiles"))
    hardware = Hardware(cache=CacheOptions(tiles, pending=32, outstanding=4), **case)
    raw = np.random.default_rng(number).integers(0, 256, d.geometry.distorted[::-1], np.uint8)
    line = camera_line(None, d.geometry) if follow else None
    result = simulate_correction(d, raw, hardware, memory=memory, follow_line=line, seed=number + 1)
    assert result.differing == [] and result.counters["PIXELS"] == 44 * 21
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.blank.any() and not result.blank.all()
    # A frame of 44x21 pixels reaches most of the Verilog's lines.
    share = percentages(reached(file.read_text(errors="replace")))
    assert share["line"] > 90 and share["toggle"] > 60, share
