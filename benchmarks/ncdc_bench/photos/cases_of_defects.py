"""Photos whose every point may be found, and that still do not say what the lens is.

The page is bent, of two sheets, out of focus in part, or scanned by a rolling shutter. Or the photo
is vignetted, compressed, inverted, of a screen, oblique or close. The expectations were written as
in :mod:`ncdc_bench.photos.cases`, before detection was first run on these photos.
"""

from dataclasses import replace

import numpy as np

from ncdc_bench.photos import spoil
from ncdc_bench.photos.case import EITHER, USE, case
from ncdc_bench.photos.targets import Pose

__all__ = ["DEFECTS"]

_SIZE = 1024, 768
_VIEW = 0.42           # focal length in widths
_NOT_FLAT = "flat|bent|uneven"


def _seen(bank, kind, columns, rows, pose, clutter=True, **more):
    return bank.render(("chessboard" if kind == "board" else kind, columns, rows, pose),
                       clutter=clutter, size=_SIZE, **more)


_FULL = {"dots": (25, 19, Pose((0.05, 0.0), 0.1, 4.0, (9.0, -7.0))),
         "circles": (9, 7, Pose((0.0, 0.05), 0.2, -5.0, (-8.0, 7.0))),
         "board": (11, 8, Pose((0.0, 0.0), 0.21, 3.0, (6.0, 8.0))),
         "charuco": (9, 7, Pose((0.0, 0.0), 0.21, 3.0, (6.0, 8.0)))}


def _full(bank, kind, page=None, **more):
    """A target of ``kind`` that nearly fills a small picture; ``page``: changes of its pose."""
    columns, rows, pose = _FULL[kind]
    return _seen(bank, kind, columns, rows, replace(pose, **(page or {})), False, **more)


def _sheets(kind, *shifts, axis=0):
    """Two sheets, what is right of or below the middle moved by each of ``shifts``, pixels."""
    columns, rows, pose = _FULL[kind]
    line = (columns, rows)[axis] // 2

    def make(bank, shift):
        steps = np.array(shift) / (_VIEW * _SIZE[0] * pose.step)
        return _full(bank, kind, {"sheets": (axis, line, steps)})
    return [case(f"{kind}, two sheets, {('right', 'lower')[axis]} one by {shift} px", EITHER,
                 lambda b, shift=shift: make(b, shift), word="sheet|step|apart")
            for shift in shifts]


def _each(name, strengths, degraded, kinds=("dots", "circles", "board"), word=""):
    """A case for each kind of target and each of ``strengths``, pairs (expectation, value).

    ``degraded(photo, value)`` returns the clean photo with the defect.
    """
    return [case(f"{kind}, {name} {value}", expect,
                 lambda b, kind=kind, value=value: degraded(_full(b, kind), value), word=word)
            for kind in kinds for expect, value in strengths]


def _bent(kind, *bends):
    return [case(f"{kind}, round a cylinder, {bend:g} a step", EITHER,
                 lambda b, bend=bend: _full(b, kind, {"bend": bend}), word=_NOT_FLAT)
            for bend in bends]


def _rolling(kind, name, shift):
    return case(f"{kind}, rolling shutter, {name}", EITHER,
                lambda b: _full(b, kind, shutter=shift), word=_NOT_FLAT)


def _steep(kind, expect, tilts, columns, rows, step):
    return case(f"{kind}, from {max(tilts):g} degrees aside, {'xy'[tilts[0] == 0]}", expect,
                lambda b: _seen(b, kind, columns, rows, Pose((0.0, 0.0), step, 3.0, tilts)))


def _near(kind, columns, rows, step):
    return case(f"{kind}, {columns}x{rows}, steps of {round(_VIEW * _SIZE[0] * step)} px", USE,
                lambda b: _seen(b, kind, columns, rows, Pose((0.0, 0.0), step, 4.0, (6.0, -5.0))))


DEFECTS = [
    *_bent("dots", 0.01, 0.03, -0.02, -0.06), *_bent("circles", 0.05, -0.1),
    *_bent("board", 0.04, 0.1, -0.06),
    *[made for kind in ("dots", "circles", "board")
      for made in _sheets(kind, (0, 5), (3, -2), (9, 4))],
    *_sheets("dots", (4, 3), axis=1), *_sheets("board", (4, 3), axis=1),
    *_each("partly blurred, px:", [(USE, 4), (EITHER, 9)],
           lambda photo, sigma: spoil.part_focus(photo, sigma, 5.0, 0.58),
           ("dots", "circles", "board", "charuco"), "focus"),
    *_each("partly blurred from below, px:", [(EITHER, 7)],
           lambda photo, sigma: spoil.part_focus(photo, sigma, 93.0), ("dots", "board"), "focus"),
    *_each("vignetted to", [(USE, 0.2), (EITHER, 0.04)], spoil.vignette),
    *_each("JPEG", [(USE, 10), (USE, 20)], spoil.compress,
           ("dots", "circles", "board", "charuco")),
    *_each("moire of", [(USE, 0.2), (EITHER, 0.5)], spoil.moire),
    *[case(f"{kind}, white on black, rendered", USE,
           lambda b, kind=kind: spoil.invert(_full(b, kind)))
      for kind in ("dots", "circles", "board", "charuco")],
    case("hexagonal, white on black", USE, lambda b: spoil.invert(b.real("hexagonal"))),
    case("dots, white on black, a hand", USE, lambda b: spoil.cover(
        spoil.invert(_full(b, "dots")), [(1.0, 0.3), (0.7, 0.4), (0.6, 0.5), (0.7, 0.6),
                                         (1.0, 0.7)])),
    *[_rolling(kind, *shift) for kind in ("dots", "board") for shift in (
        ("skewed by 30 px", lambda part: 30 * (part - 0.5)),
        ("waving by 3 px", lambda part: 3 * np.sin(9 * part)))],
    _steep("dots", USE, (63.0, 0.0), 25, 18, 0.05),
    _steep("dots", EITHER, (0.0, 72.0), 25, 18, 0.06),
    _steep("circles", USE, (0.0, 62.0), 9, 7, 0.14),
    _steep("board", USE, (62.0, 0.0), 8, 6, 0.16),
    _steep("board", USE, (0.0, 66.0), 8, 6, 0.16),
    _steep("board", EITHER, (0.0, 72.0), 8, 6, 0.16),
    _near("board", 5, 4, 0.38), _near("board", 4, 3, 0.6), _near("board", 4, 4, 0.4),
    _near("circles", 5, 4, 0.38), _near("circles", 4, 3, 0.5), _near("dots", 9, 7, 0.36)]
