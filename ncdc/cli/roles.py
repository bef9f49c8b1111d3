"""Rejects a file of the wrong kind: a photo where a descriptor is expected, and the like.

Each file is judged by its first bytes. A file of no known kind is left to the command.
"""

from pathlib import Path

from ncdc_model.photo.kinds import kind_of
from ncdc_spec.errors import InputError

__all__ = ["check_roles"]

_BYTES = 1 << 16
_PICTURES = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF8", b"BM"    # and no tables of a map
_BOXES = b"ftyp"            # of videos, and of photos as telephones take them
_PICTURE, _NET, _POINTS = "a picture", "a descriptor of ncdc train", "a points file"
_TRAIN = "ncdc calibrate {0} -o points.json, then ncdc train points.json --neurons 8 -o net.toml"
_HINTS = {
    ("descriptor", _PICTURE): "a descriptor is needed: " + _TRAIN,
    ("descriptor", _POINTS): "a descriptor is needed: ncdc train {0} --neurons 8 -o net.toml",
    ("picture", _NET): "a picture is needed",
    ("picture", _POINTS): "a picture is needed",
    ("lens", _PICTURE): "points, a camera file or a map are needed: " + _TRAIN,
    ("lens", _NET): "points, a camera file or a map are needed, of which one is made",
    ("exported", _PICTURE): "a descriptor or points are needed: " + _TRAIN,
}
# The kind of file that each argument takes, by argparse's name of it.
_ROLES = {"descriptor": "descriptor", "descriptors": "descriptor", "lens": "descriptor",
          "image": "picture", "photo": "picture", "photos": "picture", "reference": "lens"}
_SOURCES = {"train": "lens", "export": "exported"}


def check_roles(args):
    """Check that no file among a command's arguments is of another argument's kind.

    Parameters
    ----------
    args : argparse.Namespace
        With ``command``.

    Raises
    ------
    InputError
        If one is; the message has the line to type, or says that two files are swapped. Also if
        one that is to be no picture is a video or a photo of a format that is not read.
    """
    given = [(path, role) for name, role in {**_ROLES, "source": _SOURCES.get(args.command)}.items()
             if role for path in _listed(getattr(args, name, None))]
    kinds = [(path, role, _kind(path, role)) for path, role in given]
    wrong = [(path, role, kind) for path, role, kind in kinds if (role, kind) in _HINTS]
    if not wrong:
        return
    path, role, kind = wrong[0]
    swapped = {(role, kind) for _, role, kind in wrong}
    if {("descriptor", _PICTURE), ("picture", _NET)} <= swapped:
        net = next(path for path, _, kind in wrong if kind == _NET)
        raise InputError(f"{path} is a picture and {net} a descriptor: they are swapped, the "
                         f"descriptor comes first")
    raise InputError(f"{path} is {kind}, {_HINTS[role, kind].format(path)}")


def _listed(value):
    """The paths that an argument holds; some benches have other values under the same names."""
    return [one for one in (value if isinstance(value, list) else [value]) if isinstance(one, str)]


def _kind(path, role):
    """Kind of a file by its first bytes; None if it cannot be read or its kind is unknown."""
    try:
        if not Path(path).is_file():
            return None
        with open(path, "rb") as file:
            head = file.read(_BYTES)
    except OSError:
        return None
    if head.startswith(_PICTURES):
        return _PICTURE
    if role != "picture" and head[4:8] == _BOXES:
        kind_of(head, path)
        return _PICTURE
    if head.lstrip()[:1] == b"{" and b'"ncdc points"' in head:
        return _POINTS
    if b"\n[geometry]" in head and b"hidden_weights = [" in head:
        return _NET
    return None
