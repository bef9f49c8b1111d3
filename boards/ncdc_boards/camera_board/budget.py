"""What a board's memory carries: bytes per second, and whether a picture fits."""

from dataclasses import dataclass

from ncdc_boards.sdram.chips import clocks_of
from ncdc_boards.sdram.layouts import AddressMapping
from ncdc_boards.sdram.sequencer import Sequencer
from ncdc_hdl.video.modes import MODES
from ncdc_spec.errors import InputError
from ncdc_spec.frames import output_format
from ncdc_spec.hardware import LANES
from ncdc_spec.registers.system_values import memory_bytes

__all__ = ["Budget", "budget_of", "check_lanes", "check_memory", "screen_burst"]

# Share of the clocks with data, for chips with so many bits; docs/reference/sdram.md measures 84
# and 79 % of corrector, camera and video together.
_EFFICIENCY = {16: .8, 32: .75}
# In a round in which all hosts wait: turns of the screen, the writer and the corrector, words of
# the latter two, clocks that a change of host costs. In simulation a screen that ran dry had 54 %
# of the clocks of 16 bits. A read waits for the bursts written before it: the
# screen has no second turn before the writer's.
_TURNS, _WRITTEN, _READ, _CHANGE = (3, 2, 1), 16, 4, 14
_SENT = 16              # words that the packetiser reads at once, instead of the corrector
_SPARE = 1.05           # minimum ratio of available to needed clocks of the screen
_BURSTS = 32, 64        # words that the screen may read at once
_FETCHED = 1.3          # most bytes that the cache reads, per byte of the raw frame


@dataclass(frozen=True)
class Budget:
    """Bytes per second.

    Parameters
    ----------
    carried : float
        Bytes that the memory carries.
    screen, camera : float
        Bytes while a line is shown; bytes while the sensor sends.
    frame : float
        Bytes that the corrector moves for a frame; with a processor also those that it sends.
    frames_per_second : float
        Frame rate of the sensor.
    """
    carried: float
    screen: float
    camera: float
    frame: float
    frames_per_second: float

    @property
    def corrected_per_second(self):
        """Frames that the corrector has the memory for; those of the sensor at most."""
        return min(self.frames_per_second, (self.carried - self.screen - self.camera) / self.frame)


def screen_burst(board, mode, clocks, hardware, width, processor=False):
    """Words per burst with which no line of the screen is late while all hosts wait.

    Parameters
    ----------
    board : Board
    mode : VideoMode
    clocks : object
        The board's clocks, as its ``clock_plan`` gives them.
    hardware : Hardware
    width : int
        Pixels of a line of the picture.
    processor : bool
        The processor sends pictures, which it reads from the same memory.

    Raises
    ------
    InputError
        If a line comes late in any case.
    """
    words, needed, available = _screen_burst(board, mode, clocks, hardware, width, processor)
    if words is None:
        fit = [each.name for each in MODES if _fits(board, each, hardware, processor)]
        raise InputError(
            f"the screen needs {100 * needed:.0f} % of the clocks of the memory of {board.name} "
            f"for the mode {mode.name}, and can have {100 * available:.0f} %: pictures of the "
            f"modes {', '.join(fit)} fit")
    return words


def _fits(board, mode, hardware, processor):
    """Whether board and memory carry pictures that fill a mode."""
    try:
        clocks = board.clock_plan(mode, board.core_mhz)
    except InputError:
        return False
    return _screen_burst(board, mode, clocks, hardware, mode.size[0], processor)[0] is not None


