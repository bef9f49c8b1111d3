"""The points found on photos of a target, and their file."""

import hashlib
import json
from dataclasses import dataclass, field, replace

import numpy as np

from ncdc_model.calibration.page_bend import Bend
from ncdc_model.calibration.smooth_vector import LENS
from ncdc_spec.errors import InputError, reading
from ncdc_spec.files import parse_text, write_text
from ncdc_spec.geometry import MAX_SIZE

__all__ = ["PAGES", "Fit", "PhotoPoints", "TARGETS", "TargetPoints", "VERSION"]

VERSION = 1
FIT_VERSION = 2         # of the smooth lens's fit: another one gives other numbers
_XY_DIGITS, _AREA_DIGITS = 4, 1         # after the point, in the file
PAGES = "", "flat", "relief"     # the target's shape, as the user states it
TARGETS = ("dots", "circles", "acircles", "chessboard", "charuco")


@dataclass(frozen=True)
class PhotoPoints:
    """Numbered points of one photo of a flat target.

    Parameters
    ----------
    index : ndarray of int, shape (n, 2)
        Column and row on the target, each pair once.
    xy : ndarray, shape (n, 2)
        Distorted pixels; pixel centres are integers.
    area : ndarray, shape (n,)
        Area of the dots in square pixels; zeros for points without an area.
    rejected : dict
        Number of candidates without a number, by reason.
    name : str
        File name of the photo.
    cut : ndarray of bool, shape (n,), optional
        Dots that the picture's border cuts: numbered, but too uncertain to fit a lens to.
    dropped : tuple of (float, float, str)
        x, y and reason of the outliers, which had a number. Not in the file.
    agreement : float
        Usual distance, in pixels on one axis, of a point from its neighbours' prediction;
        not-a-number if not known. Not in the file.
    contrast : float
        Usual contrast of dots with the page between them, in parts of the page's brightness;
        not-a-number if not known. Not in the file.
    remarks : tuple of str
        Sentences on other things in the photo. Not in the file.
    warnings : tuple of str
        Sentences on what is wrong with the photo. Not in the file.
    """
    index: np.ndarray
    xy: np.ndarray
    area: np.ndarray
    rejected: dict = field(default_factory=dict)
    name: str = ""
    cut: np.ndarray | None = None
    dropped: tuple = ()
    agreement: float = float("nan")
    contrast: float = float("nan")
    remarks: tuple = ()
    warnings: tuple = ()

    def __post_init__(self):
        if self.cut is None:
            object.__setattr__(self, "cut", np.zeros(len(self.index), bool))

    def without(self, drop, reason):
        """The photo without the outliers that ``drop`` marks; the others are numbered from 0 on."""
        if not drop.any():
            return self
        keep = ~drop
        return replace(
            self, index=self.index[keep] - self.index[keep].min(axis=0), xy=self.xy[keep],
            area=self.area[keep], cut=self.cut[keep],
            rejected={**self.rejected, reason: int(drop.sum())},
            dropped=self.dropped + tuple((float(x), float(y), reason) for x, y in self.xy[drop]))

    @property
    def whole(self):
        """The photo without the points that the border cuts."""
        if not self.cut.any():
            return self
        keep = ~self.cut
        return replace(self, index=self.index[keep], xy=self.xy[keep], area=self.area[keep],
                       cut=self.cut[keep])


@dataclass(frozen=True)
class Fit:
    """A smooth lens that was fitted to points; see :class:`SmoothFit` for what they mean.

    ``bend``: a :class:`~ncdc_model.calibration.page_bend.Bend` of the page that was found with it
    and taken off the points for the next fit, or None.
    """
    vector: np.ndarray
    prior: float
    flaws: tuple
    bend: Bend | None = None

    def to_dict(self):
        """Plain numbers, strings and lists, as in the points file."""
        return {"vector": self.vector.tolist(), "prior": self.prior, "flaws": list(self.flaws),
                **({"bend": self.bend.to_dict()} if self.bend else {})}

    @classmethod
    def from_dict(cls, table):
        """The fit of :meth:`to_dict`'s table."""
        return cls(np.array(table["vector"], np.float64), float(table["prior"]),
                   tuple(map(str, table["flaws"])),
                   Bend.from_dict(table["bend"]) if "bend" in table else None)


