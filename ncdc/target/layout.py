"""Shapes of a calibration target on a sheet of paper, in millimetres."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.detect import parse_target, stated_spacing
from ncdc_model.calibration.tags import april_family
from ncdc_spec.errors import InputError

__all__ = ["KINDS", "PAPERS", "Circle", "Layout", "Rectangle", "layout_of", "paper_of"]

PAPERS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "Letter": (279.4, 215.9)}
"""Width and height of the sheets, lying, as a camera's picture does."""

_SIDES = 120.0, 3000.0      # of a sheet: the ruler of 100 mm has to fit
_STEPS = 1.0, 500.0         # between points
_MARGIN = 8.0               # most printers leave 5 mm white
_FOOT = 20.0                # for the ruler and the text, and what keeps them from the points
_DOTS_STEP = 10.0           # of a page of dots: 28 x 17 on A4
_DOT = 0.5                  # diameter of a circle over the distance to the nearest one
_MARKER = 0.75              # side of a marker over that of its square
_FAMILY = "DICT_4X4_1000"   # its first ones are those of DICT_4X4_50, _100 and _250
_SPACING = 0.3              # of an AprilGrid, Kalibr's: gap between two tags over the side of one
_BORDER, _TAG = 2, 10       # cells of a tag's black border, and of the tag in a row
_FEWEST = 3                 # columns or rows

KINDS = {"dots": None, "circles": (10, 7), "acircles": (4, 11), "chessboard": (9, 6),
         "charuco": (10, 7), "aprilgrid": (8, 5)}
"""Kinds of target, and columns and rows if they are not given; None: as many as fit."""


@dataclass(frozen=True)
class Circle:
    """A black disc, millimetres from the upper left corner of the sheet."""
    x: float
    y: float
    diameter: float


@dataclass(frozen=True)
class Rectangle:
    """A black rectangle, its upper left corner in millimetres from that of the sheet."""
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class Layout:
    """A target on its sheet.

    Parameters
    ----------
    paper : (float, float)
        Width and height of the sheet, millimetres.
    shapes : tuple of Circle and Rectangle
    target : str
        Value of ``ncdc calibrate --target``.
    points : int
        Points that are found on a whole picture of it.
    step : float
        Millimetres between neighbouring columns of points; of staggered circles twice that between
        neighbouring lines; of an AprilGrid the side of a tag.
    description : str
        Kind of target, with its sizes.
    """
    paper: tuple
    shapes: tuple
    target: str
    points: int
    step: float
    description: str

    @property
    def foot(self):
        """Upper and left edge of the area for ruler and text, millimetres."""
        return _MARGIN, self.paper[1] - _MARGIN - _FOOT


def paper_of(text):
    """(width, height) in millimetres of a sheet's name, or of WxHmm as in 400x300mm.

    Raises
    ------
    InputError
        If it is neither, or a side is outside the limits.
    """
    for name, size in PAPERS.items():
        if text.lower() == name.lower():
            return size
    try:
        width, height = map(float, text.lower().removesuffix("mm").split("x"))
    except ValueError:
        raise InputError(f"the paper is {text!r}, one of {', '.join(PAPERS)} or WxHmm, as in "
                         f"400x300mm, is needed") from None
    low, high = _SIDES
    if not all(low <= side <= high for side in (width, height)):
        raise InputError(f"the paper is {width:g}x{height:g} mm, the limits of a side are {low:g} "
                         f"and {high:g}")
    return width, height


def layout_of(kind, paper, step=None):
    """The :class:`Layout` of a target.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`, with columns and rows as ``ncdc calibrate --target`` counts them if
        wanted: ``chessboard:9x6``; after those of an AprilGrid its spacing: ``aprilgrid:6x6:0.3``.
    paper : (float, float)
        Width and height, millimetres.
    step : float, optional
        Millimetres between points; as many whole ones as fit, of ``dots`` 10.

    Raises
    ------
    InputError
        If the kind is unknown or the target does not fit.
    """
    name, columns, rows = _kind(kind)
    width, height = paper[0] - 2 * _MARGIN, paper[1] - 2 * _MARGIN - _FOOT
    if step is not None and not _STEPS[0] <= step <= _STEPS[1]:
        raise InputError(f"the step is {step:g} mm, the limits are {_STEPS[0]:g} and "
                         f"{_STEPS[1]:g}")
    if name == "dots":
        step = step or _DOTS_STEP
        columns, rows = (int((side - _DOT * step) / step) + 1 for side in (width, height))
    turned = name == "acircles" and _turned(columns, rows, width, height)
    spacing = stated_spacing(kind) or _SPACING
    across, down = _steps(name, columns, rows, spacing)[::-1 if turned else 1]
    fits = min(width / across, height / down)
    step = step or float(int(fits) or fits)
    if step > fits or min(columns, rows) < _FEWEST:
        raise InputError(f"{kind} with {step:g} mm between points does not fit on "
                         f"{paper[0]:g}x{paper[1]:g} mm: at most {fits:.3g} mm do")
    # In the middle of what is left above the foot.
    left = _MARGIN + (width - across * step) / 2
    top = _MARGIN + (height - down * step) / 2
    if name == "aprilgrid":
        shapes, points, description = _aprilgrid(columns, rows, step, spacing)
    else:
        make = {"chessboard": _chessboard, "charuco": _charuco}.get(name, _circles)
        shapes, points, description = make(name, columns, rows, step, turned)
    shapes = tuple(_moved(shape, left, top) for shape in shapes)
    target = name if name == "dots" else f"{name}:{columns}x{rows}"
    return Layout(paper, shapes, target + f":{spacing:g}" * (name == "aprilgrid"), points, step,
                  description)


