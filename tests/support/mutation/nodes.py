"""The network at nodes of the corrector, alone: each node's values are seen with all their bits."""

from dataclasses import replace
from functools import partial

import numpy as np

from banks import bank_words
from front_end import extreme
from mutation.core import FOCAL, cameras, corrector, large_cameras, largest
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.frontend.node_network import NodeNetwork
from ncdc_hdl.frontend.node_scan import NodeScan
from ncdc_model.golden.network import network
from ncdc_model.golden.view import node_values
from ncdc_spec.nodes import AFTER, BEFORE
from ncdc_spec.view import NODE, PLANE
from simulations.player import Player
from views import nonsense_view, random_view, sweeping_view

__all__ = ["DESIGN", "any_network"]

_S = 8              # distance of the nodes
_USUAL = 160, 20    # pictures are smaller, but for a few wide ones


def make():
    """The network at nodes, anew."""
    d = largest()
    return NodeNetwork(d.hidden_neurons, d.formats.at_nodes(), d.nodes, d.variant,
                       corrector().hardware)


def any_network(rng, d, reach=400):
    """The descriptor ``d`` with weights of all magnitudes: the tan-sigmoid's whole curve, and what
    is beyond it. ``reach``: the usual size of the output's weights, in pixels."""
    f = d.formats

    def some(q, raw, scale):
        return np.clip((rng.normal(0, scale, raw.shape) * (1 << q.f_bits)).astype(int), q.lo, q.hi)
    return replace(
        d, hidden_weights=some(f.hidden_weight, d.hidden_weights, 2),
        hidden_biases=some(f.hidden_bias, d.hidden_biases, 2),
        output_weights=some(f.output_weight, d.output_weights, reach),
        output_biases=some(f.output_bias, d.output_biases, 1000))


