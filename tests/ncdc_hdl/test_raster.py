"""Hidden layers after the scan: nets of every pixel equal the golden model, with gaps or without.

The raster layer and the multiplying one share every test. The frames' neurons walk the edges of
rounding and saturation, and hold weights at the limits of their formats.
"""

import numpy as np
import pytest
from amaranth import *

from banks import bank_words, take_bank, write_bank
from cases import cases
from ncdc_hdl.frontend.backmap import pace
from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.neural.layers import MultiplyLayer
from ncdc_hdl.neural.neuron import WeightedSum
from ncdc_hdl.neural.raster import RasterLayer
from ncdc_model.golden.network import hidden_neuron
from ncdc_spec.descriptor import Formats
from ncdc_spec.fixed import requantise
from ncdc_spec.geometry import SCAN, Geometry, scan_order
from pipelines import run_bench
from saturations import WRONG_SATURATIONS

FORMATS = Formats()
LAYERS = {"multiply": MultiplyLayer, "raster": RasterLayer}


class ScannedLayer(Elaboratable):
    """A scan and a hidden layer for each lane; ``forced`` fields of the pixel are stuck at zero.

    ``issue`` marks a pixel's turn 0, one clock after ``pause`` has been low at the earliest.
    """

    def __init__(self, kind, neurons, share, forced=(), lanes=1):
        self.scan = Scan(FORMATS, lanes)
        self.layers = [LAYERS[kind](neurons, FORMATS, share, lanes=lanes) for _ in range(lanes)]
        self.forced, self.share = forced, share
        self.pause, self.issue = Signal(), Signal()

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan = scan = self.scan
        issue, turn = pace(m, scan, self.share, ~self.pause & self.layers[0].ready)
        m.d.comb += [scan.table.fresh.eq(1), self.issue.eq(issue)]
        for k, layer in enumerate(self.layers):
            m.submodules[f"layer{k}"] = layer
            m.d.comb += [layer.active.eq(scan.active), layer.pixel.eq(scan.pixels[k]),
                         layer.start.eq(scan.start), layer.advance.eq(scan.advance),
                         layer.turn.eq(turn)]
            m.d.comb += [layer.pixel[name].eq(0) for name in self.forced]
        return m


def scan_of(width, height, mirrored=False):
    """Width, height, origins and steps; ``mirrored``: from the last column to the first."""
    origin_x, step_x, origin_y, step_y = Geometry(width, height, 8, 8).scan()
    if mirrored:
        origin_x, step_x = -origin_x, -step_x
    return width, height, origin_x, step_x, origin_y, step_y


def nets(scan, weights, biases, strip=0):
    """Nets of the golden model, shape (pixels, neurons)."""
    width, height, origin_x, step_x, origin_y, step_y = scan
    shift = SCAN.f_bits - FORMATS.input.f_bits
    v, u = (scan_order(a, strip) for a in np.indices((height, width)))
    x = requantise(origin_x + u * step_x, shift, FORMATS.input)
    y = requantise(origin_y + v * step_y, shift, FORMATS.input)
    return np.stack([hidden_neuron(x, y, w, b, FORMATS) for w, b in zip(weights, biases)], axis=1)


