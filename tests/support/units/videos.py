"""Sources of the stream of samples from video: AXI4-Stream and Avalon-ST."""

import numpy as np

from ncdc_hdl.camera.samples import FRAME_GAP
from pipelines import run_bench

__all__ = ["Sink", "check_avalon_st_video", "check_axis_video", "check_control_packets"]

AXIS = "tvalid", "tready", "tdata", "tuser", "tlast"
SIDES = 0x555, 0xAAA        # of large frames: between them they have each bit
HEIGHTS = [3, 3, 2, 3, 5, 3, 1, 1, 3]       # of frames whose height is to be 3
AVALON_ST = "valid", "ready", "data", "startofpacket", "endofpacket"


class Sink:
    """Gathers the frames of a stream, as lists of rows, and checks its rules."""

    def __init__(self, stream):
        self.stream, self.frames, self.under_way = stream, [], False
        self.gap = FRAME_GAP        # clocks since the last frame

    def look(self, ctx):
        """Take what the stream gives in this clock."""
        o = self.stream
        valid, first, last, end = (ctx.get(signal) for signal in (o.valid, o.first, o.last, o.end))
        if first:
            assert not self.under_way and (self.gap >= FRAME_GAP or len(o.sample) == 1)
            self.frames.append({"rows": [[]], "ended": False})
            self.under_way = True
        self.gap = 0 if end or self.under_way else self.gap + 1
        if valid:
            assert self.under_way
            self.frames[-1]["rows"][-1] += [ctx.get(o.sample[k]) for k in range(len(o.sample))
                                            if valid >> k & 1]
        else:
            assert not first and not last
        if last:
            self.frames[-1]["rows"].append([])
        if end:
            assert self.under_way
            self.under_way, self.frames[-1]["ended"] = False, not ctx.get(o.bad)

    @property
    def ended(self):
        """Rows of the frames that ended, and are not bad."""
        return [frame["rows"][:-1] for frame in self.frames if frame["ended"]]


def beats_of(frame, count, bits):
    """(TDATA, TUSER, TLAST) of the beats of a frame."""
    for y, row in enumerate(frame):
        for x in range(0, len(row), count):
            yield (sum(int(sample) << bits * k for k, sample in enumerate(row[x:x + count])),
                   x == y == 0, x + count == len(row))


def run_video(dut, rng, sessions, names):
    """Offer the beats of ``sessions``, each beat until it is taken; the sink of the samples, and
    how often each fault was reported.

    A session has settings by name, and beats: tuples of the inputs of ``names`` after ``valid``.
    """
    sink, faults = Sink(dut.o), dict.fromkeys((name for name, _ in dut.faults.shape()), 0)
    valid, ready, *inputs = (getattr(dut, name) for name in names)

    async def offer(ctx, beat):
        gap = rng.integers(0, 3) if rng.integers(2) else 0
        for now in [*[None] * gap, beat]:
            ctx.set(valid, now is not None)
            for signal, value in zip(inputs, now or rng.integers(0, 2, len(inputs))):
                ctx.set(signal, int(value))
            taken = False
            while not taken:
                taken = now is None or ctx.get(ready)
                await ctx.tick()
                sink.look(ctx)
                for name in faults:
                    faults[name] += ctx.get(dut.faults[name])

    async def bench(ctx):
        for settings, beats in sessions:
            for name, value in settings.items():
                ctx.set(getattr(dut, name), value)
            for beat in [*beats, *[None] * 6]:
                await offer(ctx, beat)

    run_bench(dut, bench)
    return sink, faults


def check_axis_video(dut, count, bits):
    """Beats with gaps or without; short frames end as bad, rows outside of a frame are reported and
    dropped; the next frame is right. Frames are low and high."""
    rng = np.random.default_rng(count * bits)
    frames = [rng.integers(0, 1 << bits, (rows, count * 4)) for rows in HEIGHTS]
    # Rows before the first frame.
    beats = [(1, 0, 0), (1, 0, 1), *(beat for frame in frames
                                     for beat in beats_of(frame, count, bits))]
    tall = [rng.integers(0, 1 << bits, (rows, count))
            for rows in (*SIDES, 1, 65, *rng.integers(2, 300, 6))]
    sink, faults = run_video(dut, rng, [({"height": 3}, beats), *(
        ({"height": len(frame)}, [*beats_of(frame, count, bits), (1, 0, 1)])
        for frame in tall)], AXIS)
    upper = [frame[:3] << 12 >> bits for frame in frames if len(frame) >= 3]
    upper += [frame << 12 >> bits for frame in tall]
    assert sink.ended == [frame.tolist() for frame in upper]
    assert len(sink.frames) == len(frames) + len(tall)
    assert faults == {"short": 3, "stray": 1 + 2 + len(tall)}


