"""The packer alone: pictures of any size, format, place and pitch, in buffers anywhere."""

import numpy as np

from ncdc_hdl.frontend.strips import Strips
from ncdc_spec.frames import MONO8, OUTPUT_FORMATS
from ncdc_spec.geometry import scan_order
from pipelines import get, run_bench

__all__ = ["check_packer", "groups"]


def groups(pixels, strip, lanes, upto=None):
    """Items of the packer's stream: ``pixels`` (height, width, 3), the last one at ``upto``."""
    order = scan_order(pixels, strip)[:upto].tolist()
    items = []
    for k in range(0, len(order), lanes):
        lane = [{"r": r, "g": g, "b": b} for r, g, b in order[k:k + lanes]]
        items.append((lane[0] if lanes == 1 else {"lane": lane})
                     | {"first": k == 0, "last": k + lanes == len(order)})
    return items


class _Frame:
    """A picture of noise and where it goes; every third one to the end of its buffer."""

    def __init__(self, rng, size, word):
        width, height = size
        self.size, self.pixels = size, rng.integers(0, 256, (height, width, 3))
        self.form = list(OUTPUT_FORMATS.values())[int(rng.integers(len(OUTPUT_FORMATS)))]
        self.strip = int(rng.choice([0, 32, 64] if width < 1000 else [0, 992, 1376]))
        row = self.form.pixel_bytes * width
        least = -(-row // word) * word
        self.pitch = int(rng.choice([0, least, least + word * int(rng.integers(1, 99))]))
        self.stride = self.pitch or row
        room = self.stride * height + 64 * word
        self.base = int(rng.integers((1 << 32) // word - room // word)) * word
        self.origin = self.base + word * int(rng.integers(9))
        ends = -(-(self.origin + self.stride * (height - 1) + row) // word) * word
        self.limit = ends + word * int(rng.integers(3)) * int(rng.integers(2))
        self.upto = int(rng.integers(1, width * height)) if rng.random() < .2 else None

    def bytes(self):
        """The bytes of memory that the picture sets, by address."""
        width, height = self.size
        order = scan_order(np.arange(width * height).reshape(height, width), self.strip)
        found, count = {}, self.form.pixel_bytes
        for v, u in zip(*np.divmod(order[:self.upto], width)):
            red, green, blue = map(int, self.pixels[v, u])
            stored = [green] if self.form == MONO8 else [blue, green, red, 0][:count]
            at = self.origin + int(v) * self.stride + int(u) * count
            found |= {at + k: value for k, value in enumerate(stored)}
        return found


def check_packer(dut, sizes, seed=3):
    """The bytes of memory that each picture sets, and no other one.

    ``dut``: a :class:`ncdc_hdl.backend.packer.Packer` of one lane that is ``placed``; ``sizes``:
    of the pictures, one after the other.
    """
    rng, word = np.random.default_rng(seed), dut.data_width // 8
    frames, written = [_Frame(rng, size, word) for size in sizes], []

    async def begin(ctx, frame):
        ctx.set(dut.format, frame.form.code)
        for name in ("base", "limit", "origin", "pitch"):
            ctx.set(getattr(dut, name), getattr(frame, name))
        width, height = frame.size
        ctx.set(dut.order, {"width": width, "height": height, "strip": frame.strip})
        ctx.set(dut.start, 1)
        await ctx.tick()
        ctx.set(dut.start, 0)
        await ctx.tick().repeat(Strips.latency - 1)

    async def source(ctx):
        for k, frame in enumerate(frames):
            while len(written) < k:
                await ctx.tick()
            await begin(ctx, frame)
            gap = rng.choice([0, .3])
            for item in groups(frame.pixels, frame.strip, 1, frame.upto):
                while rng.random() < gap:
                    await ctx.tick()
                ctx.set(dut.i.payload, item)
                ctx.set(dut.i.valid, 1)
                while not (await ctx.tick().sample(dut.i.ready))[2]:
                    pass
                ctx.set(dut.i.valid, 0)

    async def sink(ctx):
        for _ in frames:
            stall, found, last = rng.choice([0, .4]), {}, False
            while not last:
                word_, = await get(ctx, dut.o, 1, lambda stall=stall: rng.random() < stall)
                last = word_.last
                found |= {word_.address + k: word_.data >> 8 * k & 0xFF
                          for k in range(word) if word_.enable >> k & 1 and not word_.void}
            written.append(found)

    async def never_outside(ctx):
        while True:
            assert not (await ctx.tick().sample(dut.outside))[2]

    run_bench(dut, source, sink, background=(never_outside,))
    for k, (frame, found) in enumerate(zip(frames, written)):
        assert found == frame.bytes(), (k, frame.size, frame.form, frame.strip, frame.pitch)
