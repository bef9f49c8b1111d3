"""From photos to numbered points: the target's name, and one photo after the other."""

from dataclasses import replace
from pathlib import Path

from ncdc_model.calibration.boards import find_any_chessboard, find_chessboard, find_circles
from ncdc_model.calibration.dots import find_dots
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.errors import InputError
from ncdc_model.geometry import MIN_SIZE

__all__ = ["MIN_DOTS", "detect_points", "parse_target"]

MIN_DOTS = 49          # dots that make ``auto`` take a photo for that of a dot page
_MAX_SIDE = 200        # columns or rows of a target


def parse_target(text):
    """(kind, columns, rows) of ``dots``, ``circles:CxR``, ``chessboard:CxR`` or ``auto``.

    Columns and rows are None for dots and auto. Raises :class:`InputError` for anything else.
    """
    kind, colon, size = text.partition(":")
    if kind in ("dots", "auto") and not colon:
        return kind, None, None
    parts = size.lower().split("x")
    if kind in ("circles", "chessboard") and len(parts) == 2 and all(p.isdecimal() for p in parts):
        columns, rows = map(int, parts)
        if not (3 <= columns <= _MAX_SIDE and 3 <= rows <= _MAX_SIDE):
            raise InputError(f"target {text!r} has {columns} columns and {rows} rows, the limits "
                             f"are 3 and {_MAX_SIDE}")
        return kind, columns, rows
    raise InputError(f"target is {text!r}, one of dots, circles:CxR, chessboard:CxR or auto is "
                     f"needed, as in chessboard:9x6")


def detect_points(images, target="auto"):
    """Points of the target on every one of ``images``, pairs (name, uint8 image).

    ``images`` may be an iterator. ``auto`` settles on the first photo that shows a dot page or
    else a chessboard. A photo without the whole target, or of another size than the first one,
    is left out with its reason.

    Raises
    ------
    InputError
        If ``target`` is not understood or no photo is usable.
    """
    kind, columns, rows = parse_target(target)
    size, photos, rejected = None, [], {}
    for name, image in images:
        shape = image.shape[1], image.shape[0]
        try:
            if min(shape) < MIN_SIZE:
                raise InputError(f"it is {shape[0]}x{shape[1]}, {MIN_SIZE} pixels on a side are "
                                 f"the limit")
            if size is not None and shape != size:
                raise InputError(f"it is {shape[0]}x{shape[1]}, the first photo is "
                                 f"{size[0]}x{size[1]}")
            if kind == "auto":
                kind, columns, rows = _recognise(image)
            found = _find(image, kind, columns, rows)
        except InputError as error:
            rejected[str(name)] = str(error)
            continue
        size = size or shape
        photos.append(replace(found, name=Path(name).name))
    if not photos:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in rejected.items())
        raise InputError(f"no photo shows the target ({reasons or 'no photo was given'})")
    return TargetPoints(target=kind, size=size, photos=tuple(photos), rejected_photos=rejected)


def _find(image, kind, columns, rows):
    if kind == "dots":
        return find_dots(image)
    return (find_circles if kind == "circles" else find_chessboard)(image, columns, rows)


def _recognise(image):
    """Kind, columns and rows of the target that ``image`` shows."""
    try:
        found = find_dots(image)
        # The dark squares of a chessboard form a lattice too, but a small one.
        if len(found.index) >= MIN_DOTS:
            return "dots", None, None
    except InputError:
        pass
    try:
        return "chessboard", *find_any_chessboard(image)
    except InputError:
        raise InputError(f"neither a page of at least {MIN_DOTS} dots nor a chessboard was "
                         f"found") from None
