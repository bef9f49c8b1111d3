"""Points of raw frames by their green sites, and what red and blue show beside them."""

from dataclasses import asdict, replace

from ncdc_model.calibration.filters import filter_seen, lateral_colour, parts_of, shifts_of
from ncdc_spec.errors import InputError

__all__ = ["by_green"]


def by_green(photos, results, find):
    """``photos``, PhotoPoints, with the points of the green sites, and the lateral colour.

    A raw frame whose colour cast tells its filter, or whose file does, was searched on its green
    sites already. The sites of other pictures of one channel are compared: if some show the points
    elsewhere, it is a raw frame too, and searched again.

    Parameters
    ----------
    photos : list of PhotoPoints
    results : list of DetectionResult
        Of the same photos.
    find : callable
        PhotoPoints of a DetectionResult.

    Returns
    -------
    list of PhotoPoints
    dict or None
        ``pattern``, ``pattern_from``, ``points``, ``red_px``, ``red_error_px``, ``blue_px``,
        ``blue_error_px``: pixels in the picture's corner by which a colour lies farther out than
        green; None if no photo is a raw frame.
    """
    photos, results = list(photos), list(results)
    unknown = [k for k, result in enumerate(results) if result.may_be_raw and not result.pattern]
    pattern = filter_seen(_shifts(photos, results, unknown, parts_of())) if unknown else None
    for k in unknown if pattern else ():
        result = results[k].with_filter(pattern)
        try:
            photos[k] = replace(find(result), name=photos[k].name)
        except InputError as error:
            photos[k] = replace(photos[k], warnings=(*photos[k].warnings, (
                f"it is a raw frame, and its green sites alone do not show the target ({error}): "
                f"lateral colour moves its points")))
            continue
        finally:
            result.release()
        result.spacing, results[k] = results[k].spacing, result
    patterns = [result.pattern for result in results]
    known = next((name for name in patterns if name), None)
    if known is None:
        return photos, None
    raw = [k for k, name in enumerate(patterns) if name == known]
    found = lateral_colour(_shifts(photos, results, raw, parts_of(known)))
    if found is None:
        return photos, None
    return photos, {"pattern": known, "pattern_from": results[raw[0]].pattern_from, **{
        name if name == "points" else f"{name}_px": value for name, value in asdict(found).items()}}


def _shifts(photos, results, which, parts):
    """:class:`Shifts` of the photos with the numbers ``which``."""
    found = []
    for k in which:
        found.append(shifts_of(results[k].frame, photos[k], parts))
        results[k].release()
    return found
