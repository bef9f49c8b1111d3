"""The scan-out of frames in memory, for pixels of three bytes and a small video mode."""

from functools import cache

import numpy as np

from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.video.modes import VideoMode
from ncdc_hdl.video.scan_out import ScanOut
from ncdc_sim.runner import build_bench, command_of, hdl_text
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from simulations import HDL

__all__ = ["DESIGN"]

_TOP = "scan_out"
_MODE = VideoMode((70, 6, 8, 12), (24, 2, 3, 9), True, (1, 2))
_WIDTH, _HEIGHT = 61, 20            # of a frame: its last word is not full
_BUFFER, _BYTES = 4096, 65536       # bytes of a frame's buffer, and of the memory
_LINE, _LINES = sum(_MODE.horizontal), sum(_MODE.vertical)
_CHOICES = (None, 1, 1, 14, 0, 3, 3, 2)     # buffers with the newest frame, by claim


def make():
    """The scan-out, anew."""
    return ScanOut(_MODE, _WIDTH, _HEIGHT, pixel_bytes=3, depth=64, max_burst=8)


@cache
def content():
    """Random bytes of the memory."""
    return np.random.default_rng(1).integers(1, 256, _BYTES, np.uint8)


def frame_of(claim):
    """Pixels of the frame of a claim, blue first; black without one."""
    choice = _CHOICES[claim]
    if choice is None:
        return np.zeros((_HEIGHT, _WIDTH, 3), np.uint8)
    at, size = choice * _BUFFER + 148 * claim % 400, 3 * _WIDTH * _HEIGHT
    return content()[at:at + size].reshape(_HEIGHT, _WIDTH, 3)


def screens_of(verilog, transcripts, **settings):
    """What the screen shows, as an array (pictures, lines, pixels, 4), and numbers of the bench."""
    sources = [("scan_out.v", verilog), ("screen_bench.v", (HDL / "screen_bench.v").read_text()),
               *((name, hdl_text(name)) for name in (
                   "avalon_memory.v", "dram_timing.v", "avalon_checker.v", "digest.v"))]
    program = build_bench("screen", "screen_bench", sources)
    pixels = _LINE * _LINES * (len(_CHOICES) + 1) + 1
    choices = "".join("f" if one is None else f"{one:x}" for one in reversed(_CHOICES))
    plusargs = {"choices": choices, "pixels": pixels, "wait_probability": 60, "latency_min": 2,
                "latency_max": 20} | settings
    results = {}

    def take(line):
        kind, *values = line.split() or [""]
        if kind == "RESULT":
            results[values[0]] = int(values[1])
        elif kind == "AVALON-ERROR":
            raise SimulationError(line)

    written = transcribed(
        [*command_of(program), *(f"+{key}={value}" for key, value in plusargs.items())], take,
        transcripts, files={"content.bin": content().tobytes()}, writes=["screen.bin"])
    seen = np.frombuffer(written["screen.bin"], np.uint8)
    assert seen.size == 4 * pixels and results["errors"] == 0, results
    # A pixel is at the output a clock after the beam is at it.
    return seen[4:].reshape(-1, _LINES, _LINE, 4), results


def check_beam(screens):
    """The sync pulses are the mode's, and all around the frame is black; the frame's part."""
    at, line = np.arange(_LINE), np.arange(_LINES)[:, None]
    (width, front, pulse, _), (height, below, lines, _) = _MODE.horizontal, _MODE.vertical
    flags = ((at < width) & (line < height)) + 2 * ((at >= width + front)
                                                   & (at < width + front + pulse)
                                                   & (line >= 0))
    flags += 4 * ((line >= height + below) & (line < height + below + lines) & (at >= 0))
    assert (screens[..., 3] == flags).all()
    left, top = (width - _WIDTH) // 2, (height - _HEIGHT) // 2
    inner = screens[:, top:top + _HEIGHT, left:left + _WIDTH, :3]
    assert screens[..., :3].sum(dtype=np.int64) == inner.sum(dtype=np.int64)
    return inner


