"""Checks of what is asked of a sensor, and the lines and factors that it gives."""

from fractions import Fraction
from math import log10

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.sensor import UNITY_GAIN, Settings

__all__ = ["check_window", "exposure_lines", "factor_of", "frame_lines", "pattern_mode", "resolved"]


def resolved(sensor, settings):
    """``settings`` with what their zeros stand for; raises :class:`InputError` if a clock or the
    window is out of the sensor's limits."""
    _check_reduction(sensor, settings)
    given = vars(settings) | {
        "width": settings.width or _samples(sensor, sensor.columns - settings.left, settings.skip),
        "height": settings.height or _samples(sensor, sensor.rows - settings.top, settings.skip),
        "clock_hz": settings.clock_hz or sensor.clock_hz,
        "pixel_clock_hz": settings.pixel_clock_hz or sensor.pixel_clock_hz}
    settings = Settings(**given)
    if not 0 < settings.pixel_clock_hz <= sensor.limits.pixel_clock_hz:
        raise InputError(f"the pixel clock is {settings.pixel_clock_hz} Hz, the {sensor.name} has "
                         f"at most {sensor.limits.pixel_clock_hz} Hz")
    if settings.lane_hz and not sensor.lanes:
        raise InputError(f"the lanes have {settings.lane_hz} bits per second, the {sensor.name} "
                         "has a parallel port")
    check_window(sensor, settings)
    return settings


def _samples(sensor, active, skip):
    """Samples sent of ``active`` columns: of whole groups, if the sensor reduces."""
    step = max(sensor.limits.step, 2 if skip > 1 else 1)
    return active // skip // step * step


def _check_reduction(sensor, settings):
    """Raises :class:`InputError` unless ``sensor`` can skip and bin so."""
    known = ((1, 1), *sensor.limits.reductions)
    if (settings.skip, settings.bins) not in known:
        pairs = ", ".join(f"{skip} and {bins}" for skip, bins in known)
        raise InputError(f"skip is {settings.skip} and bins {settings.bins}, the {sensor.name} has "
                         f"{pairs}")
    if settings.skip > 1 and (settings.mirror_columns or settings.mirror_rows):
        raise InputError(f"skip is {settings.skip}, the {sensor.name} mirrors unreduced frames "
                         "only: data sheets leave open which pixels a reduced one has")


def check_window(sensor, settings):
    """Raises :class:`InputError` unless the window is one that ``sensor`` can read."""
    limits, skip = sensor.limits, settings.skip
    even = 2 if skip > 1 else 1                 # whole groups
    for name, value, step, low, high in (
            ("left", settings.left, limits.corner_step, 0, sensor.columns),
            ("top", settings.top, limits.corner_step, 0, sensor.rows),
            ("width", settings.width, max(even, limits.step), limits.smallest[0],
             sensor.columns // skip),
            ("height", settings.height, max(even, limits.step), limits.smallest[1],
             sensor.rows // skip)):
        if value != int(value) or value % step or not low <= value <= high:
            multiple = f"a multiple of {step} from" if step > 1 else "an integer from"
            raise InputError(f"{name} is {value}, the {sensor.name} needs {multiple} {low} to "
                             f"{high}")
    for name, begin, size, all_ in (("columns", settings.left, settings.width, sensor.columns),
                                    ("rows", settings.top, settings.height, sensor.rows)):
        end = begin + skip * size
        if end > all_:
            raise InputError(f"the window has the {name} {begin} to {end - 1}, the {sensor.name} "
                             f"has {all_}")
    for name, begin, first in (("left", settings.left, sensor.first[0]),
                               ("top", settings.top, sensor.first[1])):
        group = 2 * settings.bins
        if settings.bins > 1 and (first + begin) % group:
            below = begin - (first + begin) % group
            fits = " or ".join(str(one) for one in (below, below + group) if one >= 0)
            raise InputError(f"{name} is {begin}, the {sensor.name} bins from a multiple of "
                             f"{group} on: {fits} fits")


def exposure_lines(sensor, settings, line_clocks, overhead):
    """Lines, nearest to the exposure asked for; lines * ``line_clocks`` - ``overhead`` clocks are
    exposed. Raises :class:`InputError` if it is not between the shortest and the longest."""
    low, high = sensor.limits.lines
    clock = settings.pixel_clock_hz
    shortest, longest = ((lines * line_clocks - overhead) * 1e6 / clock for lines in (low, high))
    if not shortest * (1 - 1e-9) <= settings.exposure_us <= longest * (1 + 1e-9):
        raise InputError(f"the exposure is {settings.exposure_us:g} us, the {sensor.name} exposes "
                         f"{shortest:.1f} to {longest:.0f} us with lines of "
                         f"{1e6 * line_clocks / clock:.2f} us")
    wanted = Fraction(settings.exposure_us) * clock / 10**6
    return min(high, max(low, round((wanted + overhead) / line_clocks)))


def frame_lines(sensor, settings, line_clocks, least):
    """Lines of a frame, ``least`` or those nearest to the frame rate asked for.

    Raises :class:`InputError` if that needs fewer or more than the sensor has.
    """
    low, high = (settings.height + extra for extra in sensor.limits.vertical)
    least = max(low, least)
    rate = settings.frames_per_second
    if not rate:
        return least
    clock, high = settings.pixel_clock_hz, max(min(high, sensor.limits.frame_lines), least)
    lines = high + 1
    if 0 < rate < clock:
        lines = round(Fraction(clock) / (Fraction(rate) * line_clocks))
    if not least <= lines <= high:
        fastest, slowest = (clock / (line_clocks * end) for end in (least, high))
        raise InputError(f"{rate:g} frames per second are asked for, the {sensor.name} sends "
                         f"{slowest:.3f} to {fastest:.3f} of {settings.width}x{settings.height} "
                         f"with this exposure")
    return lines


def factor_of(sensor, settings):
    """The gain asked for as a factor; raises :class:`InputError` outside of the limits."""
    low, high = (end / UNITY_GAIN for end in sensor.limits.gain_256)
    lowest, highest = 20 * log10(low), 20 * log10(high)
    if not lowest - 1e-9 <= settings.gain_db <= highest + 1e-9:
        raise InputError(f"the gain is {settings.gain_db:g} dB, the {sensor.name} has "
                         f"{lowest:.1f} to {highest:.1f} dB")
    return min(high, max(low, 10 ** (settings.gain_db / 20)))


def pattern_mode(sensor, settings):
    """Value of the test pattern for the sensor's register, None for "Off"; raises
    :class:`InputError` if it has no such pattern."""
    if settings.test_pattern == "Off":
        return None
    if settings.test_pattern not in sensor.test_patterns:
        known = ", ".join(("Off", *sensor.test_patterns))
        raise InputError(f"the test pattern is {settings.test_pattern!r}, the {sensor.name} has "
                         f"{known} in its raw frames")
    return sensor.test_patterns[settings.test_pattern]
