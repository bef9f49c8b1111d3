"""The corrector with all that one core can have: network at nodes, lists of views, colours, gains
of raw samples, early start."""

from dataclasses import replace
from functools import cache

import numpy as np

from cameras import barrel_descriptor
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.corrector import Corrector
from ncdc_model.golden.tone import tone_named
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.colour import Colour
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.frames import BGR8, BGRX8
from ncdc_spec.geometry import MONO, Geometry, ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.registers.register_map import FAULT_ALIGNMENT, FAULT_FORMAT, FAULT_SIZE, FAULT_TARGET
from ncdc_spec.view import View
from ncdc_spec.view_list import Entry, placed
from simulations.lens_change import simulate_lens_change
from simulations.read_back import simulate_read_back
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
_DECODED = 24       # bits of an address, of a memory in which buffers lie far apart
_LARGEST = 4096, 2048       # of the hardware; few frames are nearly as large, in one direction


@cache
def cameras():
    """Two cameras that differ in all that a host can set, each with a raw frame of noise."""
    return [_camera(seed, (size, raw), 2, seed=seed, bayer=bayer, strength=strength, fill=fill)
            for seed, size, raw, bayer, strength, fill in (
                (1, (40, 20), (44, 22), "GBRG", .4, (200, 100, 50)),
                (8, (36, 16), (42, 20), "RGGB", .1, (0, 0, 0)))]


@cache
def large_cameras():
    """A camera of wide raw frames and one of tall ones, of the same network turned by 90 degrees.
    """
    wide, raw = _camera(5, ((2730, 16), (2726, 24)), 2, seed=36, bayer="BGGR", strength=.1,
                        fill=(85, 170, 85))
    network = wide.network
    turned = Geometry(40, 1365, 44, 1369, "GRBG", interpolation=GRADIENT)
    scale = turned.distorted_height / wide.geometry.distorted_width
    tall = Descriptor.quantise(
        FloatNetwork(network.hidden_weights[:, ::-1], network.hidden_biases,
                     scale * network.output_weights[::-1], scale * network.output_biases[::-1]),
        turned, ValidRows.everything(*turned.corrected))
    return [(wide, raw), (replace(tall, nodes=8), _noise(6, turned))]


def _camera(noise, sizes, neurons, **options):
    """A descriptor with the network at nodes, and a raw frame of noise."""
    made = replace(barrel_descriptor(*sizes, neurons, interpolation=GRADIENT, **options), nodes=8)
    return made, _noise(noise, made.geometry)


def _noise(seed, geometry):
    """A raw frame of noise."""
    return np.random.default_rng(seed).integers(0, 256, geometry.distorted[::-1], np.uint8)


@cache
def largest():
    """The descriptor of the hardware: the first camera's network, and room for large frames."""
    small = cameras()[0][0]
    width, height = _LARGEST
    return replace(small, valid=ValidRows.everything(width, height), geometry=replace(
        small.geometry, corrected_width=width, corrected_height=height))


def make():
    """The corrector, anew."""
    return Corrector(largest(), HARDWARE)


@cache
def corrector():
    """The corrector, made once, for its registers."""
    return make()


def frame(verilog, transcripts):
    """One frame with a view, gains and a tone curve: pixels, counters, sums of the colours."""
    descriptor, raw = cameras()[0]
    view = random_view(np.random.default_rng(1), descriptor.geometry, FOCAL, (40, 20), zoom=(.8, 1))
    result = simulate_correction(descriptor, raw, HARDWARE, verilog=verilog, view=view,
                                 colour=COLOUR, memory="hostile", clock_limit=30_000,
                                 transcripts=transcripts)
    assert result.differing == [] and result.bytes_outside == 0
    assert result.counters["FETCHES"] == result.fetches_expected
    assert result.counters["PIXELS"] == result.golden.shape[0] * result.golden.shape[1]
    assert result.counters["CLOCKS"] <= result.clocks_outside <= result.counters["CLOCKS"] + 64
    assert result.sums == result.sums_expected


def grey(verilog, transcripts):
    """One frame of a grey sensor."""
    descriptor, raw = _camera(7, ((40, 20), (44, 22)), 2, seed=1, bayer=MONO, strength=.4,
                              fill=(200, 100, 50))
    result = simulate_correction(descriptor, raw, HARDWARE, verilog=verilog, memory="hostile",
                                 clock_limit=30_000, transcripts=transcripts)
    assert result.differing == [] and result.bytes_outside == 0