def _screen_burst(board, mode, clocks, hardware, width, processor):
    """Words of a burst, or None; shares of the memory's clocks that it needs and can have."""
    beats = hardware.data_width // board.chip.data_bits         # clocks of a word
    line_clocks = sum(mode.horizontal) / clocks.pixel_mhz * clocks.core_mhz
    line_bytes = width * output_format(hardware.format).pixel_bytes
    needed = line_bytes / (board.chip.data_bits // 8) / line_clocks
    available = 0
    for words in _BURSTS:
        screen, written, read = (turns * beats * length for turns, length in zip(
            _TURNS, (words, _WRITTEN, _SENT if processor else _READ)))
        had = screen / (screen + written + read + sum(_TURNS) * _CHANGE) / _SPARE
        if not _leaves_refreshes(board, clocks, hardware.data_width, words):
            continue
        available = had
        if had >= needed:
            return words, needed, available
    return None, needed, available


def _leaves_refreshes(board, clocks, data_width, words):
    """Whether the controller takes bursts of so many words: a refresh waits for two of them."""
    try:
        Sequencer(AddressMapping(board.chip, data_width, words),
                  clocks_of(board.chip, 1e6 * clocks.core_mhz), tag_bits=1)
    except InputError:
        return False
    return True


def budget_of(design, setup):
    """The :class:`Budget` of a :class:`~ncdc_boards.camera_board.core.Design` and of its sensor's
    :class:`Setup`."""
    g, hardware = design.system.descriptor.geometry, design.system.hardware
    pixel = output_format(hardware.format).pixel_bytes
    raw = g.distorted_width * g.distorted_height
    return Budget(
        carried=_carried(design.board, design.core_hz),
        screen=_screen_bytes(design, pixel),
        camera=raw * setup.timing.frames_per_second,
        frame=_FETCHED * raw + (1 + design.processor) * pixel * g.corrected_width
        * g.corrected_height,
        frames_per_second=setup.timing.frames_per_second)


def _screen_bytes(design, pixel):
    """Bytes per second that the screen reads while a line is shown."""
    if design.mode is None:
        return 0
    line_s = sum(design.mode.horizontal) / (design.clocks.pixel_mhz * 1e6)
    return design.system.descriptor.geometry.corrected_width * pixel / line_s


def _carried(board, core_hz):
    """Bytes per second that the memory carries."""
    return core_hz * board.chip.data_bits / 8 * _EFFICIENCY[board.chip.data_bits]


def check_lanes(board, hardware, lanes):
    """:class:`InputError` if fewer pixels per clock already are all that the memory carries.

    Parameters: a board; hardware with a pixel per clock; the pixels per clock requested.
    """
    moved = board.core_mhz * 1e6 * (_FETCHED + output_format(hardware.format).pixel_bytes)
    carried = _carried(board, board.core_mhz * 1e6)
    # Twice as many help only if those move less than the memory carries.
    fits = max((n for n in LANES if n == 1 or n / 2 * moved <= carried), default=1)
    if lanes > fits:
        raise InputError(
            f"{lanes} pixels per clock are requested, {fits} at {board.core_mhz:g} MHz already "
            f"{'moves' if fits == 1 else 'move'} {fits * moved / 1e6:.0f} MB/s and the memory of "
            f"{board.name} carries {carried / 1e6:.0f} MB/s: {fits} fits")


def check_memory(design, setup):
    """The :class:`Budget`, or :class:`InputError` if memory or its bandwidth do not suffice.

    The corrector takes what screen and camera leave. A picture is rejected if it corrects less
    than a quarter of the sensor's frames, or fewer than five a second.
    """
    system, budget = design.system, budget_of(design, setup)
    there = design.board.memory_bytes
    needed = memory_bytes(system.descriptor, system.hardware, system.stores)
    if needed > there:
        share = (there / needed) ** .5
        g = system.descriptor.geometry
        raise InputError(
            f"the frames take {needed / 1e6:.1f} MB, the {design.board.name} has "
            f"{there / 1e6:.1f} MB: raw frames of {int(g.distorted_width * share)}x"
            f"{int(g.distorted_height * share)} fit")
    wanted = min(5, setup.timing.frames_per_second / 4)
    if budget.corrected_per_second < wanted:
        left = budget.carried - budget.screen - wanted * budget.frame
        what = (f"a camera of {max(0, left) / budget.camera * budget.frames_per_second:.1f} frames "
                f"per second fits" if left > 0 else "a smaller picture fits")
        raise InputError(
            f"screen and camera move {(budget.screen + budget.camera) / 1e6:.0f} MB/s, the "
            f"memory carries {budget.carried / 1e6:.0f} MB/s, and {wanted:.1f} corrected frames a "
            f"second need {wanted * budget.frame / 1e6:.0f} MB/s: {what}")
    return budget
