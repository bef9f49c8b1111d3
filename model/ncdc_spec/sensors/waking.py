"""How long a sensor needs after power comes, before it may be talked to."""

from dataclasses import dataclass
from fractions import Fraction

__all__ = ["Waking", "wake_times"]

# What boards give at least, in us, whatever the sensor: supplies rise, and boards differ.
_MIN_RESET_US, _MIN_REST_US = 5_000, 40_000
_MARGIN = Fraction(23, 20)      # over what the data say


@dataclass(frozen=True)
class Waking:
    """Times before the first access over I2C, at least.

    Parameters
    ----------
    reset_us : int
        Microseconds for which the reset pin is low, with clock and supplies there.
    rest_us, rest_clocks : int
        From the end of the reset on: microseconds, and clocks of the external clock.
    source : str
    """
    reset_us: int
    rest_us: int
    rest_clocks: int
    source: str

    def rest_at(self, clock_hz):
        """Microseconds of the rest, a fraction, with an external clock of ``clock_hz``."""
        return max(Fraction(self.rest_us), Fraction(self.rest_clocks * 10**6, clock_hz))


def wake_times(waking, clock_hz):
    """(us of the reset, us of the rest) that a board gives a sensor: what it needs and a margin.

    Parameters
    ----------
    waking : Waking
    clock_hz : int
        The external clock that the board gives.
    """
    reset, rest = (-(-time * _MARGIN // 1) for time in (
        waking.reset_us, waking.rest_at(clock_hz)))
    return max(_MIN_RESET_US, int(reset)), max(_MIN_REST_US, int(rest))