def lens_change(verilog, transcripts):
    """Another lens and view with every frame, and a host that writes what it must not."""
    rng = np.random.default_rng(3)
    views = [random_view(rng, cameras()[k % 2][0].geometry, FOCAL, (40, 20 - k), pan=50, roll=180,
                         zoom=(.5, 4)) for k in range(4)]
    result = simulate_lens_change(corrector(), verilog, cameras(), len(views), views=views,
                                  memory="hostile", intruder=True, clock_limit=60_000,
                                  transcripts=transcripts)
    assert result.differing == (0,) * len(views)
    assert max(result.idle) <= _BETWEEN


def lists(verilog, transcripts):
    """Another lens and list of views with every pass."""
    rng, passes = np.random.default_rng(5), 4
    made = [random_entries(rng, cameras()[k % 2][0].geometry, FOCAL, HARDWARE,
                           int(rng.integers(1, HARDWARE.views + 1))) for k in range(passes)]
    result = simulate_passes(corrector(), verilog, cameras(), made, memory="sdram",
                             clock_limit=100_000, transcripts=transcripts)
    assert result.differing == (0,) * passes and result.outside == 0
    assert result.pixels == tuple(sum(entry.view.size[0] * entry.view.size[1] for entry in entries)
                                  for entries in made)


def wrong_lists(verilog, transcripts):
    """Lists that hold what they must not."""
    camera = cameras()[0]
    word = HARDWARE.data_width // 8
    views = [random_view(np.random.default_rng(k), camera[0].geometry, FOCAL, size)
             for k, size in enumerate(((16, 8), (8, 12), (24, 9)))]
    entries = placed(views, [(0, 0), (16, 0), (0, 12)], (24, 21), BGR8)
    every = 0, 1, 2
    cases = [
        ({"VIEWS": 0}, (), FAULT_SIZE), ({"VIEWS": 4}, (), FAULT_SIZE),
        ({"VIEWS": 11}, (), FAULT_SIZE), ({"VIEWS": 1}, (0,), 0),
        ({"VIEW1_WIDTH": 7}, (0, 2), FAULT_SIZE), ({"VIEW0_HEIGHT": 4097}, (1, 2), FAULT_SIZE),
        ({"VIEW2_STRIP": 33}, (0, 1), FAULT_SIZE),
        ({"VIEW1_PITCH": entries[1].row_bytes - word}, (0, 2), FAULT_SIZE),
        ({"VIEW1_PITCH": 73}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_OFFSET": 50}, (0, 2), FAULT_ALIGNMENT),
        ({"VIEW1_FORMAT": 3}, (0, 2), FAULT_FORMAT),
        ({"VIEW1_OFFSET": 1 << 20}, (0, 2), FAULT_TARGET),
        ({"VIEW1_OFFSET": (1 << 32) - 64}, (0, 2), FAULT_TARGET), ({}, every, 0),
        ({"VIEW0_WIDTH": 0}, (1, 2), FAULT_SIZE), ({"VIEW2_HEIGHT": 0}, (0, 1), FAULT_SIZE),
        ({"VIEW1_WIDTH": _LARGEST[0] + 1}, (0, 2), FAULT_SIZE),
        ({"VIEW1_HEIGHT": _LARGEST[1] + 1}, (0, 2), FAULT_SIZE),
        ({"VIEW0_SPLIT": 15}, (1, 2), FAULT_SIZE),
        ({"DISTORTED_WIDTH": 7}, (), FAULT_SIZE), ({"DISTORTED_HEIGHT": 4097}, (), FAULT_SIZE),
        ({"SOURCE_PITCH": 40}, (), FAULT_SIZE), ({"SOURCE_PITCH": 50}, (), FAULT_ALIGNMENT),
        ({}, every, 0)]
    differing, outside = simulate_wrong_lists(corrector(), verilog, camera, entries, cases,
                                              clock_limit=200_000, transcripts=transcripts)
    assert differing == (0,) * len(cases) and outside == 0


def early_start(verilog, transcripts):
    """Views of a frame that the camera still writes."""
    camera = cameras()[0]
    rng, line = np.random.default_rng(9), 400
    views = [random_view(rng, camera[0].geometry, FOCAL, (40, 20)) for _ in range(2)]
    entries = placed(views, [(0, 20 * k) for k in range(2)], (40, 40))
    differing, early, clocks = simulate_follow(corrector(), verilog, camera, entries, line,
                                               memory="ideal", clock_limit=60_000,
                                               transcripts=transcripts)
    assert (differing, early) == (0, 0)
    assert clocks < 1.5 * line * camera[0].geometry.distorted_height


def far(verilog, transcripts):
    """Small views all over large raw frames, buffers with many bits of their addresses set."""
    rng = np.random.default_rng(12)
    for origins, numbers in (((0xB6A5A000, 0x49350000), ((0, 1), (2,))),
                             ((0x495A5000, 0xB69A0000), ((2,), (0, 1)))):
        lists = [[_spread(rng, large_cameras()[k][0].geometry, n) for n in numbers[k]]
                 for k in range(2)]
        result = simulate_passes(corrector(), verilog, large_cameras(), lists, memory="sdram",
                                 origins=origins, decoded=_DECODED, clock_limit=100_000,
                                 transcripts=transcripts)
        assert result.differing == (0, 0) and result.outside == 0


def whole_view(rng, geometry, size):
    """A view of the whole trained picture, from its first pixel to its last, slightly turned."""
    matrix = np.diag([(side - 1) / (of - 1) for side, of in zip(geometry.corrected, size)] + [1.])
    matrix[:2, :2] += matrix[:2, :2] @ rng.uniform(-.05, .05, (2, 2))
    return View.of(matrix, size)


def _spread(rng, geometry, number):
    """An entry whose view shows the whole trained picture, in a far part of the buffer."""
    size = ((24, 9), (40, 8), (33, 8))[number]
    size = size if geometry.corrected_width > geometry.corrected_height else size[::-1]
    view = whole_view(rng, geometry, size)
    form = (BGRX8, BGR8, BGRX8)[number]
    pitch = (0, 0x5558, 0xAAA0)[number]
    offset = (0, 0x2AAA8, 0xD5550)[number]
    return Entry(view, offset, pitch, form, (0, 0, 32)[number])


def ragged(verilog, transcripts):
    """Rows with any spans of pixels that have a source, some without such pixels."""
    camera, raw = cameras()[1]
    rng, (width, height) = np.random.default_rng(21), camera.geometry.corrected
    spans = np.sort(rng.integers(0, width, (height, 4), endpoint=True), axis=1)
    spans[::7] = 0
    torn = replace(camera, valid=ValidRows(spans))
    lists = [[Entry(View.identity((width, height))),
              Entry(random_view(rng, camera.geometry, FOCAL, (20, 10), roll=180), 0x1000)],
             [Entry(View.identity((width, height)), 0, 0, BGR8, 32)]]
    result = simulate_passes(corrector(), verilog, [(torn, raw), cameras()[0]], lists,
                             memory="ideal", clock_limit=60_000, transcripts=transcripts)
    assert result.differing == (0, 0) and result.outside == 0


def wide(verilog, transcripts):
    """Wide and tall views, in rasters and strips."""
    rng = np.random.default_rng(13)
    lists = [[Entry(random_view(rng, cameras()[k][0].geometry, FOCAL, size), offset, 0, BGR8, strip)
              for size, offset, strip in entries] for k, entries in enumerate((
                  [((2730, 8), 0, 0)], [((1365, 8), 0, 672), ((8, 1365), 0x10000, 0)]))]
    result = simulate_passes(corrector(), verilog, cameras(), lists, memory="ideal",
                             clock_limit=200_000, transcripts=transcripts)
    assert result.differing == (0, 0) and result.outside == 0


def read_back(verilog, transcripts):
    """All registers: values after reset, random ones, the valid rows."""
    wrong = simulate_read_back(corrector(), verilog, clock_limit=60_000, transcripts=transcripts)
    assert wrong == []


def resets(forgets):
    """The bench of frames that resets cut short; the memory ``forgets`` its reads or answers."""
    def run(verilog, transcripts):
        raws = [np.random.default_rng(k).integers(0, 256, cameras()[0][1].shape, np.uint8)
                for k in range(2)]
        result = simulate_resets(corrector(), verilog, raws, 5, forgets=forgets, longest=1500,
                                 lens=cameras()[0][0],
                                 memory="hostile", clock_limit=200_000,
                                 transcripts=transcripts)
        assert result.differing == (0,) * 5
    return run


def fuzz(verilog, transcripts):
    """Frames of random register values, and of right ones, in turn."""
    result = simulate_register_fuzz(corrector(), verilog, cameras()[0][1], 6,
                                    lens=cameras()[0][0], memory="fixed:9:4", clock_limit=150_000,
                                    transcripts=transcripts)
    assert result.differing == (0,) * 6 and result.outside == 0


_RUNS = {"frame": frame, "grey": grey, "lists": lists, "lens change": lens_change,
         "read back": read_back, "wrong lists": wrong_lists, "ragged rows": ragged, "far": far,
         "early start": early_start, "resets, memory forgets": resets(True),
         "resets, memory answers": resets(False), "register fuzz": fuzz, "wide": wide}

DESIGN = Design("core", "ncdc", make, tuple(PlayedBench(*item) for item in _RUNS.items()),
                leaves=("backmap", "checks", "fetch", "packer", "registers", "row_gate", "table",
                        "window", "writer", "interpolator.colour0", "interpolator.sums"))
