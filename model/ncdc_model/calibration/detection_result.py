"""What one photo shows: each kind of target is searched for at most once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ncdc_model.calibration.aprilgrid import find_any_aprilgrid, find_aprilgrid
from ncdc_model.calibration.boards import find_boards, grey_picture
from ncdc_model.calibration.charuco import find_any_charuco, find_charuco, has_markers
from ncdc_model.calibration.corners import find_corner_lattices
from ncdc_model.calibration.dots import dots_of, find_spots
from ncdc_model.calibration.fiducials import other_board
from ncdc_model.calibration.filters import green_picture, pattern_of
from ncdc_model.calibration.grids import corners_touch, read_grid
from ncdc_model.calibration.outliers import oblique
from ncdc_model.calibration.smooth import misfit
from ncdc_model.photo.photo import Photo
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MIN_SIZE, MONO

__all__ = ["MIN_DOTS", "DetectionResult", "TargetKind"]

MIN_DOTS = 49          # dots from which on ``auto`` takes a photo for that of a dot page
_WHOLE_GRID = 0.999    # of the rectangle's positions have a circle: the grid is complete
_NEARLY = 0.85         # the same, of a staggered grid that is taken as complete
_SQUARE_PAGE = 1.5     # pixels, median residual of a lens: a square lattice has less
_TRIED = 300           # dots that a lens is fitted to
_BOARD_FILLED = 0.75   # of a board's rectangle that is seen, if its size is not given
_BOARD_LIKE = 800      # spots on a lattice: a page with as many is no chessboard


@dataclass(frozen=True)
class TargetKind:
    """Kind, columns and rows of the target that a photo shows best; None both for dots."""
    kind: str
    columns: int | None = None
    rows: int | None = None

    def __str__(self):
        return self.kind if self.columns is None else f"{self.kind}:{self.columns}x{self.rows}"


class DetectionResult:
    """One photo and the targets found on it.

    Parameters
    ----------
    name : str
    image : ndarray of uint8, a Photo, or a function without arguments that returns one of them
        :meth:`release` drops what the function returned, and it is called again when needed. So
        only one of many photos is in memory.
    size : (int, int)
        Columns and rows of the target that is looked for; None each if they are not known.
    spacing : float, optional
        Gap between the tags of an AprilGrid, in sides of a tag; set to the measured one when the
        photo is searched.
    """

    def __init__(self, name, image, size=(None, None), spacing=None):
        self.name, self._image = name, None if callable(image) else image
        self._columns, self._rows = size
        self._charuco, self._aprilgrid, self._enough = None, None, 0
        self.spacing = self._stated = spacing
        self._green = None
        self._read = image if callable(image) else None
        self.target, self.doubt = None, ""
        self.filter, self.filter_from, self.by_green = None, "", False
        frame, declared = self._frame()
        self.size = frame.shape[1::-1]
        self.may_be_raw = frame.ndim == 2 and declared != MONO
        if self.may_be_raw and min(self.size) >= MIN_SIZE:
            self.filter = declared or pattern_of(frame)
            self.filter_from = "the file" if declared else "its colour cast"

    def _frame(self):
        """The photo, ndarray of uint8, and its declared filter pattern, ``MONO`` or None."""
        if self._image is None:
            self._image = self._read()
        photo = self._image
        if not isinstance(photo, Photo):
            return photo, None
        return photo.image, MONO if photo.lossy and photo.image.ndim == 2 else photo.bayer

    @property
    def frame(self):
        """The photo as it is, ndarray of uint8."""
        return self._frame()[0]

    @property
    def image(self):
        """The picture that is searched, ndarray of uint8: the photo, or its green sites."""
        if not self.by_green:
            return self.frame
        if self._green is None:
            self._green = green_picture(self.frame, self.filter)
        return self._green

    def on_green(self, pattern=None):
        """The photo, a raw frame with the filter ``pattern``, as its green sites show it; nothing
        has been searched for. Default: the filter that is declared or seen by its cast."""
        other = DetectionResult(self.name, self._read or self._image,
                                (self._columns, self._rows), self._stated)
        other.by_green = True
        if pattern:
            other.filter, other.filter_from = pattern, "its lateral colour"
        return other

    def release(self):
        """Drop the photo, if it can be read again."""
        self._green = None
        if self._read is not None:
            self._image = None

    def prepare(self, kind):
        """Search for targets of ``kind``, with ``auto`` for all.

        ``auto`` sets ``target`` to the best, or ``doubt`` to the reason why there is none.
        """
        if kind == "auto":
            try:
                self.target = self._recognise()
            except InputError as error:
                self.doubt = str(error)
            kind = self.target.kind if self.target else "none"
        if kind in ("circles", "acircles"):
            self.spots
        elif kind == "dots":
            try:
                self.page
            except InputError:
                pass
        elif kind == "chessboard":
            self._enough = (self._columns or 0) * (self._rows or 0)
            self.boards
        elif kind == "charuco":
            self._prepare_charuco()
        elif kind == "aprilgrid" and self._columns is not None:
            try:
                self.aprilgrid(self._columns, self._rows)
            except InputError:
                pass
        self.release()

    def _prepare_charuco(self):
        if self._columns is None:
            self.boards
            return
        try:
            self.charuco(self._columns, self._rows)
        except InputError:
            pass

    @cached_property
    def lattices(self):
        """Lattices of corners of squares."""
        return find_corner_lattices(grey_picture(self.image), enough=self._enough)

    @cached_property
    def boards(self):
        """Chessboards, PhotoPoints each."""
        return find_boards(self.image, self.lattices)

    @cached_property
    def spots(self):
        """Round spots and their lattices."""
        return find_spots(self.image)

    @cached_property
    def page(self):
        """The page of dots as PhotoPoints; raises :class:`InputError` if there is none."""
        if self._spots_are_squares():
            raise InputError(f"it shows a chessboard of {len(self.boards[0].index)} corners, no "
                             f"page of dots")
        return dots_of(self.spots, self.image)

    def _spots_are_squares(self):
        """Whether the spots are the dark squares of a chessboard.

        Saddles of brightness between dots may look like a board's corners, but their lattice is
        ragged; and dots do not touch.
        """
        lattice = self.spots.lattices[0] if self.spots.lattices else None
        count = 0 if lattice is None else len(lattice.index)
        if count >= _BOARD_LIKE or not self.boards or len(self.boards[0].index) < count:
            return False
        if _filled(self.boards[0]) > _BOARD_FILLED:
            return True
        grid = None if lattice is None else read_grid(self.size, lattice)
        return (grid is not None and grid.staggered
                and corners_touch(self.spots.dark(self.image), grid))

    def charuco(self, columns, rows):
        """The ChArUco board as PhotoPoints."""
        if self._charuco is None:
            self._charuco = find_charuco(self.image, columns, rows, lambda: self.lattices)
        return self._charuco

    def aprilgrid(self, columns, rows):
        """The AprilGrid as PhotoPoints."""
        if self._aprilgrid is None:
            self._aprilgrid, self.spacing = find_aprilgrid(self.image, columns, rows, self.spacing)
        return self._aprilgrid

    def _recognise(self):
        many = self.spots.lattices and len(self.spots.lattices[0].index) >= _BOARD_LIKE
        board = self.boards[0] if not many and self.boards else None
        span = np.ptp(board.index, axis=0) + 1 if board is not None else (0, 0)
        whole = board is not None and len(board.index) == np.prod(span)
        seen = len(self.spots.lattices[0].index) if not whole and self.spots.lattices else 0
        if (board is None or len(board.index) <= seen
                or not (whole or self._spots_are_squares())):
            target = self._round()
            if target is not None:
                return target
        if board is None or not whole or has_markers(self.image, board):
            for kind, find in (("aprilgrid", find_any_aprilgrid), ("charuco", find_any_charuco)):
                try:
                    return TargetKind(kind, *find(self.image))
                except InputError:
                    pass
        # Dots out of focus look like squares that stand on their corners, on a ragged lattice.
        if board is not None and _filled(board) > _BOARD_FILLED and min(span) >= 3:
            return TargetKind("chessboard", int(max(span)), int(min(span)))
        doubt = self.spots.doubt or self._part()
        board = other_board(grey_picture(self.image))
        raise InputError(
            board or "neither a whole grid of circles, a page of at least "
            f"{MIN_DOTS} dots, a chessboard, a ChArUco board nor an AprilGrid was found"
            + (f"; of what looks like dots, {doubt}" if doubt else ""))

    def _part(self):
        """Text on the spots that lie on one lattice, but are no complete grid."""
        if not self.spots.lattices:
            return ""
        index = self.spots.lattices[0].index
        columns, rows = np.ptp(index, axis=0) + 1
        return (f"{len(index)} lie on a lattice of {columns}x{rows}, which is not whole: --target "
                f"circles:CxR names the size of a grid")

    def _thin(self):
        """Step through the dots that leaves about 300 to fit a lens to."""
        return max(1, len(self.spots.lattices[0].index) // _TRIED)

    def _round(self):
        """The grid of circles or page of dots that the photo shows, or None."""
        if not self.spots.lattices or self.spots.square:
            return None
        lattice = self.spots.lattices[0]
        grid = read_grid(self.size, lattice)
        if grid is None:
            return None
        whole = grid.filled > _WHOLE_GRID
        columns, rows = map(int, np.ptp(grid.photo.index, axis=0) + 1)
        if not grid.staggered:
            page = self.page if len(lattice.index) >= MIN_DOTS else None
            # A grid that continues beyond the border is a page, even if its rectangle is complete.
            if whole and min(columns, rows) >= 3 and (page is None or not page.cut.any()):
                return TargetKind("circles", columns, rows)
            return TargetKind("dots") if page is not None else None
        if not whole and oblique(lattice):
            if grid.filled < _NEARLY:
                raise InputError(f"it shows {len(lattice.index)} circles of a staggered grid, too "
                                 f"few to find its size: --target acircles:CxR names it")
            whole = True
        if not whole and len(lattice.index) >= MIN_DOTS:
            # A tilted page, or a part of one, if a lens explains its steps as square ones.
            off = misfit(self.size, [(lattice.index[::self._thin()], lattice.xy[::self._thin()])])
            return TargetKind("dots") if off < _SQUARE_PAGE and self.page is not None else None
        if whole and not corners_touch(self.spots.dark(self.image), grid):
            if columns % 2:
                columns, rows = rows, columns
            if columns % 2:
                columns += 1
            if min(columns // 2, rows) >= 3:
                return TargetKind("acircles", columns // 2, rows)
        return None


def _filled(board):
    """Part of the positions of a board's rectangle that are seen."""
    return len(board.index) / np.prod(np.ptp(board.index, axis=0) + 1)
