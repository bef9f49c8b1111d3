"""A test pattern in block RAM that stands for the sensor, for a board without a camera."""

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import Out

from ncdc_hdl.camera.layouts import PINS
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.framing import Crop
from ncdc_spec.sensors.level import SAMPLE_BITS
from ncdc_spec.sensors.sensor import Limits, Sensor, Settings, Setup, Timing
from ncdc_spec.sensors.waking import Waking

__all__ = ["CODE_BITS", "PATTERN", "PatternSensor", "check_pattern", "join_pattern",
           "pattern_samples", "pattern_sensor"]

PATTERN = "pattern"     # as the name of a sensor
CODE_BITS = 2           # of a sample in the memory
_STEP = ((1 << SAMPLE_BITS) - 1) // ((1 << CODE_BITS) - 1)      # from one code's sample to the next
_PACKED = 8             # codes in a word of the memory
_BLANK_CLOCKS, _BLANK_LINES = 160, 45       # between lines and frames, at least
_FRAMES_PER_SECOND = 25                     # at most


def check_pattern(board, geometry):
    """Raise :class:`InputError` unless a board has block RAM for the pattern of a raw frame."""
    needed = CODE_BITS * geometry.distorted_width * geometry.distorted_height
    if not board.pattern_bits:
        raise InputError(f"the sensor {PATTERN} is not supported on the {board.name}: the ulx3s "
                         "has it")
    if needed > board.pattern_bits:
        raise InputError(f"the pattern takes {needed} bits of block RAM, the {board.name} has "
                         f"{board.pattern_bits} for it: raw frames of "
                         f"{board.pattern_bits // CODE_BITS} pixels fit")


def pattern_samples(codes):
    """Samples of 12 bits that stand for ``codes``, integers of 0 to 3."""
    return np.asarray(codes, np.uint16) * _STEP


def pattern_sensor(geometry, clock_hz, frames_per_second=_FRAMES_PER_SECOND):
    """(:class:`Setup`, :class:`Crop`) of a :class:`PatternSensor` whose frames are raw frames of
    ``geometry``, at a pixel clock of ``clock_hz``. It has no registers."""
    width, height = geometry.distorted
    line_clocks = width + _BLANK_CLOCKS
    lines = max(height + _BLANK_LINES, -(-clock_hz // (line_clocks * frames_per_second)))
    sensor = Sensor(
        PATTERN, "Test pattern in block RAM", i2c_address=0, pointer_bits=8, value_bits=8,
        chip_id=(), columns=width, rows=height, bits=SAMPLE_BITS, bayer=geometry.bayer,
        mirror_keeps_bayer=False, black=0, clock_hz=clock_hz, pixel_clock_hz=clock_hz,
        limits=Limits(1, 1, (width, height), (1, 1), (_BLANK_LINES, lines - height), (256, 256),
                      clock_hz, lines),
        waking=Waking(0, 0, 0, "none is needed"))
    settings = Settings(width, height, clock_hz=clock_hz, pixel_clock_hz=clock_hz)
    return (Setup(sensor, settings, (), Timing(width, height, line_clocks, lines, clock_hz),
                  exposure_clocks=0, gain_256=256), Crop(0, 0))


class PatternSensor(wiring.Component):
    """Sends the same raw frame again and again, as a parallel sensor does.

    Timing: free-running in ``sync``; rows and columns are counted from the first clock on.

    Parameters
    ----------
    codes : array of integers of 0 to 3, shape (height, width)
        See :func:`pattern_samples`.
    timing : Timing

    Members
    -------
    pins : ``Out(PINS)``
    """

    latency = 3
    """Clocks from the counters to the pins: the memory, its output register, the sample."""

    def __init__(self, codes, timing):
        self.codes, self.timing = np.asarray(codes, np.uint8), timing
        super().__init__({"pins": Out(PINS)})

    def _words(self):
        """The codes, the first one in the lowest bits of a word."""
        codes = self.codes.ravel()
        codes = np.pad(codes, (0, -codes.size % _PACKED)).reshape(-1, _PACKED).astype(np.int64)
        return (codes << CODE_BITS * np.arange(_PACKED)).sum(axis=1).tolist()

    def elaborate(self, platform):
        m = Module()
        timing, words = self.timing, self._words()
        x, y = Signal(range(timing.line_clocks)), Signal(range(timing.frame_lines))
        at = Signal(range(_PACKED * len(words)))        # number of the sample in the frame
        frame, line = Signal(), Signal()
        m.d.comb += [frame.eq(y < timing.height), line.eq(frame & (x < timing.width))]
        m.d.sync += [x.eq(x + 1), at.eq(Mux(frame, at + line, 0))]
        with m.If(x == timing.line_clocks - 1):
            m.d.sync += [x.eq(0), y.eq(Mux(y == timing.frame_lines - 1, 0, y + 1))]
        m.submodules.memory = memory = Memory(shape=CODE_BITS * _PACKED, depth=len(words),
                                              init=words)
        read = memory.read_port()
        low = (_PACKED - 1).bit_length()
        m.d.comb += read.addr.eq(at[low:])
        word = register(m, "word", read.data)
        code = word.word_select(delay(m, at[:low], 2, "at"), CODE_BITS)
        m.d.sync += [
            self.pins.frame_valid.eq(delay(m, frame, 2, "frame", reset_less=False)),
            self.pins.line_valid.eq(delay(m, line, 2, "line", reset_less=False)),
            self.pins.data.eq(code * _STEP)]
        return m


def join_pattern(m, core, pattern, domain):
    """Connect a :class:`PatternSensor` in a clock ``domain`` to a board's core; the I2C bus, which
    has no target, is pulled up."""
    m.submodules.pattern = DomainRenamer(domain)(pattern)
    m.d.comb += [
        core.sensor_clock.eq(ClockSignal(domain)),
        core.sensor.frame_valid.eq(pattern.pins.frame_valid),
        core.sensor.line_valid.eq(pattern.pins.line_valid),
        core.sensor.data.eq(pattern.pins.data),
        core.scl.eq(~core.scl_low), core.sda.eq(~core.sda_low)]