@dataclass(frozen=True)
class TargetPoints:
    """Points of all photos that one camera took of one kind of flat target.

    Parameters
    ----------
    target : str
        dots, circles, acircles (staggered, the index counts half steps), chessboard or charuco.
    size : (int, int)
        Width and height of the photos.
    photos : tuple of PhotoPoints
    rejected_photos : dict
        Why a photo was not used, by its name.
    aspect : float
        Distance of two rows over that of two columns on the target.
    choice : str
        The target found, and the number of photos with it, if none was named. Not in the file.
    target_size : (int, int), optional
        Columns and rows of the target, whether seen or not. Not in the file.
    page : str
        The target's shape, as the user states it: ``flat``, ``relief`` (it has one, for which the
        points are corrected), or empty.
    fits : tuple of Fit
        The fits of :func:`ncdc_model.calibration.frame.ideal_frame` for exactly these points, in
        their order, or none: then the lens is fitted again.

    Raises
    ------
    InputError
        If the target is unknown, no photo is left, lengths differ, an index occurs twice, a
        number is not finite, or a point lies outside the image.
    """
    target: str
    size: tuple
    photos: tuple
    rejected_photos: dict = field(default_factory=dict)
    aspect: float = 1.0
    choice: str = ""
    target_size: tuple | None = None
    page: str = ""
    fits: tuple = ()

    def __post_init__(self):
        if self.page not in PAGES:
            raise InputError(f"page is {self.page!r}, one of flat and relief is needed")
        if self.target not in TARGETS:
            raise InputError(f"target is {self.target!r}, one of {', '.join(TARGETS)} is needed")
        if not all(8 <= value <= MAX_SIZE for value in self.size):
            raise InputError(f"the image size is {self.size[0]}x{self.size[1]}, the limits are 8 "
                             f"and {MAX_SIZE}")
        if not 0.1 <= self.aspect <= 10:
            raise InputError(f"aspect is {self.aspect}, the limits are 0.1 and 10")
        if not self.photos:
            raise InputError("there are points of 0 photos, at least 1 is needed")
        for photo in self.photos:
            self._check(photo)

    def _check(self, photo):
        n = len(photo.index)
        for name, array, shape in (("index", photo.index, (n, 2)), ("xy", photo.xy, (n, 2)),
                                   ("area", photo.area, (n,)), ("cut", photo.cut, (n,))):
            if array.shape != shape:
                raise InputError(f"{photo.name}: {name} has shape {array.shape}, {shape} is needed")
            if not np.isfinite(array).all():
                raise InputError(f"{photo.name}: {name} holds a number that is not finite")
        if not n:
            raise InputError(f"{photo.name} has 0 points, at least 1 is needed")
        if len(np.unique(photo.index, axis=0)) < n:
            raise InputError(f"{photo.name}: {n} points have {len(np.unique(photo.index, axis=0))} "
                             f"different indices")
        limit = np.array(self.size) - 0.5
        outside = ((photo.xy < -0.5) | (photo.xy > limit)).any(axis=1)
        if outside.any():
            x, y = photo.xy[outside.argmax()]
            raise InputError(f"{photo.name}: point ({x:g}, {y:g}) lies outside the image of "
                             f"{self.size[0]}x{self.size[1]}")

    @property
    def columns(self):
        """Columns that the indices span, the largest of all photos."""
        return int(max(np.ptp(photo.index[:, 0]) for photo in self.photos)) + 1

    @property
    def rows(self):
        """Rows that the indices span, the largest of all photos."""
        return int(max(np.ptp(photo.index[:, 1]) for photo in self.photos)) + 1

    @property
    def count(self):
        """Points in all photos."""
        return sum(len(photo.index) for photo in self.photos)

    @property
    def whole(self):
        """Points in all photos that the border does not cut."""
        return sum(len(photo.whole.index) for photo in self.photos)

    @property
    def digest(self):
        """Twelve hex digits of the hash of the image size, the indices and the points."""
        about = self.target, tuple(self.size), *([self.aspect] if self.aspect != 1 else [])
        state = hashlib.sha256(repr(about).encode())
        for photo in self.photos:
            state.update(np.asarray(photo.index).astype("<i8").tobytes())
            state.update(np.asarray(photo.xy).astype("<f8").tobytes())
            state.update(np.asarray(photo.cut).astype("u1").tobytes() if photo.cut.any() else b"")
        return state.hexdigest()[:12]

    @property
    def rounded(self):
        """The points as their file has them."""
        return replace(self, fits=(), photos=tuple(
            replace(photo, xy=_rounded(photo.xy, _XY_DIGITS),
                    area=_rounded(photo.area, _AREA_DIGITS)) for photo in self.photos))

    def save(self, path):
        """Write the points as JSON; the file is replaced whole or not at all.

        The fits go with points that are :attr:`rounded`, and with a hash of them.
        """
        lines = self._lines()
        if self.fits:
            table = {"version": FIT_VERSION, "points": _hash(lines), "fits": [
                fit.to_dict() for fit in self.fits]}
            lines.insert(-1, f'"lens": {json.dumps(table)}')
        write_text(path, "{" + ",\n".join(lines) + "}\n")

    def _lines(self):
        return [f'"format": "ncdc points", "version": {VERSION}',
                f'"target": {json.dumps(self.target)}, "aspect": {self.aspect!r}',
                f'"columns": {self.columns}, "rows": {self.rows}',
                f'"width": {self.size[0]}, "height": {self.size[1]}',
                *([f'"page": {json.dumps(self.page)}'] if self.page else []),
                f'"rejected_photos": {json.dumps(self.rejected_photos)}',
                '"photos": [\n' + ",\n".join(map(_photo_text, self.photos)) + "\n]"]

    @classmethod
    def load(cls, path):
        """Read and check a points file.

        Raises
        ------
        InputError
            If the file cannot be read, is no points file, is of another version, or fails a
            check of this class.
        """
        table = parse_text(path, "points file", json.loads)
        if not isinstance(table, dict) or table.get("format") != "ncdc points":
            raise InputError(f"{path} is no points file: it lacks the format 'ncdc points'")
        if table.get("version") != VERSION:
            raise InputError(f"{path} has points version {table.get('version')}, version {VERSION} "
                             f"is needed")
        with reading(path):
            points = cls(target=table["target"], size=(int(table["width"]), int(table["height"])),
                         photos=tuple(map(_photo, table["photos"])),
                         rejected_photos=dict(table["rejected_photos"]),
                         aspect=float(table.get("aspect", 1.0)), page=table.get("page", ""))
            if (points.columns, points.rows) != (table["columns"], table["rows"]):
                raise InputError(f"columns and rows are {table['columns']} and {table['rows']}, "
                                 f"the indices span {points.columns} and {points.rows}")
            return replace(points, fits=points._fits_of(table.get("lens")))

    def _fits_of(self, table):
        """Fits of the ``table`` of a file, if they are of these points by this version, or none."""
        if (not isinstance(table, dict) or table.get("version") != FIT_VERSION
                or table.get("points") != _hash(self._lines())):
            return ()
        fits = tuple(map(Fit.from_dict, table["fits"]))
        return fits if all(len(fit.vector) >= LENS and np.isfinite(fit.vector).all()
                           for fit in fits) else ()


