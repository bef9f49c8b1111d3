"""Which photos a command line names: files, folders and patterns, in the order people count in."""

import re
from glob import glob
from pathlib import Path

from ncdc_spec.errors import InputError

__all__ = ["may_be_photo", "natural", "photos_of"]

# Files next to photos in a folder that are no photos: our own, and those of other software.
_NO_PHOTOS = {".json", ".toml", ".csv", ".txt", ".md", ".yaml", ".yml", ".xml", ".html", ".pdf",
              ".svg", ".xmp", ".npz", ".v", ".py", ".log", ".db", ".ini"}
_OVERLAY = ".overlay"       # in the names of the pictures that ncdc calibrate draws


def natural(name):
    """Key of an order in which ``img2`` comes before ``img10``."""
    return [(int(part), part) if part.isdecimal() else (-1, part.lower())
            for part in re.split(r"(\d+)", str(name)) if part], str(name)


def photos_of(arguments):
    """File names of photos.

    Parameters
    ----------
    arguments : sequence of str
        Files; folders, whose photos are meant; and patterns with ``*``, ``?`` or ``[``, as a shell
        leaves them in quotes. Files in alphabetical order, as a shell sorts them, are put into
        natural order; any other order stays.

    Raises
    ------
    InputError
        If a folder or a pattern has no photo.
    """
    names = list(map(str, arguments))
    if names == sorted(names) or names == sorted(names, key=str.lower):
        names.sort(key=natural)
    return [name for given in names for name in _photos(given)]


def _photos(given):
    if Path(given).is_dir():
        found = [str(path) for path in Path(given).iterdir() if _is_photo(path)]
        if not found:
            raise InputError(f"the folder {given} holds no photo")
    elif re.search(r"[*?[]", given) and not Path(given).exists():
        found = [name for name in glob(given) if _is_photo(Path(name))]
        if not found:
            raise InputError(f"no photo has a name like {given}")
    else:
        return [given]
    return sorted(found, key=natural)


def may_be_photo(name):
    """Whether a file of this ``name`` in a folder is to be read as a photo."""
    path = Path(name)
    return (not path.name.startswith(".") and _OVERLAY not in path.name
            and path.suffix.lower() not in _NO_PHOTOS)


def _is_photo(path):
    return path.is_file() and may_be_photo(path.name)
