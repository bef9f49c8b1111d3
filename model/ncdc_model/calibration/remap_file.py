"""Files that hold the tables of OpenCV's ``remap``: NumPy, TIFF, OpenEXR, OpenCV's FileStorage."""

import hashlib
import zipfile
from dataclasses import dataclass
from io import BytesIO
from os import PathLike
from pathlib import Path
from tokenize import TokenError

import cv2
import numpy as np
from tifffile import TiffFile

from ncdc_model.calibration.files.npz import holds_camera
from ncdc_model.calibration.files.tables import file_storage
from ncdc_model.photo.quiet import captured_stderr
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE

__all__ = ["RemapFile", "are_remap_files", "read_remap"]

_NUMPY = (".npz", ".npy")
_TIFF = (".tif", ".tiff")
_PICTURE = (*_TIFF, ".exr", ".png", ".bmp", ".pgm", ".jpg", ".jpeg")
_ENDS = "xy", "12", "01"       # how the names of a map's two arrays differ
_LARGEST = 4 * 8 * MAX_SIZE**2 # bytes: two maps of the largest size in float64
_FRACTION = 5                  # fraction bits of OpenCV's fixed-point maps, per axis


@dataclass(frozen=True)
class RemapFile:
    """The tables as a file has them.

    Parameters
    ----------
    x, y : ndarray of float64, shape (height, width)
        Source pixel of every corrected pixel.
    names : (str, str)
        What the file calls them, for messages.
    sensor : (int, int) or None
        Width and height of the distorted image, if the file has them.
    kind : str
        Format of the tables, for reports.
    digest : str
        Twelve hex digits of the hash of the files.
    """
    x: np.ndarray
    y: np.ndarray
    names: tuple
    sensor: tuple | None
    kind: str
    digest: str


def are_remap_files(path):
    """What a command's ``path`` means: the list of its files, and whether they are remap tables.

    ``path``: a path, or a sequence of one or two. Raises :class:`InputError` if there are more, or
    a file cannot be read.
    """
    paths = [path] if isinstance(path, (str, PathLike)) else list(path)
    if len(paths) > 2:
        raise InputError(f"{len(paths)} files are given, one is needed, or the two of a map")
    return paths, len(paths) == 2 or _holds_map(paths[0])


def _holds_map(path):
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        return not holds_camera(read_bytes(path))
    if suffix in _NUMPY + _PICTURE:
        return True
    try:
        return bool(_maps(_storage(read_bytes(path))))
    except (cv2.error, SystemError, ValueError):
        return False


def read_remap(paths, camera=None):
    """Read a map from one file with both tables, or from two with one table each.

    A map is a pair of float arrays x and y, one float array of two channels, or a fixed-point
    pair of ``cv2.convertMaps`` (CV_16SC2 and CV_16UC1). The names of a pair differ in one
    character, x and y or 1 and 2. ``camera`` chooses one of several maps in a file by a part of
    its first array's name.

    Raises
    ------
    InputError
        If a file cannot be read, does not hold exactly one such map, or holds it in integers.
    """
    contents = [read_bytes(path) for path in paths]
    digest = hashlib.sha256(b"".join(contents)).hexdigest()[:12]
    subject = " and ".join(map(str, paths))
    tables = [_arrays(path, content) for path, content in zip(paths, contents)]
    if len(tables) == 2:
        if camera is not None:
            raise InputError(f"camera {camera} is asked for, {subject} hold one map")
        first, second = (_single(path, table) for path, table in zip(paths, tables))
        arrays, names = {str(paths[0]): first, str(paths[1]): second}, tuple(map(str, paths))
        if len(arrays) == 1:
            raise InputError(f"{paths[0]} is given twice, a map has two tables")
    else:
        arrays = tables[0]
        names = _chosen(subject, _maps(arrays), camera, arrays)
    x, y, kind = _decoded(subject, names, [arrays[name] for name in names if name])
    return RemapFile(x, y, names if names[1] else (f"x of {names[0]}", f"y of {names[0]}"),
                     _sensor(subject, tables), kind, digest)


