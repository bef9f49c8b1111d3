"""Bayer decoder and bilinear interpolator, pixel by pixel, compared with the golden model."""

import cocotb
import numpy as np

from benches.common import get, pack, send, settings, start, unpack
from ncdc_hdl.backend.layouts import pixel_layout, window_layout
from ncdc_model.golden.picture import bayer_quads, bilinear

__all__ = ["equals_model"]

F = 10
FILL = 0x123456


@cocotb.test()
async def equals_model(dut):
    """Flat, full-contrast and random windows at both ends of the fractions, blanks between."""
    s, rng, count = settings(), np.random.default_rng(6), 300
    phase = s["phase"]
    windows, fractions = rng.integers(0, 256, (count, 3, 3)), rng.integers(0, 1 << F, (count, 2))
    windows[0], windows[1], windows[2::40] = 0, 255, rng.integers(0, 2, (3, 3)) * 255
    fractions[::7], fractions[3::7] = 0, (1 << F) - 1
    origins, blank = rng.integers(0, 2, (count, 2)), rng.random(count) < .2
    items = [{"samples": windows[k].ravel().tolist(), "odd_column": int(origins[k, 0]),
              "odd_row": int(origins[k, 1]), "fx": int(fractions[k, 0]), "fy": int(fractions[k, 1]),
              "blank": int(blank[k]), "first": k == 0, "last": k == count - 1}
             for k in range(count)]
    await start(dut, phase=phase[0] | phase[1] << 1, fill=FILL, i__issue=0,
                i__valid=0, o__ready=0)
    cocotb.start_soon(send(dut, "i", [pack(window_layout(F), item) for item in items], s["gap"]))
    got = [unpack(pixel_layout(), value) for value in await get(dut, "o", count, s["stall"])]
    expected = bilinear(bayer_quads(windows, *origins.T, phase), *fractions.T, F)
    expected[blank] = list(FILL.to_bytes(3, "big"))
    np.testing.assert_array_equal([[p.r, p.g, p.b] for p in got], expected)
    assert [k for k, p in enumerate(got) if p.first] == [0]
    assert [k for k, p in enumerate(got) if p.last] == [count - 1]