def _rounded(values, digits):
    """Numbers rounded as in the text of a file."""
    return np.array([round(value, digits) for value in values.ravel().tolist()],
                    np.float64).reshape(values.shape)


def _hash(lines):
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _photo_text(photo):
    """One photo as JSON, a line per point: column, row, x, y, area, and 1 if it is cut."""
    rows = [json.dumps([int(i), int(j), round(float(x), _XY_DIGITS), round(float(y), _XY_DIGITS),
                        round(float(area), _AREA_DIGITS)] + [1] * bool(cut))
            for (i, j), (x, y), area, cut in zip(photo.index, photo.xy, photo.area, photo.cut)]
    return (f'{{"name": {json.dumps(photo.name)}, "rejected": {json.dumps(photo.rejected)},\n'
            f'"points": [\n' + ",\n".join(rows) + "\n]}")


def _photo(table):
    rows = [list(row) + [0] * (len(row) == 5) for row in table["points"]]
    if any(len(row) != 6 for row in rows):
        raise InputError(f"{table['name']}: a point needs 5 numbers: column, row, x, y, area, or "
                         f"a sixth: 1 if the border cuts it")
    points = np.array(rows, np.float64).reshape(-1, 6)
    if not np.isin(points[:, 5], (0, 1)).all():
        raise InputError(f"{table['name']}: the sixth number of a point must be 0 or 1")
    index = points[:, :2]
    if not (np.isfinite(index) & (index == np.floor(index)) & (np.abs(index) < 1e6)).all():
        raise InputError(f"{table['name']}: an index is no whole number below 1000000")
    return PhotoPoints(index=index.astype(np.int64), xy=points[:, 2:4], area=points[:, 4],
                       rejected=dict(table["rejected"]), name=str(table["name"]),
                       cut=points[:, 5] == 1)
