"""The figures of a unit, and the limits that they are compared with."""

import math
from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["FAIL", "FIGURES", "LIMITS", "LOOK", "PASS", "VERDICTS", "Figure", "check_limits",
           "judge"]

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
        is compared with the magnitude.
    """
    name: str
    title: str
    unit: str
    digits: int
    low: str = ""
    high: str = ""

    def text(self, value):
        """``value`` with its unit; "-" for None."""
        if value is None:
            return "-"
        return self._with_unit(f"{value:z.{self.digits}f}")

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
    Figure("max_error_px", "largest error of the map", "px", 3, high="max_error"),
    Figure("mean_error_px", "mean error of the map", "px", 4),
    Figure("straightness_px", "bend of the target's lines", "px", 3, high="max_bend"),
    Figure("focal_px", "focal length", "px", 1, low="min_focal", high="max_focal"),
    Figure("axis_px", "distance of the axis from the middle", "px", 2, high="max_axis"),
    Figure("decentring_px", "decentring", "px", 2, high="max_decentring"),
    Figure("tilt_deg", "tilt of the sensor", "°", 2, high="max_tilt"),
    Figure("roll_deg", "roll", "°", 2, high="max_roll"),
    Figure("uneven_px", "unevenness", "px", 3, high="max_uneven"))

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
        Values by name of :data:`FIGURES`; None where nothing is known.
    warnings : sequence of str
        What is odd about the photos: such a unit needs a look.
    error : str
        Why there is no network; empty if there is one.
    limits : dict
        Like :data:`LIMITS`.
    """
    reasons = [error] if error else []
    causes = ["no network"] if error else []
    for figure in FIGURES:
        value = figures.get(figure.name)
        if value is None:
            continue
        low, high = limits.get(figure.low), limits.get(figure.high)
        if low is not None and not value >= low:
            causes.append(figure.title)
            reasons.append(f"{figure.title}: {figure.text(value)}, the minimum is "
                           f"{figure.limit(low)}")
        if high is not None and not abs(value) <= high:
            causes.append(figure.title)
            reasons.append(f"{figure.title}: {figure.text(value)}, the maximum is "
                           f"{figure.limit(high)}")
    if reasons:
        return FAIL, causes[0], reasons + list(warnings)
    return (LOOK, "warning", list(warnings)) if warnings else (PASS, "", [])