def packed(symbols, count, bits, start):
    """(data, startofpacket, endofpacket, empty) of the beats of a packet's symbols."""
    for x in range(0, len(symbols), count):
        beat = symbols[x:x + count]
        yield (sum(int(symbol) << bits * k for k, symbol in enumerate(beat)), start and x == 0,
               x + count >= len(symbols), count - len(beat))


def control_packet(width, height, count, bits):
    """Beats of the packet of the manual: four bits a symbol, the upper ones first; progressive."""
    symbols = [int(digit, 16) for digit in f"{width:04x}{height:04x}3"]
    return [(15, 1, 0, 0), *packed(symbols, count, bits, start=False)]


def avalon_names(count):
    """Names of the inputs that beats have."""
    return AVALON_ST if count == 1 else (*AVALON_ST, "empty")


def check_avalon_st_video(dut, count, bits):
    """Packets of frames, whose last beat may have fewer samples; a packet in a packet ends that one
    as bad; beats outside of a packet are dropped. Frames are narrow and wide."""
    rng, width = np.random.default_rng(count * bits), 4 * count
    frames = [rng.integers(0, 1 << bits, rows * width - (number == 1))
              for number, rows in enumerate(HEIGHTS)]
    packets = [list(packed(frame, count, bits, True)) for frame in frames]
    for number in (3, 5):
        packets[number].pop()               # with its end
    packets[7].append((1, 0, 1, 0))         # outside, while the source is not ready
    stray = [(1, 0, 0, 0), (1, 0, 1, 0)]
    beats = [*stray, *(beat for packet in packets for beat in packet)]
    sides = [side // count * count for side in SIDES]
    sides += [count, 2 * count, *(int(beats) * count for beats in rng.integers(3, 200, 6))]
    wide = [rng.integers(0, 1 << bits, 3 * side - k % count) for k, side in enumerate(sides)]
    sink, faults = run_video(dut, rng, [({"width": width}, beats), *(
        ({"width": side}, list(packed(frame, count, bits, True)))
        for side, frame in zip(sides, wide))], avalon_names(count))
    rows = [[(frame[x:x + side] << 12 >> bits).tolist() for x in range(0, len(frame), side)]
            for side, frame in [*((width, frame) for number, frame in enumerate(frames)
                                  if number not in (3, 5)), *zip(sides, wide)]]
    assert sink.ended == rows and len(sink.frames) == len(frames) + len(wide)
    assert faults == {"short": 2, "stray": 2}


def check_control_packets(dut, count, bits):
    """Types of packets; other ones are skipped; a frame of another size is bad, and so is one
    that lacks its end. Sizes are small and large."""
    rng, width, height = np.random.default_rng(count * bits), 8 * count, 3
    frames = rng.integers(0, 1 << bits, (7, width * height))
    beats, sizes = [], {0: (width, height), 2: (height, width), 3: (width, height),
                        5: (width + 0x300, height)}
    for number, frame in enumerate(frames):
        if number in sizes:
            beats += control_packet(*sizes[number], count, bits)
        if number == 1:                     # a packet of another type
            beats += [(3, 1, 0, 0), (77, 0, 0, 0), (78, 0, 1, 0)]
        packet = list(packed(frame, count, bits, False))
        if number == 4:
            packet.pop()
        if number == 2:                     # packets of a beat, which is their type
            beats += [(0, 1, 1, 0), (3, 1, 1, 0)]
        if number == 6:                     # a frame without samples and end
            beats += [(0, 1, 0, 0)]
        beats += [(0, 1, 0, 0), *packet]
    # Each bit of a size wrong, in packets of few samples; then the right one.
    sessions, wrong, whole = [({"width": width, "height": height}, beats)], 0, []
    for side, other in zip(SIDES, reversed(SIDES)):
        side = side // count * count
        few = rng.integers(0, 1 << bits, (17, 4 * count + 1))
        sizes = [(side ^ 1 << k, other) if k < 16 else (side, other) for k in range(0, 17, 2)]
        sizes += [(side, other ^ 1 << k) for k in range(16)] + [(side, other)]
        made = []
        for k, size in enumerate(sizes):
            made += control_packet(*size, count, bits)
            made += [(0, 1, 0, 0), *packed(few[k % 17], count, bits, False)]
            right = size == (side, other)
            wrong += not right
            whole += [[(few[k % 17] << 12 >> bits).tolist()]] if right else []
        # A frame of three rows, whatever was said of its height.
        rows = rng.integers(0, 1 << bits, (3, side))
        made += [(0, 1, 0, 0), *packed(rows.ravel(), count, bits, False)]
        whole.append((rows << 12 >> bits).tolist())
        sessions.append(({"width": side, "height": other}, [*made, (1, 0, 1, 0)]))
    sink, faults = run_video(dut, rng, sessions, avalon_names(count))
    right = [(frame.reshape(height, width) << 12 >> bits).tolist() for frame in frames[[0, 1, 3]]]
    assert sink.ended == right + whole
    assert faults == {"short": 1, "stray": len(SIDES), "size": 3 + wrong}
