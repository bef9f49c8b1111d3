"""The units of a lot: folders of photos, a CSV, or an address that fsspec opens."""

import csv
import io
import os
import re
import unicodedata
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

import fsspec

from ncdc_model.photo.names import may_be_photo, natural
from ncdc_spec.eeprom import SERIAL_BYTES
from ncdc_spec.errors import InputError

__all__ = ["STATION_LENGTH", "Unit", "check_station", "find_units", "local_photos"]

STATION_LENGTH = 63      # characters of a station's name
_SERIAL = re.compile(r"[A-Za-z0-9][\w.+-]{0,%d}" % (SERIAL_BYTES - 1), re.ASCII)
_COLUMNS = "unit", "photo", "station"


@dataclass(frozen=True)
class Unit:
    """One camera of a lot.

    Parameters
    ----------
    serial : str
        Its serial number, also the name of its files: letters, digits, ``_ . + -``.
    photos : tuple of str
        Paths or addresses of its photos.
    station : str
        Where the photos were taken; empty: the station of the run.

    Raises
    ------
    InputError
        If the serial number has other characters, or more than fit an EEPROM, or the station's
        name is too long.
    """
    serial: str
    photos: tuple
    station: str = ""

    def __post_init__(self):
        if not _SERIAL.fullmatch(self.serial):
            raise InputError(f"the unit {self.serial!r} has a serial number that is no name: up to "
                             f"{SERIAL_BYTES} letters, digits, _ . + - are needed")
        if self.station:
            check_station(self.station, f"the station of the unit {self.serial}")


def check_station(name, title):
    """Raise :class:`InputError` for a name of a station, called ``title``, that is no text of 1 to
    63 characters."""
    if not 1 <= len(name) <= STATION_LENGTH:
        raise InputError(f"{title} has {len(name)} characters, the limits are 1 and "
                         f"{STATION_LENGTH}")
    if any(unicodedata.category(letter) in ("Cc", "Cs") for letter in name):
        raise InputError(f"{title} is {name!r}, which has characters that are no text")


def find_units(source):
    """Every :class:`Unit` of ``source``, in natural order of the serial numbers.

    Parameters
    ----------
    source : str
        A folder with a folder of photos per unit; a CSV with the columns ``unit`` and ``photo``,
        optionally ``station``, one line per photo; either may be an address of fsspec, such as
        ``s3://bucket/lot`` or ``zip://::lot.zip``. Photos in a CSV are relative to it.

    Raises
    ------
    InputError
        If it cannot be read, or has no unit.
    """
    first, link, rest = source.partition("::")
    if "://" not in source:
        first = os.path.abspath(source)
    try:
        units = (_of_csv if first.lower().endswith(".csv") else _of_folder)(first, link + rest)
    except (OSError, ValueError, ImportError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot read {source}: {_reason(error)}") from error
    if not units:
        raise InputError(f"{source} has no unit: a folder of photos per unit is needed, or a CSV "
                         f"with the columns unit and photo")
    return sorted(units, key=lambda unit: natural(unit.serial))


def _of_folder(first, rest):
    """Units of a folder: its folders, even empty ones."""
    system, root = fsspec.core.url_to_fs(first + rest)
    if not system.isdir(root):
        raise InputError(f"cannot read {first}: there is no such folder")
    photos = {}
    for path, about in system.find(root, maxdepth=2, withdirs=True, detail=True).items():
        parts = PurePosixPath(path.rstrip("/")[len(root):].lstrip("/")).parts
        if not parts or parts[0].startswith("."):
            continue
        if about["type"] == "directory" and len(parts) == 1:
            photos.setdefault(parts[0], [])
        elif len(parts) == 2 and about["type"] == "file" and may_be_photo(parts[1]):
            photos.setdefault(parts[0], []).append(_joined(first, "/".join(parts)) + rest)
    return [Unit(serial, tuple(sorted(names, key=natural))) for serial, names in photos.items()]


def _of_csv(address, rest):
    with fsspec.open(address + rest, "rb") as file:
        text = file.read().decode("utf-8-sig")
    reader = csv.DictReader(io.StringIO(text))
    unknown = set(reader.fieldnames or ()) - set(_COLUMNS)
    if unknown or not {"unit", "photo"} <= set(reader.fieldnames or ()):
        raise InputError(f"{address} has the columns {', '.join(reader.fieldnames or ()) or 'none'}"
                         f"; unit, photo and optionally station are needed")
    folder = address.rpartition("/")[0]
    photos, stations = {}, {}
    for number, row in enumerate(reader, 2):
        unit, photo, station = (row.get(name) or "" for name in _COLUMNS)
        if not (unit and photo) or None in row:
            raise InputError(f"{address}: line {number} lacks a unit or a photo, or has more cells "
                             f"than the first line")
        if stations.setdefault(unit, station) != station:
            raise InputError(f"{address}: line {number} has the station {station!r} for the unit "
                             f"{unit}, an earlier one {stations[unit]!r}")
        whole = "://" in photo or os.path.isabs(photo)
        photo = photo if whole else _joined(folder, photo) + rest
        if photo in photos.setdefault(unit, []):
            raise InputError(f"{address}: line {number} has a photo of the unit {unit} again, "
                             f"{photo}")
        photos[unit].append(photo)
    return [Unit(serial, tuple(names), stations[serial]) for serial, names in photos.items()]


def _joined(folder, name):
    return folder + name if folder.endswith("/") else f"{folder}/{name}"


@contextmanager
def local_photos(addresses):
    """Yield the photos as local paths: copies, for the time of the block, of those elsewhere.

    Raises
    ------
    InputError
        If one cannot be read.
    """
    with TemporaryDirectory(prefix="ncdc-lot-") as folder:
        yield [_local(address, Path(folder) / str(number))
               for number, address in enumerate(addresses)]


def _local(address, folder):
    if "://" not in address:
        return address
    try:
        with fsspec.open(address, "rb") as file:
            content = file.read()
    except (OSError, ValueError, ImportError, KeyError) as error:
        raise InputError(f"cannot read {address}: {_reason(error)}") from error
    folder.mkdir()
    path = folder / PurePosixPath(address.partition("::")[0]).name
    path.write_bytes(content)
    return str(path)


def _reason(error):
    return getattr(error, "strerror", None) or error