def _arrays(path, content):
    """Arrays of a file by name."""
    suffix = Path(path).suffix.lower()
    try:
        if suffix in _NUMPY:
            return _numpy(path, content)
        if suffix == ".exr":
            return {Path(path).name: _openexr(path)}
        if suffix in _TIFF:
            return {Path(path).name: _tiff(content)}
        if suffix in _PICTURE:
            with captured_stderr():
                picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
            if picture is None:
                raise InputError("it holds no picture that can be decoded")
            return {Path(path).name: picture}
        return _storage(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except (cv2.error, SystemError, UnicodeDecodeError, ValueError, OSError, EOFError, MemoryError,
            NotImplementedError, RuntimeError, SyntaxError, TokenError,
            zipfile.BadZipFile) as error:
        reason = str(error).strip().splitlines()[-1:] or [type(error).__name__]
        raise InputError(f"{path} holds no map that can be read: {reason[0].strip()}") from error


def _numpy(path, content):
    if Path(path).suffix.lower() == ".npy":
        return {Path(path).name: np.load(BytesIO(content), allow_pickle=False)}
    with zipfile.ZipFile(BytesIO(content)) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > _LARGEST:
        raise InputError(f"its arrays have {size} bytes, {_LARGEST} is the limit")
    with np.load(BytesIO(content), allow_pickle=False) as tables:
        return {name: tables[name] for name in tables.files}


def _tiff(content):
    with TiffFile(BytesIO(content)) as file:
        if not file.pages:
            raise ValueError("it has no page")
        if len(file.pages) > 1:
            raise InputError(f"it has {len(file.pages)} pages, one is needed: x and y are two "
                             f"files")
        return file.pages[0].asarray()


def _openexr(path):
    import OpenEXR  # takes a second
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    if len(channels) != 1:
        raise InputError(f"it has the channels {', '.join(channels)}, one is needed: x and y are "
                         f"two files")
    return next(iter(channels.values()))


def _storage(content):
    """Values of OpenCV's FileStorage; empty for any other file."""
    if content.startswith((b"%YAML", b"<?xml")) or b'"opencv-matrix"' in content[:1 << 16]:
        table = file_storage(content.decode())
        return table if isinstance(table, dict) else {}
    return {}


def _maps(arrays):
    """Names (first, second) of the maps in ``arrays``; second is None for one of two channels.

    Names are compared from their ends, so that map11, map12, map21 and map22 are two maps. Small
    arrays, such as the matrices of a camera, are no maps.
    """
    large = [name for name, array in arrays.items()
             if isinstance(array, np.ndarray) and array.ndim in (2, 3)
             and min(array.shape[:2]) >= MIN_SIZE]
    for first, second in _ENDS:
        pairs, taken = [], set()
        for name in sorted(large):
            for position in reversed(range(len(name))):
                end = name[position]
                other = name[:position] + (second.upper() if end.isupper() else second) \
                    + name[position + 1:]
                if end.lower() == first and other in large and not {name, other} & taken:
                    pairs.append((name, other))
                    taken |= {name, other}
                    break
        if pairs:
            return pairs
    return [(name, None) for name in sorted(large) if arrays[name].shape[2:] == (2,)]


def _chosen(subject, maps, camera, arrays):
    """Names of the map that ``camera`` chooses, or of the only one."""
    if not maps:
        shapes = ", ".join(f"{name} {'x'.join(map(str, array.shape))}" for name, array in
                           arrays.items() if isinstance(array, np.ndarray)) or "no array"
        raise InputError(f"{subject} holds {shapes}: a map has two arrays, named as map_x and "
                         f"map_y are, or two files, and {MIN_SIZE}x{MIN_SIZE} pixels at least")
    listed = " and ".join(first for first, _ in maps)
    if camera is None:
        if len(maps) > 1:
            raise InputError(f"{subject} holds the maps {listed}, --camera must name one of them")
        return maps[0]
    fitting = [pair for pair in maps if camera == pair[0]] or \
        [pair for pair in maps if camera in pair[0]]
    if len(fitting) != 1:
        raise InputError(f"camera {camera} is asked for, {subject} holds "
                         f"{len(fitting) or 'no'} such maps among {listed}")
    return fitting[0]


def _single(path, table):
    arrays = [array for array in table.values() if isinstance(array, np.ndarray)
              and array.ndim > 1 and min(array.shape[:2]) >= MIN_SIZE]
    if len(arrays) != 1:
        raise InputError(f"{path} holds {len(arrays)} tables, one is needed: two files are given")
    return arrays[0]


def _decoded(subject, names, arrays):
    """x, y and format of a map's arrays, as the file has them."""
    arrays = [array[..., 0] if array.shape[2:] == (1,) else array for array in arrays]
    sizes = [f"{array.shape[1]}x{array.shape[0]}" for array in arrays if array.size]
    if len(sizes) == 2 and sizes[0] != sizes[1]:
        raise InputError(f"{subject}: {names[0]} is {sizes[0]}, {names[1]} is {sizes[1]}, both "
                         f"must have the size of the corrected picture")
    first, second = arrays[0], arrays[1] if len(arrays) == 2 and arrays[1].size else None
    if first.shape[2:] == (2,) and first.dtype == np.int16:
        return *_fixed_point(subject, names, first, second), "fixed-point remap tables"
    if first.shape[2:] == (2,) and second is None:
        first, second, names = first[..., 0], first[..., 1], (names[0],) * 2
    for name, array in zip(names, (first, second)):
        if array is None or array.ndim != 2:
            shape = "x".join(map(str, (first if array is None else array).shape))
            raise InputError(f"{subject}: {name} is {shape}, a map has two arrays of one channel")
        if array.dtype not in (np.float32, np.float64):
            raise InputError(f"{subject}: {name} holds {array.dtype} values, which cannot resolve "
                             f"a hundredth of a pixel: float32 or float64 is needed, or the int16 "
                             f"and uint16 pair of cv2.convertMaps")
    return (first.astype(np.float64), second.astype(np.float64),
            f"remap tables, {first.dtype}")


def _fixed_point(subject, names, whole, fraction):
    """x and y of CV_16SC2 ``whole`` and the table ``fraction``, 5 bits of x below 5 of y."""
    if fraction is None:
        raise InputError(f"{subject}: {names[0]} holds whole pixels, the second table, of their "
                         f"fractions, is missing")
    if fraction.ndim != 2 or fraction.dtype not in (np.int16, np.uint16):
        raise InputError(f"{subject}: {names[1]} holds {fraction.dtype} values, uint16 is needed "
                         f"with the int16 of {names[0]}")
    bits, limit = fraction.astype(np.int64), 1 << 2 * _FRACTION
    if bits.min() < 0 or bits.max() >= limit:
        raise InputError(f"{subject}: {names[1]} holds {bits.min()} to {bits.max()}, the limits of "
                         f"OpenCV's fractions are 0 and {limit - 1}")
    step = 2.0**-_FRACTION
    return (whole[..., 0] + step * (bits & (1 << _FRACTION) - 1),
            whole[..., 1] + step * (bits >> _FRACTION))


def _sensor(subject, tables):
    """Width and height under the name sensor in one of the files, or None."""
    for table in tables:
        if "sensor" in table:
            value = table["sensor"]
            # OpenCV 5 stores an array of one dimension as a table of its own.
            value = np.ravel(value["data"] if isinstance(value, dict) else value)
            if len(value) != 2 or value.dtype.kind not in "iuf" or (value != value.round()).any():
                raise InputError(f"{subject}: sensor is {value.tolist()}, width and height in "
                                 f"pixels are needed")
            return tuple(map(int, value))
    return None
