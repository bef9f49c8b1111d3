"""Checks of remap tables before anything is trained on them."""

import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["check_finite", "check_meaning", "check_smooth", "folded_warning", "sensor_warning"]

MIN_INSIDE = .1      # of the corrected pixels must have a source in the sensor
MIN_MIDDLE = .5      # the same, if the middle of the corrected picture has none
MIRRORED = .9          # of these have a negative area in a mirrored map
MIN_SMOOTH = .5        # of these must be connected and not fold back
SHRUNK = 1 / 16        # area in the sensor of a corrected pixel: less is a fourfold magnification
MAX_NOISE = .5        # pixels rms
SOME_NOISE = .05       # the same, for a warning
JUMP = 8               # times the usual step between neighbours


def check_finite(names, tables):
    """Raise :class:`InputError` if a table holds not-a-number, or one number only."""
    for name, table in zip(names, tables):
        bad = ~np.isfinite(table)
        if bad.any():
            row, column = np.argwhere(bad)[0]
            raise InputError(f"{name} has {bad.sum()} values that are not finite, the first in "
                             f"column {column}, row {row}; -1 is the mark of a pixel without a "
                             f"source")
        if table.min() == table.max():
            raise InputError(f"{name} is {table.flat[0]:g} everywhere")


def check_meaning(x, y, geometry):
    """Reject tables that hold no source pixels of a sensor of that size; the message says why.

    Raises
    ------
    InputError
        If they look like offsets, normalised coordinates, swapped or mirrored axes, or lie
        mostly outside the sensor.
    """
    inside, area = geometry.window_inside(x, y), _area(x, y)
    width, height = geometry.distorted
    other = _other_meaning(x, y, geometry)
    if other is not None:
        raise InputError(f"the tables hold {other}, source pixels 0 to {width - 1} and 0 to "
                         f"{height - 1} are needed")
    share = inside.mean()
    middle = inside[inside.shape[0] // 2, inside.shape[1] // 2]
    if share < (MIN_INSIDE if middle else MIN_MIDDLE):
        raise InputError(f"only {100 * share:.1f} % of the map's pixels have a source in a sensor "
                         f"of {width}x{height}{'' if middle else ', the middle has none'}; the "
                         f"tables reach from ({x.min():g}, {y.min():g}) to ({x.max():g}, "
                         f"{y.max():g})")
    for name, table in (("x", x), ("y", y)):
        if np.ptp(table[inside]) == 0:
            raise InputError(f"{name} is {table[inside][0]:g} at every pixel whose source lies in "
                             f"the sensor")
    if (area[inside] < 0).mean() > MIRRORED:
        across = np.abs(np.gradient(x, axis=0)[inside])
        along = np.abs(np.gradient(x, axis=1)[inside])
        raise InputError("the tables hold x and y swapped: the first grows from row to row" if
                         np.median(across) > np.median(along) else
                         "the map is mirrored, which NCDC does not correct")


def _other_meaning(x, y, geometry):
    """What the tables hold if that explains them and source pixels do not, else None."""
    width, height = geometry.distorted
    v, u = np.indices(x.shape)
    inside, share = geometry.window_inside(x, y).mean(), _regular(x, y, geometry)
    if share > .5:
        return None
    small = np.abs(np.median(_area(x, y))) < SHRUNK**2
    others = {"coordinates of 0 to 1": (x * (width - 1), y * (height - 1)),
              "coordinates of -1 to 1": ((x + 1) / 2 * (width - 1), (y + 1) / 2 * (height - 1))}
    # A real magnification has small steps too, but its sources lie in the sensor.
    if inside < .9 or small:
        others["offsets from the corrected pixel"] = x + u, y + v
    for meaning, (a, b) in others.items():
        if _regular(a, b, geometry) > max(.5, 2 * share):
            return meaning
    return None


def _regular(x, y, geometry):
    """Share of the pixels with a source in the sensor that is not greatly magnified."""
    return float((geometry.window_inside(x, y) & (_area(x, y) > SHRUNK)).mean())


def _area(x, y):
    """Area in the sensor of a corrected pixel, negative where the map is mirrored."""
    return (np.gradient(x, axis=1) * np.gradient(y, axis=0)
            - np.gradient(x, axis=0) * np.gradient(y, axis=1))


def check_smooth(x, y, inside, valid):
    """Reject a map that no smooth network can fit; return a warning, or None.

    ``inside``: pixels with a source in the sensor; ``valid``: those of them that
    :func:`ncdc_model.golden.valid.valid_mask` keeps.

    Raises
    ------
    InputError
        If the tables are rounded, noisy, folded or torn.
    """
    tables = x, y
    _check_steps(x, y, inside)
    noise = max(_noise(table, inside, axis) for table in tables for axis in (0, 1))
    if noise > MAX_NOISE:
        raise InputError(f"the map is not smooth: from pixel to pixel it scatters by {noise:.2f} "
                         f"px, {MAX_NOISE:g} is the limit")
    if valid.sum() < MIN_SMOOTH * inside.sum():
        raise InputError(f"the map is folded: of {inside.sum()} pixels whose source lies in the "
                         f"sensor, {valid.sum()} are connected and do not fold back, "
                         f"{100 * MIN_SMOOTH:.0f} % are the limit")
    _check_jumps(x, y, valid)
    if noise > SOME_NOISE:
        return (f"from pixel to pixel the map scatters by {noise:.2f} px, which no network "
                f"can fit: the largest error will be more than that")
    return None


def _check_steps(x, y, inside):
    if not any(_differences(table, inside, axis, 2).any() for table in (x, y) for axis in (0, 1)):
        return     # a plain shift may be one of whole pixels
    sources = np.stack([x[inside], y[inside]])
    if (sources == sources.round()).all():
        raise InputError("the tables hold whole pixels: they are rounded, by up to half a pixel, "
                         "so that no network can come nearer")
    largest = sources.max()
    if largest > 64 and (sources == sources.astype(np.float16)).all():
        raise InputError(f"the tables have been through 16-bit floats, whose steps at {largest:g} "
                         f"are {np.spacing(np.float16(largest)):g} px; float32 is needed")


def _differences(table, inside, axis, order):
    """Differences of that order along ``axis`` between pixels that are all ``inside``."""
    size = table.shape[axis] - order
    whole = np.logical_and.reduce([np.take(inside, range(k, k + size), axis)
                                   for k in range(order + 1)])
    return np.diff(table, order, axis)[whole]


def _noise(table, inside, axis):
    """Scatter of single values in pixels rms: robust, without the smooth part."""
    third = _differences(table, inside, axis, 3)
    # Third differences of white noise have 1 + 9 + 9 + 1 times its variance.
    return 1.4826 * float(np.median(np.abs(third))) / 20**.5 if len(third) else 0.0


def _check_jumps(x, y, valid):
    for axis in (0, 1):
        size = valid.shape[axis] - 1
        both = np.take(valid, range(size), axis) & np.take(valid, range(1, size + 1), axis)
        step = np.where(both, np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis)), 0)
        if not both.any():
            continue
        row, column = np.unravel_index(step.argmax(), step.shape)
        limit = JUMP * max(1.0, float(np.median(step[both])))
        if step[row, column] > limit:
            second = (column, row + 1) if axis == 0 else (column + 1, row)
            raise InputError(f"the map is torn: between the corrected pixels ({column}, {row}) and "
                             f"({second[0]}, {second[1]}) the source jumps by "
                             f"{step[row, column]:.1f} px, {limit:.1f} is the limit")


def folded_warning(inside, valid):
    """A sentence on pixels whose source lies in the sensor and that are left blank, or None."""
    lost = int(inside.sum() - valid.sum())
    if not lost:
        return None
    return (f"{lost} pixels have a source in the sensor and are left blank, because the map folds "
            f"back there or they are cut off from its middle")


def sensor_warning(x, y, inside, geometry):
    """A sentence if much of the map continues beyond the sensor: its size may be wrong."""
    beyond = ~inside
    # Pixels that are marked as without a source all have the same value.
    same = np.zeros(x.shape, bool)
    same[:, 1:] = (np.diff(x, axis=1) == 0) & (np.diff(y, axis=1) == 0)
    same[:, :-1] |= same[:, 1:]
    share = float((beyond & ~same).mean())
    if share < .1:
        return None
    width, height = geometry.distorted
    return (f"{100 * share:.1f} % of the map's pixels have a source beyond a sensor of "
            f"{width}x{height}; is that its size?")
