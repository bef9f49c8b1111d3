"""Points of raw frames by their green sites, and what red and blue show beside them."""

from dataclasses import replace

from ncdc_model.calibration.filters import filter_seen, lateral_colour, parts_of, shifts_of
from ncdc_spec.errors import InputError

__all__ = ["by_green"]


def by_green(photos, results, find):
    """``photos``, PhotoPoints, with the points of the green sites of raw frames, and the lateral
    colour.

    The sites of pictures of one channel are compared, if neither a file nor a colour cast tells the
    filter: if some show the points elsewhere, they are raw frames too. Where red or blue lies
    elsewhere than green, the points are searched for again on the green sites. Where they lie at
    the same places, all sites give the points of green, and less noise.

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
        ``pattern``, ``pattern_from``, ``points_of`` (green sites or all sites), ``points``,
        ``red_px``, ``red_error_px``, ``blue_px``, ``blue_error_px``: pixels in the picture's corner
        by which a colour lies farther out than green; None if no photo is a raw frame.
    """
    photos = list(photos)
    unknown = [k for k, result in enumerate(results) if result.may_be_raw and not result.filter]
    seen = filter_seen(_shifts(photos, results, unknown, parts_of())) if unknown else None
    filters = [seen if k in unknown else result.filter for k, result in enumerate(results)]
    known = next((name for name in filters if name), None)
    if known is None:
        return photos, None
    raw = [k for k, name in enumerate(filters) if name == known]
    found = lateral_colour(_shifts(photos, results, raw, parts_of(known)))
    again = [k for k in raw if not results[k].by_green] if found is None or found.moves else []
    for k in again:
        result = results[k].on_green(seen if k in unknown else None)
        try:
            photos[k] = replace(find(result), name=photos[k].name)
            results[k].spacing = result.spacing
        except InputError as error:
            photos[k] = replace(photos[k], warnings=(*photos[k].warnings, (
                f"it is a raw frame, and its green sites alone do not show the target ({error}): "
                f"lateral colour moves its points")))
        finally:
            result.release()
    if again:
        found = lateral_colour(_shifts(photos, results, raw, parts_of(known)))
    if found is None:
        return photos, None
    first = results[raw[0]]
    return photos, {
        "pattern": known, "pattern_from": first.filter_from if first.filter else
        "its lateral colour", "points_of": "green sites" if again or first.by_green else
        "all sites", "points": found.points, "red_px": found.red, "red_error_px": found.red_error,
        "blue_px": found.blue, "blue_error_px": found.blue_error}


def _shifts(photos, results, which, parts):
    """:class:`Shifts` of the photos with the numbers ``which``."""
    found = []
    for k in which:
        found.append(shifts_of(results[k].frame, photos[k], parts))
        results[k].release()
    return found
