"""The front end: two frames of coordinates in raster order, compared with the golden model."""

import random

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge

from benches.common import clocks, get, pack, settings, start, unpack
from ncdc_hdl.frontend.layouts import SPANS, coordinate_layout, network_layout, scan_layout
from ncdc_model.correction import frame_coordinates
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.hardware import Hardware

__all__ = ["two_frames_equal_model"]


def scan_of(d):
    """The scan's parameters of descriptor ``d``."""
    names = ("width", "height", "origin_x", "step_x", "origin_y", "step_y")
    return dict(zip(names, (*d.geometry.corrected, *d.geometry.scan())))


def network_of(d):
    """The network's weights and biases of descriptor ``d``."""
    layers = {layer: [{"weights": w.tolist(), "bias": int(b)} for w, b in zip(weights, biases)]
              for layer, weights, biases in (("hidden", d.hidden_weights, d.hidden_biases),
                                             ("output", d.output_weights, d.output_biases))}
    if d.skip_weights is not None:
        for neuron, weights in zip(layers["output"], d.skip_weights):
            neuron["skip"] = weights.tolist()
    return layers


async def table(dut, spans, busy):
    """Answer the scan with the valid ``spans`` of its row, unless busy with the host."""
    rng = random.Random(8)
    while True:
        row = int(dut.table__row.value) % len(spans)
        fresh = rng.random() >= busy
        answer = dict(zip(("start0", "stop0", "start1", "stop1"), spans[row].tolist()))
        dut.table__spans.value = (pack(SPANS, answer) if fresh
                                  else rng.getrandbits(len(dut.table__spans)))
        dut.table__fresh.value = int(fresh)
        await FallingEdge(dut.clk)


@cocotb.test()
async def two_frames_equal_model(dut):
    """Coordinates, blanks, first and last of every pixel."""
    s = settings()
    d = Descriptor.load(s["descriptor"])
    f = d.formats
    await start(dut, start=0, abort=0, o__ready=0, table__fresh=0, table__spans=0,
                scan=pack(scan_layout(), scan_of(d)),
                network=pack(network_layout(d.hidden_neurons, f, Hardware()), network_of(d)))
    cocotb.start_soon(table(dut, d.valid.spans, s["busy"]))
    x, y = frame_coordinates(d)
    blank = ~d.valid.mask(d.geometry.corrected_width)
    flags = np.zeros((2, x.size), int)
    flags[0, 0] = flags[1, -1] = 1
    expected = np.stack([x.ravel(), y.ravel(), blank.ravel(), *flags], axis=1)
    assert 0 < blank.sum() < blank.size
    for frame in range(2):
        dut.start.value = 1
        await clocks(dut, 1)
        dut.start.value = 0
        got = [unpack(coordinate_layout(f), value)
               for value in await get(dut, "o", x.size, s["stall"], seed=frame, limit=1000)]
        np.testing.assert_array_equal([[c.x, c.y, c.blank, c.first, c.last] for c in got], expected)
