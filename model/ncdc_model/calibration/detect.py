"""From photos to numbered points: the target's name, and one photo after the other."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ncdc_model.calibration.boards import find_any_chessboard, find_chessboard
from ncdc_model.calibration.charuco import find_any_charuco, find_charuco
from ncdc_model.calibration.dots import find_dots
from ncdc_model.calibration.grids import corners_touch, find_circles, find_grid
from ncdc_model.calibration.points import TARGETS, TargetPoints
from ncdc_model.calibration.smooth import MIN_POINTS, misfit
from ncdc_model.errors import InputError
from ncdc_model.geometry import MIN_SIZE

__all__ = ["MIN_DOTS", "detect_points", "parse_target"]

MIN_DOTS = 49          # dots that make ``auto`` take a photo for that of a dot page
_MAX_SIDE = 200        # columns or rows of a target
_WHOLE_GRID = 0.999    # of the rectangle's places filled: circles that are all of a grid
_SAME = 0.05           # pixels: two photos whose points differ by less are one photo
# Rows' distance over that of columns in a staggered grid: OpenCV's, and of equal distances between
# all neighbours, lines lying or standing.
_ASPECTS = (1.0, 3**0.5, 3**-0.5)
_ASPECT_PHOTOS = 4


def parse_target(text):
    """(kind, columns, rows) of ``dots``, ``KIND:CxR`` or ``auto``.

    Columns and rows are None for dots and auto. Raises :class:`InputError` for anything else.
    """
    kind, colon, size = text.partition(":")
    if kind in ("dots", "auto") and not colon:
        return kind, None, None
    parts = size.lower().split("x")
    if (kind in TARGETS and kind != "dots" and len(parts) == 2
            and all(p.isdecimal() for p in parts)):
        columns, rows = map(int, parts)
        if not (3 <= columns <= _MAX_SIDE and 3 <= rows <= _MAX_SIDE):
            raise InputError(f"target {text!r} has {columns} columns and {rows} rows, the limits "
                             f"are 3 and {_MAX_SIDE}")
        return kind, columns, rows
    raise InputError(f"target is {text!r}, one of dots, circles:CxR, acircles:CxR, chessboard:CxR, "
                     f"charuco:CxR or auto is needed, as in chessboard:9x6")


def detect_points(images, target="auto"):
    """Points of the target on every one of ``images``, pairs (name, uint8 image).

    ``images`` may be an iterator. ``auto`` settles on what the first photo shows that shows any
    target. A photo without the target, of another size than the first one, or with the very
    points of an earlier one, is left out with its reason; of a target that is seen in part, the
    part is used.

    Raises
    ------
    InputError
        If ``target`` is not understood or no photo is usable.
    """
    kind, columns, rows = parse_target(target)
    size, photos, rejected, seen = None, [], {}, set()
    for name, image in images:
        name = f"{name} (again)" if str(name) in seen else str(name)
        seen.add(name)
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
            twin = next((photo.name for photo in photos if _same(photo, found)), None)
            if twin:
                raise InputError(f"it shows the same as {twin}: points within {_SAME} pixels of "
                                 f"each other")
        except InputError as error:
            rejected[name] = str(error)
            continue
        size = size or shape
        photos.append(replace(found, name=Path(name).name))
    if not photos:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in rejected.items())
        raise InputError(f"no photo shows the target ({reasons or 'no photo was given'})")
    return TargetPoints(target=kind, size=size, photos=tuple(photos), rejected_photos=rejected,
                        aspect=_aspect(size, photos) if kind == "acircles" else 1.0)


def _find(image, kind, columns, rows):
    if kind == "dots":
        return find_dots(image)
    if kind in ("circles", "acircles"):
        return find_circles(image, columns, rows, kind == "acircles")
    return (find_charuco if kind == "charuco" else find_chessboard)(image, columns, rows)


def _recognise(image):
    """Kind, columns and rows of the target that ``image`` shows."""
    grid = find_grid(image)
    whole = grid is not None and grid.filled > _WHOLE_GRID
    columns, rows = np.ptp(grid.photo.index, axis=0) + 1 if whole else (0, 0)
    if grid is not None and not grid.staggered:
        page = _page(image)
        # A grid that goes on beyond the border is a page, however whole its rectangle is.
        if whole and min(columns, rows) >= 3 and (page is None or not page.cut.any()):
            return "circles", int(columns), int(rows)
        # The dark squares of a chessboard form a lattice too, but a small one.
        if page is not None and len(page.index) >= MIN_DOTS:
            return "dots", None, None
    round_ones = whole and grid.staggered and not corners_touch(image, grid)
    for kind, find in (("charuco", find_any_charuco), ("chessboard", find_any_chessboard)):
        try:
            if not round_ones:
                return kind, *find(image)
        except InputError:
            pass
    if round_ones:
        if columns % 2:
            columns, rows = rows, columns
        if not columns % 2 and min(columns // 2, rows) >= 3:
            return "acircles", int(columns) // 2, int(rows)
    raise InputError(f"neither a whole grid of circles, a page of at least {MIN_DOTS} dots, a "
                     f"chessboard nor a ChArUco board was found")


def _page(image):
    """The dots that the picture shows, or None."""
    try:
        return find_dots(image)
    except InputError:
        return None


def _same(first, second):
    """Whether two photos' points are the same, apart from the noise of a copied file."""
    place = {tuple(key): point for key, point in zip(first.index.tolist(), first.xy)}
    common = [(place[tuple(key)], point) for key, point in zip(second.index.tolist(), second.xy)
              if tuple(key) in place]
    if len(common) < 0.9 * max(len(first.index), len(second.index)):
        return False
    a, b = np.array(common).swapaxes(0, 1)
    return bool(np.median(np.linalg.norm(a - b, axis=1)) < _SAME)


def _aspect(size, photos):
    """Distance of rows over that of columns that explains staggered circles best."""
    usable = [photo for photo in photos if len(photo.index) >= MIN_POINTS][:_ASPECT_PHOTOS]
    if not usable:
        return 1.0
    return min(_ASPECTS, key=lambda aspect: misfit(
        size, [(photo.index * (1.0, aspect), photo.xy) for photo in usable]))
