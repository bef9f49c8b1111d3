"""The three-port fetcher, window by window, with the number of reads of the golden model."""

import cocotb
import numpy as np

from benches.avalon import read_memory
from benches.common import pack, put, receive, settings, start, unpack
from ncdc_hdl.backend.layouts import request_layout, window_layout
from ncdc_model.golden.picture import fetches

__all__ = ["windows_equal_model"]

F = 10
WIDTH, HEIGHT, BASE = 37, 20, 64


def requests(rng, count):
    """Origins that wander, jump and stay; the image's corners first."""
    x0, y0 = rng.integers(0, WIDTH - 2, count), rng.integers(0, HEIGHT - 2, count)
    for k in range(8, count):
        if rng.random() < .6:
            x0[k], y0[k] = min(x0[k - 1] + rng.integers(0, 2), WIDTH - 3), y0[k - 1]
    x0[:4], y0[:4] = (0, WIDTH - 3, 0, WIDTH - 3), (0, 0, HEIGHT - 3, HEIGHT - 3)
    return x0, y0, rng.random(count) < .15


@cocotb.test()
async def windows_equal_model(dut):
    """Samples, order, flags and reads, whatever the memory does."""
    s, count = settings(), 200
    rng = np.random.default_rng(s["seed"])
    word = s["data_width"] // 8
    pitch = -(-WIDTH // word) * word
    raw = rng.integers(0, 256, (HEIGHT, pitch), np.uint8)
    content = bytes(BASE) + raw.tobytes() + bytes(2 * word)
    x0, y0, blank = requests(rng, count)
    items = [{"x0": int(x0[k]), "y0": int(y0[k]), "fx": k, "fy": 1023 - k, "blank": int(blank[k]),
              "first": k == 0, "last": k == count - 1} for k in range(count)]
    logs = [[], [], []]
    await start(dut, base=BASE, limit=len(content), pitch=pitch, memory_rst=0, i__valid=0,
                o__space=0, **{f"bus{r}__readdatavalid": 0 for r in range(3)})
    for r in range(3):
        cocotb.start_soon(read_memory(dut, f"bus{r}", content, wait=s["wait"],
                                      latency=s["latency"], seed=r, log=logs[r]))
    cocotb.start_soon(put(dut, "i", [pack(request_layout(F), item) for item in items], s["gap"]))
    for k, value in enumerate(await receive(dut, "o", count, s["stall"])):
        out = unpack(window_layout(F), value)
        assert (out.fx, out.fy, out.blank) == (k, 1023 - k, blank[k])
        assert (out.first, out.last) == (k == 0, k == count - 1)
        if not blank[k]:
            expected = raw[y0[k]:y0[k] + 3, x0[k]:x0[k] + 3]
            assert [out.samples[n] for n in range(9)] == expected.ravel().tolist(), f"window {k}"
            assert (out.odd_column, out.odd_row) == (x0[k] & 1, y0[k] & 1)
    assert [len(log) for log in logs] == [fetches(x0, y0, ~blank)] * 3
