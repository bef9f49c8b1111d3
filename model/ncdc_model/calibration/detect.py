"""Numbered points of a target on one or more photos."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from ncdc_model.calibration.aprilgrid import SPACINGS
from ncdc_model.calibration.boards import board_of_size, grey_picture
from ncdc_model.calibration.detection_result import MIN_DOTS, DetectionResult
from ncdc_model.calibration.fiducials import other_board
from ncdc_model.calibration.green_sites import by_green
from ncdc_model.calibration.grids import grid_of_size
from ncdc_model.calibration.points import TARGETS, TargetPoints
from ncdc_model.calibration.smooth import MIN_POINTS, misfit
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MIN_SIZE

__all__ = ["MIN_DOTS", "detect_points", "parse_target", "stated_spacing"]

_MAX_SIDE = 200        # columns or rows of a target
_MAX_PHOTO = 32766     # pixels on a side: OpenCV samples no larger picture
_SAME = 0.05           # pixels: two photos whose points differ by less are one photo
# Rows' distance over that of columns in a staggered grid: OpenCV's, and of equal distances between
# all neighbours, lines lying or standing.
_ASPECTS = (1.0, 3**0.5, 3**-0.5)
_ASPECT_PHOTOS = 4


def parse_target(text):
    """(kind, columns, rows) of ``dots``, ``KIND:CxR``, ``aprilgrid:CxR:SPACING`` or ``auto``.

    Columns and rows are None for dots and auto. Raises :class:`InputError` for anything else.
    """
    kind, colon, size = text.partition(":")
    if kind in ("dots", "auto") and not colon:
        return kind, None, None
    if kind == "aprilgrid":
        stated_spacing(text)
        size = size.partition(":")[0]
    parts = size.lower().split("x")
    if (kind in TARGETS and kind != "dots" and len(parts) == 2
            and all(p.isdecimal() for p in parts)):
        columns, rows = map(int, parts)
        if not (3 <= columns <= _MAX_SIDE and 3 <= rows <= _MAX_SIDE):
            raise InputError(f"target {text!r} has {columns} columns and {rows} rows, the limits "
                             f"are 3 and {_MAX_SIDE}")
        return kind, columns, rows
    raise InputError(f"target is {text!r}, one of dots, circles:CxR, acircles:CxR, chessboard:CxR, "
                     f"charuco:CxR, aprilgrid:CxR or auto is needed, as in chessboard:9x6")


def stated_spacing(text):
    """Gap between tags, in sides of a tag, that a target ``aprilgrid:CxR:SPACING`` states; None if
    it states none. Raises :class:`InputError` if it is no such number."""
    kind, *parts = text.split(":")
    if kind != "aprilgrid" or len(parts) < 2:
        return None
    try:
        spacing = float(parts[1])
    except ValueError:
        spacing = float("nan")
    if len(parts) > 2 or not SPACINGS[0] <= spacing <= SPACINGS[1]:
        raise InputError(f"target {text!r} has the spacing {':'.join(parts[1:])!r}, a number from "
                         f"{SPACINGS[0]:g} to {SPACINGS[1]:g} is needed: the gap between two tags "
                         f"in sides of a tag, as in aprilgrid:6x6:0.3")
    return spacing


def detect_points(images, target="auto"):
    """Points of the target on every one of ``images``, pairs (name, uint8 image or Photo).

    ``images`` may be an iterator. The points of a raw frame are those of green. An image
    may be a function that returns it, which is called again when needed, so that only one photo is
    in memory. ``auto`` takes the kind and size of target that most photos show; a part counts as
    the whole target, and the part is used. A photo is rejected with its reason if it

    - does not show the target,
    - has another size in pixels than most,
    - has the same points as an earlier one, or
    - cannot be read: its function raises InputError. The error of a single photo is raised.

    Raises
    ------
    InputError
        If ``target`` is not understood or no photo is usable.
    """
    kind, columns, rows = parse_target(target)
    results, rejected = _results(images, kind, (columns, rows), stated_spacing(target))
    choice = ""
    if kind == "auto":
        kind, columns, rows, choice = _agreed(results, rejected)
    size = _common_size(results, rejected)
    photos, used = _photos_of(results, rejected, (kind, columns, rows))
    if not photos:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in rejected.items())
        raise InputError(f"no photo shows the target ({reasons or 'no photo was given'})")
    photos, colour = by_green(photos, used, lambda result: _found(result, kind, columns, rows))
    return TargetPoints(target=kind, size=size, photos=tuple(photos), rejected_photos=rejected,
                        aspect=_aspect(size, photos) if kind == "acircles" else 1.0, choice=choice,
                        target_size=None if columns is None else (columns, rows), colour=colour,
                        spacing=_spacing(used) if kind == "aprilgrid" else None)


def _photos_of(results, rejected, target):
    """PhotoPoints of the ``target``, (kind, columns, rows), of all usable photos, and the
    :class:`DetectionResult` of each; why others are not is added to ``rejected``."""
    photos, used = [], []
    for result in results:
        if result.name in rejected:
            continue
        try:
            try:
                found = _found(result, *target)
            except InputError:
                if not result.filter:
                    raise
                result = result.on_green()
                found = _found(result, *target)
            duplicate = next((photo.name for photo in photos if _same(photo, found)), None)
            if duplicate:
                raise InputError(f"it shows the same as {duplicate}: points within {_SAME} pixels "
                                 f"of each other")
        except InputError as error:
            rejected[result.name] = str(error)
            continue
        finally:
            result.release()
        photos.append(replace(found, name=Path(result.name).name))
        used.append(result)
    return photos, used


def _results(images, kind, target_size, spacing=None):
    """A :class:`DetectionResult` of each photo, and why some are rejected. With ``auto`` the target
    of each is recognised. ``target_size``, ``spacing``: its columns and rows, and the gap between
    the tags of an AprilGrid, if known."""
    results, rejected, seen, unread = [], {}, set(), []
    for name, image in images:
        name = f"{name} (again)" if str(name) in seen else str(name)
        seen.add(name)
        try:
            result = DetectionResult(name, image, target_size, spacing)
        except InputError as error:
            unread.append(error)
            rejected[name] = str(error)
            continue
        results.append(result)
        if min(result.size) < MIN_SIZE:
            rejected[name] = (f"it is {result.size[0]}x{result.size[1]}, {MIN_SIZE} pixels on a "
                              f"side are the limit")
        elif max(result.size) > _MAX_PHOTO:
            rejected[name] = (f"it is {result.size[0]}x{result.size[1]}, {_MAX_PHOTO} pixels on a "
                              f"side are the limit")
        else:
            result.prepare(kind)
    if unread and len(seen) == 1:
        raise unread[0]
    return results, rejected


def _common_size(results, rejected):
    """Width and height of most photos, of the first ones if as many have another; photos of other
    sizes are added to ``rejected``."""
    sizes = Counter(result.size for result in results if result.name not in rejected)
    if not sizes:
        return None
    size = sizes.most_common(1)[0][0]
    for result in results:
        if result.size != size and result.name not in rejected:
            most = "most photos are" if sizes[size] > 1 else "the first photo is"
            rejected[result.name] = (f"it is {result.size[0]}x{result.size[1]}, {most} "
                                   f"{size[0]}x{size[1]}")
    return size


def _agreed(results, rejected):
    """Kind, columns and rows that most photos show, and a sentence on how many do."""
    targets = {}
    for result in results:
        if result.name in rejected:
            continue
        if result.target is not None:
            targets[result.name] = result.target
    if not targets:
        rejected.update((result.name, result.doubt) for result in results
                        if result.name not in rejected)
        reasons = "; ".join(f"{name}: {reason}" for name, reason in rejected.items())
        raise InputError(f"no photo shows the target ({reasons or 'no photo was given'})")
    votes = Counter((found.kind, *sorted((found.columns or 0, found.rows or 0), reverse=True))
                    for found in targets.values())
    # The largest of sizes that as many photos show: a part of a target is no other target.
    winner = max(votes, key=lambda key: (votes[key], key[1] * key[2]))
    first = next(found for found in targets.values()
                 if (found.kind, *sorted((found.columns or 0, found.rows or 0), reverse=True))
                 == winner)
    name = first.kind if first.columns is None else f"{first.kind}:{first.columns}x{first.rows}"
    choice = f"{name}, which {votes[winner]} of {len(results)} photos show"
    for photo, found in targets.items():
        if found.kind != first.kind and not {found.kind, first.kind} <= {"dots", "circles"}:
            rejected[photo] = f"it shows {found}, most photos show {name}"
    return first.kind, first.columns, first.rows, choice


def _found(result, kind, columns, rows):
    """Points on one photo as PhotoPoints; the InputError names another board, if it shows one."""
    try:
        return _find(result, kind, columns, rows)
    except InputError as error:
        if result.doubt:
            raise InputError(result.doubt) from error
        raise InputError(other_board(grey_picture(result.image), kind)
                         or str(error)) from error


def _find(result, kind, columns, rows):
    if kind == "dots":
        return result.page
    if kind in ("circles", "acircles"):
        return grid_of_size(result.spots, columns, rows, kind == "acircles")
    if kind == "charuco":
        return result.charuco(columns, rows)
    if kind == "aprilgrid":
        return result.aprilgrid(columns, rows)
    return board_of_size(result.boards, columns, rows, lambda: result.image)


def _same(first, second):
    """Whether two photos' points are the same, apart from the noise of a copied file."""
    position = {tuple(key): point for key, point in zip(first.index.tolist(), first.xy)}
    common = [(position[tuple(key)], point) for key, point in zip(second.index.tolist(), second.xy)
              if tuple(key) in position]
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


def _spacing(used):
    """The spacing of an AprilGrid, the middle one of those that its used photos show."""
    return float(np.median([result.spacing for result in used]))