def _kind(text):
    """(kind, columns, rows); those of dots are None."""
    name, colon, _ = text.partition(":")
    if name not in KINDS or colon and name == "dots":
        raise InputError(f"the target is {text!r}, one of {', '.join(KINDS)} is needed, with "
                         f"columns and rows if wanted, as in chessboard:9x6")
    if not colon:
        return name, *(KINDS[name] or (None, None))
    return parse_target(text)


def _steps(name, columns, rows, spacing=_SPACING):
    """Width and height of a target, in steps."""
    if name == "aprilgrid":
        return columns * (1 + spacing) + spacing, rows * (1 + spacing) + spacing
    if name == "chessboard":
        return columns + 1, rows + 1
    if name == "charuco":
        return columns, rows
    if name == "acircles":
        return columns - 0.5 + _STAGGERED_DOT, (rows - 1) / 2 + _STAGGERED_DOT
    return columns - 1 + _DOT, rows - 1 + _DOT


_STAGGERED_DOT = _DOT / 2**.5       # diameter over the step: neighbours lie diagonally


def _turned(columns, rows, width, height):
    """Whether lines of staggered circles stand, as then they can be larger."""
    across, down = _steps("acircles", columns, rows)
    return min(width / down, height / across) > min(width / across, height / down)


def _circles(name, columns, rows, step, turned):
    """Shapes, points and words of a grid of circles, from the corner of its own rectangle."""
    line, column = np.divmod(np.arange(rows * columns), columns)
    if name != "acircles":
        size, x, y = _DOT * step, column * step, line * step
        words = f"{columns} columns x {rows} rows of dots"
    else:
        size, x, y = _STAGGERED_DOT * step, (column + line % 2 / 2) * step, line * step / 2
        words = f"{rows} lines, {step / 2:g} mm apart, of {columns} circles"
        if turned:
            # A quarter turn, no mirror: of an even number of lines that is another target.
            x, y = y, (columns - 0.5) * step - x
    shapes = [Circle(a + size / 2, b + size / 2, size) for a, b in zip(x.tolist(), y.tolist())]
    return shapes, len(shapes), f"{words}, {step:g} mm apart, {size:.3g} mm in diameter"


def _chessboard(name, columns, rows, step, turned):
    shapes = [Rectangle(i * step, j * step, step, step)
              for j in range(rows + 1) for i in range(columns + 1) if (i + j) % 2 == 0]
    return shapes, columns * rows, (f"chessboard of {columns} x {rows} inner corners, squares of "
                                    f"{step:g} mm")


def _charuco(name, columns, rows, step, turned):
    """Shapes of OpenCV's CharucoBoard, whose object points give the markers' corners."""
    import cv2
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, _FAMILY))
    markers = len(dictionary.bytesList)
    if columns * rows // 2 > markers:
        raise InputError(f"charuco:{columns}x{rows} needs {columns * rows // 2} markers, "
                         f"{_FAMILY} has {markers}")
    board = cv2.aruco.CharucoBoard((columns, rows), step, _MARKER * step, dictionary)
    shapes, white = [], set()
    cells = dictionary.markerSize + 2
    for number, corners in zip(board.getIds().ravel(), np.array(board.getObjPoints(), float)):
        # In single precision there, whole squares here.
        i, j = (int(middle // step) for middle in corners[:, :2].mean(axis=0))
        white.add((i, j))
        x, y = ((k + (1 - _MARKER) / 2) * step for k in (i, j))
        dark = dictionary.generateImageMarker(int(number), cells) == 0
        shapes += _cells(dark, x, y, _MARKER * step / cells)
    shapes += [Rectangle(i * step, j * step, step, step)
               for j in range(rows) for i in range(columns) if (i, j) not in white]
    return shapes, (columns - 1) * (rows - 1), (
        f"ChArUco board of {columns} x {rows} squares of {step:g} mm, markers of "
        f"{_MARKER * step:g} mm, {_FAMILY}")


def _aprilgrid(columns, rows, side, spacing):
    """Shapes, points and words of Kalibr's AprilGrid: tag 0 at the lower left, black squares at the
    corners of the tags."""
    import cv2
    family, gap = april_family(), spacing * side
    if columns * rows > len(family.bytesList):
        raise InputError(f"aprilgrid:{columns}x{rows} needs {columns * rows} tags, the family "
                         f"36h11 has {len(family.bytesList)}")
    shapes = [Rectangle(i * (side + gap), j * (side + gap), gap, gap)
              for j in range(rows + 1) for i in range(columns + 1)]
    for number in range(columns * rows):
        row, column = divmod(number, columns)
        x, y = gap + column * (side + gap), gap + (rows - 1 - row) * (side + gap)
        # OpenCV's picture of a tag stands on its head, compared with Kalibr's.
        picture = cv2.aruco.generateImageMarker(family, number, _TAG, borderBits=_BORDER)
        shapes += _cells(picture[::-1, ::-1] == 0, x, y, side / _TAG)
    return shapes, 4 * columns * rows, (
        f"AprilGrid of {columns} x {rows} tags 36h11 of {side:g} mm, {gap:g} mm apart (spacing "
        f"{spacing:g})")


def _cells(dark, x, y, size):
    """Rectangles of the dark cells of a marker, those next to each other in a row as one."""
    shapes = []
    for row, line in enumerate(dark):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
        shapes += [Rectangle(x + size * a, y + size * row, size * (b - a), size)
                   for a, b in zip(edges[::2].tolist(), edges[1::2].tolist())]
    return shapes


def _moved(shape, x, y):
    if isinstance(shape, Circle):
        return Circle(shape.x + x, shape.y + y, shape.diameter)
    return Rectangle(shape.x + x, shape.y + y, shape.width, shape.height)
