"""Lists of views in the Verilog: several views of one raw frame, another list with every pass."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_hdl.system import System
from ncdc_model.correction import correct
from ncdc_model.golden.view_list import compose
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.running import running
from ncdc_sim.system.view_list import simulate_view_list
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGR8
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    FAULT_ALIGNMENT,
    FAULT_FORMAT,
    FAULT_SIZE,
    FAULT_TARGET,
)
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from ncdc_spec.view_list import Entry, list_values, placed, quad
from simulations.register_fuzz import simulate_register_fuzz
from simulations.view_passes import (
    random_entries,
    simulate_follow,
    simulate_passes,
    simulate_wrong_lists,
)
from views import random_view

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
@pytest.mark.parametrize("settings,passes", [
    (dict(views=3), 8),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (dict(views=8, data_width=128, lanes=4), 60),
        (dict(views=4, data_width=64, lanes=2, share=2), 60)))])
def test_another_lens_and_list_with_every_pass(settings, passes):
    pair, (corrector, verilog) = cameras(), built(**settings)
    lists = random_lists(corrector, pair, passes)
    result = simulate_passes(corrector, verilog, pair, lists, memory="hostile")
    assert result.differing == (0,) * passes and result.outside == 0
    assert result.pixels == tuple(sum(entry.view.size[0] * entry.view.size[1] for entry in entries)
                                  for entries in lists)


@pytest.mark.longer
def test_views_in_one_picture():
    """A detail covers a part of an overview; the rest of the picture is not touched."""
    descriptor, raw = cameras()[0]
    rng, form = np.random.default_rng(6), BGR8
    views = [random_view(rng, descriptor.geometry, FOCAL, size) for size in ((40, 20), (12, 9))]
    entries = placed(views, [(4, 2), (28, 4)], (48, 25), form)
    hardware = Hardware(view=True, views=3)
    result = simulate_view_list(descriptor, raw, hardware, entries, (48, 25), memory="ideal")
    assert result.differing == [] and result.bytes_outside == 0
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == 40 * 20 + 12 * 9
    assert result.blank.sum() == 48 * 25 - 40 * 20
    overview = correct(descriptor, raw, view=views[0]).picture
    detail = correct(descriptor, raw, view=views[1]).picture
    overview[2:11, 24:36] = detail
    assert (result.picture[2:22, 4:44] == overview).all() and not result.picture[23:].any()
    with pytest.raises(InputError, match="view 0 has 64x20 pixels, the hardware makes up to 63x32"):
        simulate_view_list(descriptor, raw, hardware, placed(
            [random_view(rng, descriptor.geometry, FOCAL, (64, 20))], [(0, 0)], (64, 20)), (64, 20))


@pytest.mark.longer
def test_two_cameras_side_by_side():
    """Two starts, each with its own lens and raw frame, make the halves of one picture."""
    pair, (corrector, verilog) = cameras(), built(views=3)
    rng = np.random.default_rng(7)
    halves = [(Entry(random_view(rng, d.geometry, FOCAL, (24, 16)), 96 * k, 192),)
              for k, (d, _) in enumerate(pair)]
    result = simulate_passes(corrector, verilog, pair, halves, together=True)
    assert result.differing[-1] == 0 and result.outside == 0 and result.pixels == (384, 384)


@pytest.mark.longer
def test_no_view_waits_for_the_next_frame_of_the_camera():
    """With early start the rows of the raw frame, once counted, are there for all views."""
    (descriptor, raw), (corrector, verilog) = cameras()[0], built(views=3)
    rng, line = np.random.default_rng(9), 1000
    views = [random_view(rng, descriptor.geometry, FOCAL, (40, 20)) for _ in range(3)]
    entries = placed(views, [(0, 20 * k) for k in range(3)], (40, 60))
    differing, early, clocks = simulate_follow(corrector, verilog, (descriptor, raw), entries,
                                               line, memory="ideal")
    assert (differing, early) == (0, 0)
    assert clocks < 1.5 * line * descriptor.geometry.distorted_height


@pytest.mark.longer
def test_what_a_list_must_not_hold_is_rejected_view_by_view():
    """The other views of the pass are made, nothing is written outside, and FAULT has the reason.
    """
    camera, (corrector, verilog) = cameras()[0], built(views=3)
    geometry, word = camera[0].geometry, corrector.hardware.data_width // 8
    views = [random_view(np.random.default_rng(k), geometry, FOCAL, size)
             for k, size in enumerate(((16, 8), (8, 12), (24, 9)))]
    entries = placed(views, [(0, 0), (16, 0), (0, 12)], (24, 21), BGR8)
    row, every = entries[1].row_bytes, (0, 1, 2)
    cases = [
        ({}, every, 0), ({"VIEWS": 0}, (), FAULT_SIZE), ({"VIEWS": 4}, (), FAULT_SIZE),
        ({"VIEWS": 1}, (0,), 0), ({"VIEW1_WIDTH": 7}, (0, 2), FAULT_SIZE),
        ({"VIEW0_HEIGHT": 4097}, (1, 2), FAULT_SIZE), ({"VIEW2_STRIP": 33}, (0, 1), FAULT_SIZE),
        ({"VIEW1_PITCH": row - word}, (0, 2), FAULT_SIZE),
        ({"VIEW1_PITCH": 73}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_OFFSET": 50}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_FORMAT": 3}, (0, 2), FAULT_FORMAT),
        ({"VIEW1_OFFSET": 1 << 20}, (0, 2), FAULT_TARGET),
        # Offsets that count modulo 2**32: before the buffer, and so far that it begins anew.
        ({"VIEW1_OFFSET": (1 << 32) - 64}, (0, 2), FAULT_TARGET),
        ({"VIEW1_OFFSET": (1 << 32) - 4096}, (0, 2), FAULT_TARGET),
        ({"VIEW2_FORMAT": 0}, (0, 1), FAULT_SIZE), ({}, every, 0)]
    differing, outside = simulate_wrong_lists(corrector, verilog, camera, entries, cases)
    assert differing == (0,) * len(cases) and outside == 0


@pytest.mark.longer
@pytest.mark.parametrize("passes,seed", [
    (60, 1), *(pytest.param(200, seed, marks=pytest.mark.regress) for seed in range(2, 27))])
def test_nonsense_lists_write_nothing_outside_and_never_hang(passes, seed):
    """Every second pass has up to four registers of any value: numbers of views, sizes, offsets,
    pitches. Half of these are aborted. The pass after it is right."""
    (_, raw), (corrector, verilog) = cameras()[0], built(views=3)
    result = simulate_register_fuzz(corrector, verilog, raw, passes, seed=seed,
                                    memory="fixed:9:4", clock_limit=200_000 * passes)
    assert result.differing == (0,) * passes and result.outside == 0
    faults = np.array(result.faults)
    for bit in (FAULT_TARGET, FAULT_ALIGNMENT, FAULT_SIZE):
        assert (faults & bit != 0).sum() > 3


SIZE = 64, 24       # pixels of the sensor's frames and of the quad


@pytest.mark.longer
def test_a_running_camera_makes_quads_of_one_raw_frame_each():
    """Another list comes while frames run: each picture is of one list and one raw frame."""
    descriptor = replace(barrel_descriptor(SIZE, SIZE, 2, strength=.4), nodes=8)
    system = System(descriptor, Hardware(data_width=64, view=True, views=4))
    rng, sensor = np.random.default_rng(5), sensor_named("mt9p031")
    views = [random_view(rng, descriptor.geometry, 40, (32, 12)) for _ in range(8)]
    lists = [quad(views[:4]), quad(views[4:])]
    values = [list_values(entries, system.corrector.hardware, descriptor.geometry)
              | {"CTRL": CTRL_COMMIT} for entries in lists]
    light = Light(rng.integers(0, 4096, (6, *SIZE[::-1]), dtype=np.uint16))
    asked = setup(sensor, Settings(*SIZE, exposure_us=100, clock_hz=sensor.pixel_clock_hz))
    seen = []
    with running(system, asked, light, registers=values[0] | {"RUN_FOLLOW": 1}) as camera:
        host = camera.host
        host.camera.listen("CORRECTED_FRAME", "CORRECTED_BAD")
        for k in range(4):
            assert host.live.wait_irq(20 * camera.frame_clocks + 1_000_000)
            assert "CORRECTED_FRAME" in host.camera.events()
            frame = host.claim()
            picture = np.frombuffer(frame.data, np.uint8)
            made = [compose(descriptor, camera.sent(frame.number), entries) for entries in lists]
            [which] = [n for n, one in enumerate(made) if (picture[:one.size] == one).all()]
            seen.append((frame.number, which))
            host.camera.release(0)
            if k == 1:
                host.camera.put(**values[1])
        assert host.get("VIEWS_STATE") & 0xF == 4
        assert [host.get(name) for name in ("RAW_ENDED_BAD", "CORRECTED_ENDED_BAD")] == [0, 0]
    numbers, which = zip(*seen)
    assert sorted(set(numbers)) == list(numbers) and which[:2] == (0, 0) and which[-1] == 1
