"""Points as comma-separated values: for other calibration software, and from other detectors."""

import csv
import io

import numpy as np

from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_spec.errors import InputError
from ncdc_spec.files import parse_text, read_bytes, write_text

__all__ = ["STYLES", "is_points_csv", "load_csv", "points_csv", "save_csv"]

_CORRESPONDENCES = "photo,object_x,object_y,object_z,image_x,image_y"
_LINES = "photo,direction,line,y,x"
_NEEDED = "object_x", "object_y", "image_x", "image_y"
_EXACT = 1e-3          # of the pitch: tolerance of object points on their lattice
_LARGEST = 1000        # steps of the lattice along one axis


def points_csv(points, style):
    """CSV text of the :class:`TargetPoints` in one of :data:`STYLES`.

    opencv : object point (x, y, 0), in steps from column to column of the target (of an
        AprilGrid in sides of a tag), and image point, as ``cv2.calibrateCamera`` takes them.
    discorpy : the points line by line as Discorpy groups them: horizontal lines from the top,
        each from the left, then vertical lines from the left, each from the top; y before x.
    """
    header, rows = STYLES[style]
    lines = [",".join(map(str, row)) for photo in points.photos
             for row in rows(photo.whole, points)]
    return "\n".join([header, *lines]) + "\n"


def save_csv(path, points, style):
    """Write :func:`points_csv`; the file is replaced whole or not at all."""
    write_text(path, points_csv(points, style))


def _correspondences(photo, points):
    for place, (x, y) in zip(points.places(photo.index), photo.xy):
        right, down = (f"{part:.9g}" for part in place)
        yield _quoted(photo.name), right, down, 0, f"{x:.4f}", f"{y:.4f}"


def _lines(photo, points):
    for direction, along, across in (("horizontal", 0, 1), ("vertical", 1, 0)):
        order = np.lexsort((photo.index[:, along], photo.index[:, across]))
        for k in order:
            x, y = photo.xy[k]
            yield (_quoted(photo.name), direction, photo.index[k, across], f"{y:.4f}", f"{x:.4f}")


def _quoted(name):
    """``name`` as one field."""
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"\n') else name


STYLES = {"opencv": (_CORRESPONDENCES, _correspondences), "discorpy": (_LINES, _lines)}


def is_points_csv(path):
    """Whether ``path`` is named .csv, or its first line names an image point's columns.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    first = read_bytes(path)[:1024].splitlines()[:1]
    return str(path).lower().endswith(".csv") or b"image_x" in b"".join(first)


def load_csv(path, size=None):
    """:class:`TargetPoints` of a CSV of object and image points, as :func:`points_csv` writes.

    The columns object_x, object_y, image_x and image_y are needed, in any order; photo, and
    object_z, which must be 0, may be missing. Object points may be in any unit: their lattice is
    the largest one on which all of them lie.

    Parameters
    ----------
    path : path
    size : (int, int)
        Width and height of the photos.

    Raises
    ------
    InputError
        If the size is None, the file cannot be read, lacks a column, holds what is no number, a
        target that is not flat, object points on no lattice, or fails a check of
        :class:`TargetPoints`.
    """
    if size is None:
        raise InputError(f"{path}: the size of the photos is not known; --sensor-size WxH gives it")
    try:
        photos, values = parse_text(path, "CSV of points", _rows)
        lattice = [_lattice(values[:, axis], name) for axis, name in
                   ((0, "object_x"), (1, "object_y"))]
        index = np.stack([steps for steps, _ in lattice], axis=1)
        parts = []
        for name in dict.fromkeys(photos):
            on = np.array([photo == name for photo in photos])
            parts.append(PhotoPoints(index[on], values[on, 2:], np.zeros(int(on.sum())),
                                     name=name))
        # As corners: the file has no sizes of dots, which a correction would need.
        return TargetPoints("chessboard", tuple(size), tuple(parts),
                            aspect=float(lattice[1][1] / lattice[0][1]))
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(str(path)) else f"{path}: {text}") from error


def _rows(text):
    """Photo of each point, and object_x, object_y, image_x and image_y, shape (n, 4)."""
    reader = csv.DictReader(io.StringIO(text, newline=""), skipinitialspace=True)
    names = [str(name).strip() for name in reader.fieldnames or ()]
    if ",".join(names) == _LINES:
        raise InputError("it is in the style of Discorpy, which has no object points; "
                         "ncdc export --style opencv writes them")
    missing = [name for name in _NEEDED if name not in names]
    if missing:
        raise InputError(f"the first line names {', '.join(names) or 'no columns'}: "
                         f"{', '.join(missing)} is missing")
    reader.fieldnames = names
    photos, values = [], []
    for row in reader:
        try:
            numbers = [float(row[name]) for name in _NEEDED]
            depth = float(row.get("object_z") or 0)
        except (TypeError, ValueError) as error:
            raise InputError(f"line {reader.line_num} holds no number for each of "
                             f"{', '.join(_NEEDED)}") from error
        if not np.isfinite(numbers).all():
            raise InputError(f"line {reader.line_num} holds a number that is not finite")
        if depth != 0:
            raise InputError(f"object_z is {depth:g} in line {reader.line_num}, 0 is needed: the "
                             f"target must be flat")
        photos.append(row.get("photo") or "photo")
        values.append(numbers)
    if not values:
        raise InputError("it holds no points")
    return photos, np.array(values)


def _lattice(values, name):
    """Steps (n,) of ``values`` on their lattice, whole numbers from 0 on, and its pitch."""
    distinct = np.unique(values)
    gaps = np.diff(distinct)
    reach = np.ptp(distinct)
    gaps = gaps[gaps > 1e-6 * reach]
    if not gaps.size:
        raise InputError(f"{name} is {distinct[0]:g} in every line, three rows and columns at "
                         f"least are needed")
    pitch = gaps.min()
    for gap in gaps:
        pitch = _common(pitch, gap)
    steps = np.rint((values - distinct[0]) / pitch)
    # Refine the pitch by all values, as the smallest gap is rounded in the file.
    far = steps > 0
    pitch = float(np.sum((values - distinct[0])[far]) / np.sum(steps[far]))
    steps = np.rint((values - distinct[0]) / pitch)
    miss = np.abs((values - distinct[0]) / pitch - steps).max()
    if steps.max() > _LARGEST or miss > 0.02:
        raise InputError(f"the values of {name} lie on no lattice: {len(distinct)} values "
                         f"from {distinct[0]:g} to {distinct[-1]:g} have no common step")
    return steps.astype(np.int64), pitch


def _common(a, b):
    """Largest common divisor of two lengths, with a tolerance."""
    tolerance = _EXACT * min(a, b)
    while b > tolerance:
        a, b = b, abs(a - b * np.rint(a / b))
    return a
