"""The video output: the frame on screen, pixel by pixel, with two clocks and a stream that lags."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from kept import kept_lists
from ncdc_hdl.video.modes import MODES, VideoMode, mode_for
from ncdc_hdl.video.output import VideoOut
from ncdc_model.errors import InputError

TINY = VideoMode((24, 2, 3, 4), (10, 1, 2, 3), True, (1, 1))
SIZE = 20, 8


def colours(frame):
    """24-bit colours of a frame, none of them black."""
    return np.random.default_rng(frame).integers(1, 1 << 24, SIZE[::-1])


def show(schedule, screens, *, mode=TINY, depth=16, core=7, pixel=10):
    """Screens (n, lines, columns) that a monitor shows while the frames of ``schedule`` arrive.

    ``schedule``: (frame, wait) with ``wait(k)`` clocks before the frame's pixel k; what is no whole
    frame has no first pixel. Also returns whether each sync pulse is active, by pixel clock.
    """
    dut = VideoOut(mode, *SIZE, depth=depth)
    total = sum(mode.horizontal), sum(mode.vertical)
    trace = []

    async def feed(ctx):
        for frame, wait in schedule:
            for k, colour in enumerate(frame.ravel()):
                for _ in range(wait(k)):
                    ctx.set(dut.valid, 0)
                    await ctx.tick("sync")
                ctx.set(dut.valid, 1)
                ctx.set(dut.data, int(colour))
                ctx.set(dut.startofpacket, k == 0 and frame.shape == SIZE[::-1])
                taken = False
                while not taken:
                    _, _, taken = await ctx.tick("sync").sample(dut.ready)
        ctx.set(dut.valid, 0)

    async def watch(ctx):
        for _ in range((screens + 1) * total[0] * total[1]):
            values = await ctx.tick("pixel").sample(dut.r, dut.g, dut.b, dut.hsync, dut.vsync,
                                                    dut.blank_n)
            trace.append([int(value) for value in values[2:]])

    def run():
        simulator = Simulator(dut)
        simulator.add_clock(core * 1e-9, domain="sync")
        simulator.add_clock(pixel * 1e-9, domain="pixel")
        simulator.add_testbench(feed, background=True)
        simulator.add_testbench(watch)
        simulator.run()

    kept_lists(run, "video output", (trace,))
    trace = np.array(trace)
    # A monitor goes by the pulses: the top left pixel follows both back porches.
    active = trace[:, 3:5] == mode.high
    top = np.flatnonzero(np.diff(active[:, 1].astype(int)) == 1)[0] + 1
    start = top + sum(mode.vertical[2:]) * total[0]
    whole = trace[start:][:len(trace[start:]) // (total[0] * total[1]) * total[0] * total[1]]
    picture = whole.reshape(-1, total[1], total[0], 6)[:, :mode.size[1], :mode.size[0]]
    assert (picture[..., 5] == 1).all()
    assert whole[:, 5].sum() == len(picture) * mode.size[0] * mode.size[1]
    return picture[..., 0] << 16 | picture[..., 1] << 8 | picture[..., 2], active


def on_screen(frame, mode=TINY):
    screen = np.zeros(mode.size[::-1], int)
    left, top = ((outer - inner) // 2 for outer, inner in zip(mode.size, SIZE))
    screen[top:top + SIZE[1], left:left + SIZE[0]] = frame
    return screen


def fast(k):
    return 0


@pytest.mark.parametrize("core,pixel", [(7, 10), (10, 9)])
def test_frames_follow_each_other_on_the_screen(core, pixel):
    frames = [colours(k) for k in range(4)]
    screens, _ = show([(frame, fast) for frame in frames], 5, core=core, pixel=pixel)
    shown = [k for screen in screens for k, frame in enumerate(frames)
             if (screen == on_screen(frame)).all()]
    assert shown[:3] == list(range(shown[0], shown[0] + 3))
    others = [screen for screen in screens
              if not any((screen == on_screen(frame)).all() for frame in frames)]
    assert not np.any(others), "a screen is neither a frame nor black"


def test_sync_pulses_are_those_of_the_mode():
    _, active = show([], 3)
    for axis, mode, scale in ((0, TINY.horizontal, 1), (1, TINY.vertical, sum(TINY.horizontal))):
        edges = np.flatnonzero(np.diff(active[:, axis].astype(int)))
        first = edges[0] if active[edges[0] + 1, axis] else edges[1]
        edges = edges[edges >= first]
        assert set(np.diff(edges)[0::2]) == {mode[2] * scale}
        assert set(np.diff(edges[0::2])) == {sum(mode) * scale}


def test_a_frame_that_comes_too_slowly_ends_black_and_the_next_is_whole():
    frames = [colours(k) for k in range(5)]
    slow = [(frames[3], fast), (frames[4], fast),
            (frames[0], lambda k: 60 if k == 50 else 0), (frames[1], fast), (frames[2], fast)]
    screens, _ = show(slow, 8)
    begun = [screen for screen in screens if (screen[1, 2:22] == frames[0][0]).all()]
    assert begun, "the late frame is not shown at all"
    expected = on_screen(frames[0])
    for screen in begun:
        right = screen == expected
        assert not right.all()
        first = np.flatnonzero(~right.ravel())[0]
        assert not screen.ravel()[first:].any(), "after the gap the frame is out of step"
    assert any((screen == on_screen(frames[2])).all() for screen in screens)


def test_a_stream_that_begins_in_a_frame_is_dropped_up_to_the_next_one():
    whole = colours(2)
    screens, _ = show([(colours(1)[3:], fast), (whole, fast)], 4)
    shown = [screen for screen in screens if screen.any()]
    assert shown and all((screen == on_screen(whole)).all() for screen in shown)


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: "x".join(map(str, mode.size)))
def test_modes_refresh_at_sixty_hertz(mode):
    rate = mode.pixel_mhz * 1e6 / sum(mode.horizontal) / sum(mode.vertical)
    assert rate == pytest.approx(60, rel=6e-3)


def test_the_smallest_mode_that_holds_the_picture_is_chosen():
    assert mode_for(640, 480).size == (640, 480)
    assert mode_for(641, 480).size == (800, 600)
    assert mode_for(1280, 900).size == (1280, 1024)
    with pytest.raises(InputError,
                       match="has 1921x1080 pixels, the largest video mode has 1920x1080"):
        mode_for(1921, 1080)
