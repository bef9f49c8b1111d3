"""The figures of a unit, and the limits that they are compared with."""

import math
from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["ERRORS", "FAIL", "FIGURES", "LIMITS", "LOOK", "PASS", "VERDICTS", "Figure",
           "check_limits", "judge"]

PASS, LOOK, FAIL = VERDICTS = "pass", "look", "fail"


@dataclass(frozen=True)
class Figure:
    """One number of every unit.

    Parameters
    ----------
    name : str
        Column of the database.
    title : str
        What it is, in words.
    unit : str
        Empty for a count.
    digits : int
        Digits after the point that are shown.
    low, high : str
        Options that set its limits, such as ``min_points``; empty for none. The limit ``high``
        is compared with the distance from ``middle``.
    error : str
        Column of its standard error; empty if it has none.
    magnitude : bool
        Whether it is never negative, and best at 0.
    middle : float
        Value of a perfect unit, from which ``high`` is counted.
    limit_title : str
        What ``high`` is a limit of, if not of the figure.
    """
    name: str
    title: str
    unit: str
    digits: int
    low: str = ""
    high: str = ""
    error: str = ""
    magnitude: bool = False
    middle: float = 0.0
    limit_title: str = ""

    def text(self, value, error=None):
        """``value`` with its unit, and its standard ``error`` if that is known; "-" for None."""
        if value is None or math.isnan(value):
            return "-"
        number = f"{value:z.{self.digits}f}"
        if error is not None and math.isfinite(error):
            # A small error has a digit that is not 0.
            digits = max(self.digits, min(6, -math.floor(math.log10(max(error, 1e-6)))))
            number += f" ± {error:.{digits}f}"
        return self._with_unit(number)

    def text_of(self, row):
        """The figure of a unit, a dict by name of column, with its error."""
        return self.text(row.get(self.name), row.get(self.error))

    def bounds(self, limits):
        """Smallest and largest value that ``limits``, a dict like :data:`LIMITS`, allow; None each
        without a limit. Of a magnitude only the largest."""
        low, high = limits.get(self.low), limits.get(self.high)
        if high is None or self.magnitude or self.low:
            return low, high
        return self.middle - high, self.middle + high

    def limit(self, value):
        """A limit as it was given, with its unit."""
        return self._with_unit(f"{value:g}")

    def _with_unit(self, number):
        return f"{number}{'' if self.unit in ('', '°') else ' '}{self.unit}"


FIGURES = (
    Figure("points", "points", "", 0, low="min_points"),
    Figure("photos_used", "photos used", "", 0, low="min_photos"),
    Figure("coverage_percent", "coverage", "%", 1, low="min_coverage"),
    Figure("neurons", "hidden neurons", "", 0),
    Figure("max_error_px", "largest error of the map", "px", 3, high="max_error", magnitude=True,
           limit_title="error of the map anywhere"),
    Figure("mean_error_px", "mean error of the map", "px", 4, magnitude=True),
    Figure("straightness_px", "bend of the target's lines", "px", 3, high="max_bend",
           magnitude=True),
    Figure("focal_px", "focal length", "px", 1, low="min_focal", high="max_focal",
           error="focal_px_error"),
    Figure("axis_px", "distance of the axis from the middle", "px", 2, high="max_axis",
           error="axis_px_error", magnitude=True),
    Figure("decentring_px", "decentring", "px", 2, high="max_decentring",
           error="decentring_px_error", magnitude=True),
    Figure("tilt_deg", "tilt of the sensor", "°", 2, high="max_tilt", error="tilt_deg_error",
           magnitude=True),
    Figure("roll_deg", "roll", "°", 2, high="max_roll", error="roll_deg_error"),
    Figure("aspect", "pixel aspect", "", 4, high="max_aspect", error="aspect_error", middle=1.0,
           limit_title="departure of the pixel aspect from 1"),
    Figure("uneven_px", "unevenness", "px", 3, high="max_uneven", magnitude=True),
    Figure("disagreement_px", "disagreement of the photos", "px", 3, magnitude=True),
    Figure("blur_ratio", "blur of one half over the other", "", 2))

ERRORS = tuple(figure.error for figure in FIGURES if figure.error)     # names of columns
_SURE = 2.0             # standard errors by which a figure has to be on one side of its limit

# Every limit, with its default; None: no limit, as what a product allows is its maker's to say.
LIMITS = {option: None for figure in FIGURES for option in (figure.low, figure.high) if option}
LIMITS |= {"min_points": 100, "min_photos": 1, "min_coverage": 80.0, "max_error": 0.5}


def check_limits(limits):
    """Raise :class:`InputError` for a limit in a dict like :data:`LIMITS` that no unit can meet."""
    for name, value in limits.items():
        if value is not None and not (math.isfinite(value) and value >= 0):
            raise InputError(f"--{name.replace('_', '-')} is {value:g}, 0 or more is needed")
    if limits["min_coverage"] > 100:
        raise InputError(f"--min-coverage is {limits['min_coverage']:g} %, the maximum is 100")
    low, high = limits["min_focal"], limits["max_focal"]
    if low is not None and high is not None and low > high:
        raise InputError(f"--min-focal is {low:g} px, more than --max-focal, {high:g} px")


def judge(figures, warnings, error, limits):
    """Verdict on a unit, its cause in a few words, and all reasons in words.

    Parameters
    ----------
    figures : dict
        Values by name of :data:`FIGURES`, and their errors; None for what the photos do not
        determine. What was not measured is missing.
    warnings : sequence of str
        What is odd about the photos: such a unit needs a look.
    error : str
        Why there is no network; empty if there is one.
    limits : dict
        Like :data:`LIMITS`.
    """
    failed = [("no network", error)] if error else []
    odd = []
    for figure in FIGURES:
        value, error = figures.get(figure.name), figures.get(figure.error)
        if value is None and not (figure.error and figure.name in figures):
            continue
        for verdict, reason in _compared(figure, value, error, limits):
            (failed if verdict == FAIL else odd).append((figure.title, reason))
    odd += [("warning", text) for text in warnings]
    reasons = [reason for _, reason in failed + odd]
    if not reasons:
        return PASS, "", []
    return (FAIL if failed else LOOK), (failed + odd)[0][0], reasons


def _compared(figure, value, error, limits):
    """Yield verdict and reason for each limit that ``value`` does not keep with certainty.

    A figure with a standard error keeps or violates a limit by two of them, else a person decides.
    """
    low, high = limits.get(figure.low), limits.get(figure.high)
    known = math.nan if value is None else value
    reach = 0.0 if not figure.error else math.nan if error is None else _SURE * error
    aside = f" from {figure.middle:g}" if figure.middle else ""
    for limit, above, word in ((low, None if low is None else low - known, "minimum"),
                               (high, None if high is None else abs(known - figure.middle) - high,
                                "maximum")):
        if limit is None or above + reach <= 0:
            continue
        text = f"{figure.title}: {figure.text(value, error)}"
        bound = f"the {word} is {figure.limit(limit)}{aside}"
        if not figure.error or above - reach > 0:
            yield FAIL, f"{text}, {bound}"
        elif math.isfinite(above + reach):
            yield LOOK, f"{text}, {bound}: not decided"
        else:
            yield LOOK, f"{text}, which the photos do not determine; {bound}: not decided"
