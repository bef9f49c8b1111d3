"""Sources of the stream of samples: a parallel sensor's pins, AXI4-Stream and Avalon-ST video."""

import numpy as np
import pytest

from ncdc_hdl.camera.avalon_st_source import AvalonStSource
from ncdc_hdl.camera.axis_source import AxisSource
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_hdl.camera.samples import FRAME_GAP
from ncdc_spec.camera_port import SAMPLE_BITS, SAMPLES_PER_CLOCK, CameraPort, camera_port
from ncdc_spec.errors import InputError
from pipelines import run_bench


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


def pins_of(rng, frame, close):
    """(FRAME_VALID, LINE_VALID) and sample of each clock; ``close``: both fall together, and a
    single clock lies between two frames."""
    clocks = [(1, 0, 5)] * (0 if close else rng.integers(0, 4))
    for y, row in enumerate(frame):
        clocks += [(1, 1, int(sample)) for sample in row]
        clocks += [(1, 0, 7)] * (0 if close and y == len(frame) - 1 else rng.integers(1, 4))
    return clocks + [(0, int(rng.integers(2)), 9)] * (1 if close else rng.integers(1, 9))


def test_parallel_pins():
    """Rows of one sample and more, pauses of every length; a frame under way at first is none."""
    dut, rng = ParallelSource(), np.random.default_rng(1)
    frames = [rng.integers(0, 4096, (1 + number % 3, 1 + number % 4)) for number in range(24)]
    sink = Sink(dut.o)

    async def bench(ctx):
        clocks = [(1, 1, 3)] * 4 + [(1, 0, 3)] + [(0, 0, 3)]
        for number, frame in enumerate(frames):
            clocks += pins_of(rng, frame, number % 2)
        for frame, line, sample in [*clocks, *[(1, 0, 1)] * 3, *[(0, 1, 1)] * 4]:
            ctx.set(dut.pins.frame_valid, frame)
            ctx.set(dut.pins.line_valid, line)
            ctx.set(dut.pins.data, sample)
            await ctx.tick()
            sink.look(ctx)

    run_bench(dut, bench)
    assert sink.ended == [frame.tolist() for frame in frames] and len(sink.frames) == len(frames)


def beats_of(frame, count, bits):
    """(TDATA, TUSER, TLAST) of the beats of a frame."""
    for y, row in enumerate(frame):
        for x in range(0, len(row), count):
            yield (sum(int(sample) << bits * k for k, sample in enumerate(row[x:x + count])),
                   x == y == 0, x + count == len(row))


def forms(form):
    """One form of beats, and all others as longer tests."""
    return pytest.mark.parametrize("count,bits", [form, *(
        pytest.param(count, bits, marks=pytest.mark.longer)
        for count in SAMPLES_PER_CLOCK for bits in SAMPLE_BITS if (count, bits) != form)])


def run_video(dut, rng, settings, beats, names):
    """Offer ``beats``, tuples of the inputs of ``names`` after ``valid``, each until it is taken;
    the sink of the samples, and how often each fault was reported."""
    sink, faults = Sink(dut.o), dict.fromkeys((name for name, _ in dut.faults.shape()), 0)
    valid, ready, *inputs = (getattr(dut, name) for name in names)

    async def bench(ctx):
        for name, value in settings.items():
            ctx.set(getattr(dut, name), value)
        for beat in [*beats, *[None] * 6]:
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

    run_bench(dut, bench)
    return sink, faults


AXIS = "tvalid", "tready", "tdata", "tuser", "tlast"
HEIGHTS = [3, 3, 2, 3, 5, 3, 1, 1, 3]       # of frames whose height is to be 3


@forms((2, 10))
def test_axis_video(count, bits):
    """Beats with gaps or without; short frames end as bad, rows outside of a frame are reported and
    dropped; the next frame is right."""
    rng = np.random.default_rng(count * bits)
    frames = [rng.integers(0, 1 << bits, (rows, count * 4)) for rows in HEIGHTS]
    # Rows before the first frame.
    beats = [(1, 0, 0), (1, 0, 1), *(beat for frame in frames
                                     for beat in beats_of(frame, count, bits))]
    sink, faults = run_video(AxisSource(count, bits), rng, {"height": 3}, beats, AXIS)
    upper = [frame[:3] << 12 >> bits for frame in frames if len(frame) >= 3]
    assert sink.ended == [frame.tolist() for frame in upper]
    assert len(sink.frames) == len(frames) and faults == {"short": 3, "stray": 1 + 2}


AVALON_ST = "valid", "ready", "data", "startofpacket", "endofpacket"


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
    return AVALON_ST if count == 1 else (*AVALON_ST, "empty")


@forms((4, 12))
def test_avalon_st_video(count, bits):
    """Packets of frames, whose last beat may have fewer samples; a packet in a packet ends that one
    as bad; beats outside of a packet are dropped."""
    rng, width = np.random.default_rng(count * bits), 4 * count
    frames = [rng.integers(0, 1 << bits, rows * width - (number == 1))
              for number, rows in enumerate(HEIGHTS)]
    packets = [list(packed(frame, count, bits, True)) for frame in frames]
    for number in (3, 5):
        packets[number].pop()               # with its end
    stray = [(1, 0, 0, 0), (1, 0, 1, 0)]
    beats = [*stray, *(beat for packet in packets for beat in packet)]
    sink, faults = run_video(AvalonStSource(count, bits), rng, {"width": width}, beats,
                             avalon_names(count))
    rows = [[(frame[x:x + width] << 12 >> bits).tolist() for x in range(0, len(frame), width)]
            for number, frame in enumerate(frames) if number not in (3, 5)]
    assert sink.ended == rows and len(sink.frames) == len(frames)
    assert faults == {"short": 2, "stray": 1}


@forms((2, 8))
def test_avalon_st_video_with_control_packets(count, bits):
    """Types of packets; other ones are skipped; a frame of another size is bad, and so is one
    that lacks its end."""
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
        beats += [(0, 1, 0, 0), *packet]
    sink, faults = run_video(AvalonStSource(count, bits, control=True), rng,
                             {"width": width, "height": height}, beats, avalon_names(count))
    right = [(frame.reshape(height, width) << 12 >> bits).tolist() for frame in frames[[0, 1, 3]]]
    assert sink.ended == right and len(sink.frames) == len(frames)
    assert faults == {"short": 1, "stray": 0, "size": 3}


@pytest.mark.parametrize("options,message", [
    (("axis", 3), "samples per clock is 3, it must be one of 1, 2, 4"),
    (("axis", 2, 14), "bits per sample is 14, it must be one of 8, 10, 12, 16"),
    (("parallel", 2), "a parallel camera has 1 sample per clock, not 2"),
    (("csi2:2", 4), "csi2:2 has 2 samples per clock, not 4"),
    (("csi2:2", 2, 10), "of the kind csi2 has samples of 12 bits, not 10"),
    (("csi2:3",), "--camera is csi2:3, it must be parallel, axis, avalon-st, avalon-st:vip, csi2"),
    (("csi2",), "--camera is csi2, it must be"), (("usb",), "--camera is usb, it must be")])
def test_cameras_that_are_not_supported(options, message):
    with pytest.raises(InputError, match=message):
        camera_port(*options)


def test_cameras_that_are_supported():
    assert camera_port("csi2:4") == CameraPort("csi2", 4)
    assert camera_port("avalon-st:vip", 2, 8) == CameraPort("avalon-st:vip", 2, 8)
    assert camera_port("csi2:4").options == ["--camera csi2:4"]