def newest(ratio, **settings):
    """The bench in which each picture is the newest frame; the pixel clock is ``ratio`` of the
    core's."""
    def bench(verilog, transcripts):
        period = 2 * round(5000 / ratio)
        screens, results = screens_of(verilog, transcripts, pixel_period=period, **settings)
        inner = check_beam(screens)
        assert not inner[0].any()
        for claim, picture in enumerate(inner[1:]):
            np.testing.assert_array_equal(picture, frame_of(claim))
        assert results["claims"] == len(_CHOICES) + 1
        assert results["shown"] == len(_CHOICES) - 1 and results["underruns"] == 0
    return bench


def starved(verilog, transcripts):
    """A memory that is too slow in one picture: its rest is black, the others are whole."""
    ratio = 1.9         # clocks of the core for a pixel: the next picture begins after so many
    starves = int(ratio * _LINE * _LINES) + 100
    for claim, commands in ((2, 30), (4, 45)):
        screens, results = screens_of(verilog, transcripts, starved=claim, commands=commands,
                                      starves=starves, pixel_period=int(10_000 * ratio))
        words = 8 * commands
        inner = check_beam(screens)
        for k, picture in enumerate(inner[1:]):
            right = frame_of(k)
            if k != claim:
                np.testing.assert_array_equal(picture, right)
                continue
            different = (picture != right).any(axis=2).ravel()
            good = int(different.argmax())
            assert good == 4 * words // 3 and not picture.reshape(-1, 3)[good:].any(), good
        assert results["underruns"] == 1


def starved_and_reset(verilog, transcripts):
    """A reset of all, or of the core alone, after a picture whose words came too late."""
    for whole in (1, 0):
        screens, results = screens_of(
            verilog, transcripts, starved=1, commands=30, starves=7_031, pixel_period=19_000,
            reset_at=4 * _LINE * _LINES, reset_clocks=8, reset_whole=whole)
        first = 0 if whole else 5       # picture that begins after the reset
        inner = check_beam(screens)[first:]
        for k, picture in enumerate(inner):
            claim = results["claims"] - 1 - len(inner) + k
            np.testing.assert_array_equal(picture, frame_of(claim) if claim >= 0 else 0)
        # The core alone counts the late picture again, whose event crosses the clocks anew.
        assert results["underruns"] == (0 if whole else 1), results


def restarted(verilog, transcripts):
    """A reset of the core alone, in the blanking before a picture, or in the midst of one.

    It is as short as the queue between the clocks allows: one clock of each. The picture is black
    from there on, but for a pixel whose word has left the queue; the next one is of a new frame.
    """
    ratio, clocks = .4, 4
    begin = (_MODE.vertical[0] - _HEIGHT) // 2 * _LINE      # of the lines that show the frame
    for at, before in ((3, -200), (4, -217), (5, 0), (3, 10 * _LINE)):
        screens, results = screens_of(
            verilog, transcripts, pixel_period=int(10_000 / ratio), reset_clocks=clocks,
            reset_at=at * _LINE * _LINES + begin + before)
        inner = check_beam(screens).reshape(-1, _WIDTH * _HEIGHT, 3)
        for k, picture in enumerate(inner[:at]):
            np.testing.assert_array_equal(picture, frame_of(k - 1).reshape(-1, 3) if k else 0)
        old = frame_of(at - 1).reshape(-1, 3)
        shown = int((inner[at] != old).any(axis=1).argmax())
        assert shown <= 2 + max(before, 0) // _LINE * _WIDTH and not inner[at, shown:].any()
        # The core may take the reset for the end of a picture, and claim a frame at once.
        due = len(inner) - at
        assert results["claims"] in (due, due + 1), results
        for k, picture in enumerate(inner[at + 1:]):
            claim = results["claims"] - due + k
            np.testing.assert_array_equal(picture, frame_of(claim).reshape(-1, 3))


DESIGN = Design("screen", _TOP, make, (
    PlayedBench("a quick screen", newest(.93)), PlayedBench("a slow screen", newest(.4)),
    PlayedBench("words too late", starved),
    PlayedBench("resets after words too late", starved_and_reset),
    PlayedBench("resets", newest(.3, resets=16, latency_max=300, wait_probability=120)),
    PlayedBench("resets of frames on the screen", newest(.93, resets=24)),
    PlayedBench("resets of the core alone", restarted)))