def run(dut, frames, gap=0.0, seed=1, strip=0):
    """Nets of one frame for each (scan, weights, biases), each of shape (pixels, neurons)."""
    layer, scan, rng = dut.layers[0], dut.scan, np.random.default_rng(seed)
    share, latency = layer.share, layer.latency
    samples, taken = [], []

    async def clock(ctx):
        ctx.set(dut.pause, int(rng.random() < gap))
        await ctx.tick()
        samples.append([[ctx.get(o) for o in layer.o] for layer in dut.layers])

    async def bench(ctx):
        for frame, (parameters, weights, biases) in enumerate(frames):
            names = ("width", "height", "origin_x", "step_x", "origin_y", "step_y")
            ctx.set(scan.parameters, dict(zip(names, parameters)) | {"strip": strip})
            for layer in dut.layers:
                if "writes" in layer.signature.members:
                    await write_bank(ctx, layer.writes, bank_words(weights, biases, []))
                    take_bank(ctx, layer.writes)
                    continue
                for j, (w, b) in enumerate(zip(weights, biases)):
                    ctx.set(layer.neurons[j], {"weights": [int(v) for v in w], "bias": int(b)})
            ctx.set(scan.start, 1)
            await clock(ctx)
            ctx.set(scan.start, 0)
            for _ in range(parameters[0] * parameters[1] // len(dut.layers)):
                while not ctx.get(dut.issue):
                    await clock(ctx)
                taken.append((frame, len(samples)))
                await clock(ctx)
            for _ in range(latency + share):
                await clock(ctx)

    run_bench(dut, bench)
    results = [[] for _ in frames]
    for frame, at in taken:
        # A sample is taken after its clock: that of ``latency`` clocks has the index before.
        turns = samples[at + latency - 1:at + latency - 1 + share]
        for lane in range(len(dut.layers)):
            results[frame].append([turns[j % share][lane][j // share]
                                   for j in range(len(frames[0][2]))])
    return [np.array(result) for result in results]


def bias_edges():
    """(weights, bias) of sums that stay on or next to an edge of rounding or saturation."""
    f = FORMATS
    shift = f.hidden_bias.f_bits - f.net.f_bits
    return [([0, 0], (edge << shift) - (1 << (shift - 1)) + d)
            for edge in (f.net.lo + 1, f.net.hi, f.net.hi + 1, 0, 1) for d in (-1, 0, 1)]


def extremes(rng, count):
    """(weights, bias) at the limits of their formats and close to them."""
    w, b = FORMATS.hidden_weight, FORMATS.hidden_bias
    return [(rng.choice([w.lo, w.lo + 1, -1, 0, 1, w.hi], 2), rng.choice([b.lo, 0, b.hi]))
            for _ in range(count)]


def anything(rng, count):
    """(weights, bias) of every size, so that nets of every size appear, saturated ones as well."""
    w, b = FORMATS.hidden_weight, FORMATS.hidden_bias
    return [(rng.integers(w.lo, w.hi, 2, endpoint=True) >> rng.integers(0, 20),
             rng.integers(b.lo, b.hi, endpoint=True) >> rng.integers(0, 28))
            for _ in range(count)]


def check(dut, frames, strip=0, **how):
    for result, frame in zip(run(dut, frames, strip=strip, **how), frames, strict=True):
        np.testing.assert_array_equal(result, nets(*frame, strip))


def frame_of(scan, neurons):
    return scan, *zip(*neurons)


@pytest.mark.parametrize("kind", cases([*LAYERS], longer=["raster"]))
@pytest.mark.parametrize("gap", [.4, pytest.param(0, marks=pytest.mark.regress)])
def test_edges_and_extremes(kind, gap):
    rng = np.random.default_rng(3)
    neurons = bias_edges() + extremes(rng, 17)
    frames = [frame_of(scan_of(8, 8), neurons),
              frame_of(scan_of(13, 9), extremes(rng, 16) + anything(rng, 16)),
              frame_of(scan_of(29, 8, mirrored=True), anything(rng, 32))]
    check(ScannedLayer(kind, 32, 1), frames, gap=gap)
    found = np.concatenate([nets(*frame).ravel() for frame in frames])
    q = FORMATS.net
    assert {q.lo, q.lo + 1, q.hi - 1, q.hi, 0} <= set(found.tolist())
    assert len(set(found.tolist())) > 1000


@pytest.mark.parametrize("kind", LAYERS)
@pytest.mark.parametrize("neurons,share", [(1, 1), (5, 3), *(
    pytest.param(*case, marks=pytest.mark.regress) for case in ((2, 2), (5, 1), (8, 4), (7, 7)))])
def test_neurons_and_turns(kind, neurons, share):
    rng = np.random.default_rng(neurons)
    frames = [frame_of(scan_of(11, 9), extremes(rng, neurons)),
              frame_of(scan_of(9, 8), anything(rng, neurons))]
    check(ScannedLayer(kind, neurons, share), frames, gap=.2)


@pytest.mark.parametrize("kind", LAYERS)
@pytest.mark.parametrize("share,lanes,strip,gap", [
    (1, 2, 32, .3), (2, 4, 0, 0), *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (1, 1, 32, .2), (2, 1, 64, 0)))])
def test_strips_and_lanes(kind, share, lanes, strip, gap):
    """After a strip, in each lane; the first picture's groups of 4 are half the range apart."""
    rng = np.random.default_rng(5)
    frames = [frame_of(scan_of(*size), anything(rng, 3) + extremes(rng, 2))
              for size in ((8, 8), (72, 8))]
    check(ScannedLayer(kind, 5, share, lanes=lanes), frames, gap=gap, strip=strip)


@pytest.mark.longer
def test_long_rows_do_not_drift():
    """Rows whose steps are small and whose carries are irregular."""
    rng = np.random.default_rng(9)
    check(ScannedLayer("raster", 4, 1), [frame_of(scan_of(1999, 8), anything(rng, 4))])


def frame_with_everything():
    rng = np.random.default_rng(4)
    return [frame_of(scan_of(13, 9), bias_edges() + anything(rng, 5))]


@pytest.mark.parametrize("field", ["x_carry", "y_carry", "x_step", "y_step", "new_row"])
def test_finds_a_field_of_the_scan_that_is_lost(field):
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check(ScannedLayer("raster", 20, 1, forced=[field]), frame_with_everything())


def test_finds_a_new_strip_that_is_lost():
    frames = [frame_of(scan_of(40, 9), anything(np.random.default_rng(4), 20))]
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check(ScannedLayer("raster", 20, 1, forced=["new_strip"]), frames, strip=32)


@pytest.mark.parametrize("wrong", WRONG_SATURATIONS)
def test_finds_a_wrong_saturation(wrong, monkeypatch):
    monkeypatch.setattr("ncdc_hdl.neural.raster.saturate", wrong)
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check(ScannedLayer("raster", 20, 1), frame_with_everything())


@pytest.mark.parametrize("kind", LAYERS)
@pytest.mark.parametrize("field,wrong", [
    ("half", lambda q: (1 << (q.shift - 1)) - 1), ("half", lambda q: 0),
    ("bias_shift", lambda q: q.xq.f_bits + q.wq.f_bits - q.bq.f_bits - 1)],
    ids=["half - 1", "no half", "bias shift - 1"])
def test_finds_a_wrong_constant(kind, field, wrong, monkeypatch):
    monkeypatch.setattr(WeightedSum, field, property(wrong))
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check(ScannedLayer(kind, 20, 1), frame_with_everything())
