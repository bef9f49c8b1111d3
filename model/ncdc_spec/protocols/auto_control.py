"""Automatic exposure, gain and white balance: one rule in integers, for every device.

The emulated device calls these functions. The firmware has the same rule in
``soc/ncdc_soc/firmware_source/auto.c`` with the constants of this module; a test compares both. The
rule looks at one frame, made with known settings, and says which settings the next frames have. A
rule that keeps the settings has settled.
"""

from dataclasses import dataclass

from ncdc_spec.white_balance import grey_world

__all__ = ["BALANCE_BAND", "BALANCE_DARK", "BAND", "CONTINUOUS", "GAIN_MIN", "LEVEL_SHIFT",
           "Limits", "MODES", "OFF", "ONCE", "SAMPLES", "STEP_FACTOR", "TARGET",
           "balanced", "exposed", "sample_positions"]

OFF, ONCE, CONTINUOUS = range(3)
MODES = ("Off", "Once", "Continuous")       # by their values

SAMPLES = 16            # groups of 2 x 2 raw samples along each side of a frame that are looked at
LEVEL_SHIFT = 6         # the sum of those samples, shifted right by this: their mean in 16ths

TARGET = 16 * 105       # mean level of raw samples that is aimed at, 16ths of a grey level
BAND = TARGET // 14     # a mean that is at most so far from it is not changed
STEP_FACTOR = 4         # exposure times gain changes by this factor at most, from frame to frame
GAIN_MIN = 8            # eighths: of less than 1, white would be grey

BALANCE_BAND = 128      # gains that differ by less than one part of this from the best ones stay
BALANCE_DARK = 8        # frames whose brightest colour has a lower mean are too dark to judge


@dataclass(frozen=True)
class Limits:
    """What the rule may change, and how far.

    Parameters
    ----------
    exposure, gain : bool
        Whether the rule controls the exposure, and the gain.
    lines : (int, int)
        Shortest exposure, in lines, at least 1, and longest one: that of a frame at the present
        frame rate.
    gain_max : int
        The sensor's largest gain, in eighths.
    """
    exposure: bool
    gain: bool
    lines: tuple
    gain_max: int


def sample_positions(size):
    """First columns, or rows, of the groups of 2 x 2 samples that are looked at.

    Parameters
    ----------
    size : int
        Width or height of the raw frame, at least 2.

    Returns
    -------
    list of int
        ``SAMPLES`` even numbers, spread evenly.
    """
    return [2 * ((2 * k + 1) * (size // 2) // (2 * SAMPLES)) for k in range(SAMPLES)]


def exposed(level, lines, gain, limits):
    """Exposure and gain of the next frames.

    Exposure times gain is brought to the value at which the mean would be ``TARGET``, within the
    limits and by ``STEP_FACTOR`` at most. If both are free, the exposure has its longest value
    before the gain is above ``GAIN_MIN``. Settings stay if the mean is within ``BAND``, or if the
    nearest settings that the sensor can have would hardly be nearer to the aim: so the rule does
    not alternate between two neighbours.

    Parameters
    ----------
    level : int
        Mean of the frame, 16ths of a grey level.
    lines, gain : int
        Settings of the frame: lines of exposure, eighths of gain.
    limits : Limits

    Returns
    -------
    tuple of int
        Lines and gain; those of the frame if the rule has settled.
    """
    if abs(level - TARGET) <= BAND or not (limits.exposure or limits.gain):
        return lines, gain
    total = lines * gain
    shortest, longest = limits.lines if limits.exposure else (lines, lines)
    least = shortest * (GAIN_MIN if limits.gain else gain)
    most = longest * (limits.gain_max if limits.gain else gain)
    level = max(level, 1)
    ideal = min(max((total * TARGET + level // 2) // level, least), most)
    found = _split(ideal, lines, gain, limits)
    if 4 * abs(found[0] * found[1] - ideal) > 3 * abs(total - ideal):
        return lines, gain
    return _split(min(max(ideal, total // STEP_FACTOR), total * STEP_FACTOR), lines, gain, limits)


def _split(total, lines, gain, limits):
    """Lines and gain whose product is nearly ``total``."""
    if limits.exposure:
        wanted = total // GAIN_MIN if limits.gain else (total + gain // 2) // gain
        lines = min(max(wanted, limits.lines[0]), limits.lines[1])
    if limits.gain:
        gain = min(max((total + lines // 2) // lines, GAIN_MIN), limits.gain_max)
    return lines, gain


def balanced(sums, pixels, gains):
    """Gains before interpolation of the next frames.

    Those of :func:`~ncdc_spec.white_balance.grey_world`, unless the present ones are
    within one part in ``BALANCE_BAND`` of them, or the frame is too dark.

    Parameters
    ----------
    sums : sequence of int
        Of red, green and blue, of so many ``pixels``, in a frame with the present gains.
    pixels : int
    gains : sequence of int
        Present gains before interpolation in 256ths.

    Returns
    -------
    tuple of int
        The new gains; the present ones if the rule has settled.
    """
    gains = tuple(gains)
    if max(sums) < BALANCE_DARK * pixels or not pixels:
        return gains
    best = grey_world(sums, gains)
    if all(abs(new - old) * BALANCE_BAND <= new for new, old in zip(best, gains)):
        return gains
    return best