def _any(rng, number, largest_size):
    """A descriptor of random weights, or of weights at their limits; a view; the strips' width."""
    d = descriptor = cameras()[number % 2][0]
    if number % 4 == 3:
        descriptor = extreme(d, number)
    elif number % 4:
        descriptor = any_network(rng, d)
    size = tuple(int(side) for side in rng.integers((33, 8), largest_size))
    strip = int(rng.choice([0, 0, 32, 64, 96]))
    if strip and number % 5 == 1:               # the last strip is as wide as the others
        size = strip * -(-size[0] // strip), size[1]
    if largest_size == _USUAL and number % 11 == 7:
        size, strip = (int(rng.integers(1500, 4097)), 8), int(rng.choice([0, 1024]))
    if number % 3 == 2:
        return descriptor, nonsense_view(rng, size), strip
    return descriptor, random_view(rng, d.geometry, FOCAL, size, pan=50, roll=180,
                                   zoom=(.3, 4)), strip


def _overflowing(rng, number, _):
    """As :func:`_any`, of positions of all magnitudes, scanned like any of the cameras."""
    descriptor = (*cameras(), *large_cameras())[number % 4][0]
    size = int(rng.integers(33, 48)), int(rng.integers(8, 11))
    return descriptor, sweeping_view(rng, size), 0


def _strays(rng):
    """(position, word, whether it is written) of words that no memory takes."""
    for _ in range(24):
        position = {"role": int(rng.integers(4)), "neuron": int(rng.integers(64)),
                    "output": int(rng.integers(2))}
        there = (position["neuron"] < len(cameras()[0][0].hidden_weights)
                 and position["role"] < 3 - position["output"])
        yield position, int(rng.integers(1 << 32)), int(not there)
    for neuron, role, output in np.ndindex(2, 3, 2):
        yield ({"role": role, "neuron": neuron, "output": output}, int(rng.integers(1 << 32)), 0)
    for neuron, role in np.ndindex(8, 4):
        if neuron > 1 or role == 3:
            yield {"role": role, "neuron": neuron, "output": 0}, int(rng.integers(1 << 32)), 1
        if neuron > 1 or role > 1:
            yield {"role": role, "neuron": neuron, "output": 1}, int(rng.integers(1 << 32)), 1


def _expected(descriptor, view, strip):
    """(x, y, column, row, whole, fits) of each node, in the scan's order."""
    width, height = view.size
    found = []
    for left in range(0, width, strip or width):
        wide = min(strip or width, width - left)
        numbers = np.arange(-BEFORE, -(-wide // _S) + AFTER)
        columns, lines = np.meshgrid(left + numbers * _S, np.arange(height))
        *positions, x, y, fits = node_values(descriptor, view, columns, lines,
                                             partial(network, descriptor))
        column, row = (p >> PLANE.f_bits - NODE.f_bits for p in positions)
        whole = np.broadcast_to(numbers >= 3 - BEFORE, columns.shape)
        found.append(np.stack([x, y, column, row, whole, fits], axis=-1).reshape(-1, 6))
    return np.concatenate(found)


def _play(verilog, transcripts, seed, count, *, choose=_any, largest_size=_USUAL, stop=None,
          **plusargs):
    """Frames of any networks and views, one after the other; the items and the expected ones."""
    rng, expected = np.random.default_rng(seed), []
    player = Player(make(), ("fits", 0, ("x", "y", "column", "row")))
    bank = 0
    for number in range(count):
        descriptor, view, strip = choose(rng, number, largest_size)
        nodes = _expected(descriptor, view, strip)
        if stop and not nodes[:, 5].all():      # where one ends could not be seen
            continue
        words = list(bank_words(descriptor.hidden_weights, descriptor.hidden_biases,
                                descriptor.output_weights))
        for k in rng.permutation(len(words)):
            position, word = words[k]
            player.put(writes__write=1, writes__position=position, writes__word=word,
                       writes__bank=1 - bank)
        for position, word, write in _strays(rng):
            player.put(writes__write=write, writes__position=position, writes__word=word)
        bank = 1 - bank
        origin_x, step_x, origin_y, step_y = descriptor.geometry.scan()
        (width, height), rows = view.size, descriptor.geometry.corrected_height
        player.put(
            8, writes__write=0, writes__active=bank,
            scan={"width": width, "height": height, "strip": strip, "origin_x": origin_x,
                  "step_x": step_x, "origin_y": origin_y, "step_y": step_y},
            view={"matrix": np.reshape(view.matrix, (3, 3)).tolist(), "plane_height": rows},
            network={"output": [{"bias": int(one)} for one in descriptor.output_biases]})
        player.put(start=1, stop=0)
        if stop:
            latest = stop[1] if number % 3 else 2 * NodeScan.latency
            player.put(int(rng.integers(stop[0], latest)), start=0)
            player.put(200, True, stop=1)
        else:
            player.put(200, True, start=0)
        expected.append(nodes)
    items = player.play(verilog, transcripts, **plusargs)
    found = np.array([[one.x, one.y, one.column, one.row, one.whole, one.fits] for one in items])
    for nodes in expected:
        nodes[nodes[:, 5] == 0, :4] = 0
    return found, expected


def frames(stall):
    """The bench of whole frames, with a consumer that stalls in so many of 256 clocks."""
    def bench(verilog, transcripts):
        found, expected = _play(verilog, transcripts, 1, 24, stall=stall, clock_limit=600_000)
        np.testing.assert_array_equal(found, np.concatenate(expected))
    return bench


def small(verilog, transcripts):
    """Many small frames: overflows of all kinds."""
    found, expected = _play(verilog, transcripts, 3, 150, largest_size=(40, 10),
                            clock_limit=300_000)
    np.testing.assert_array_equal(found, np.concatenate(expected))


def overflows(verilog, transcripts):
    """Positions near each power of two: depths, quotients and coordinates that overflow."""
    found, expected = _play(verilog, transcripts, 4, 400, choose=_overflowing,
                            clock_limit=600_000)
    np.testing.assert_array_equal(found, np.concatenate(expected))
    assert .2 < found[:, 5].mean() < .8


def stopped(verilog, transcripts):
    """Frames of which no node is issued any more from some clock on."""
    found, expected = _play(verilog, transcripts, 2, 160, stop=(1, 400), stall=100,
                            clock_limit=100_000)
    at = 0
    for frame in expected:
        same = (found[at:at + len(frame)] == frame[:len(found) - at]).all(axis=1)
        at += len(same) if same.all() else int(np.argmin(same))
    assert at == len(found) > 200, (at, len(found))


DESIGN = Design("nodes", "dut", make, (
    PlayedBench("frames", frames(0)), PlayedBench("frames, stalls", frames(200)),
    PlayedBench("small frames", small), PlayedBench("stopped", stopped),
    PlayedBench("overflows", overflows)), leaves=(
        "transform.divide", "transform.normalise", "transform.reciprocal.curve",
        "transform.reciprocal.slope", "hidden.unit0", "output.output0", "output.output1"))
