"""Several views of one raw frame in one picture, from a file."""

import tomllib
from dataclasses import dataclass

import numpy as np

from ncdc.cli.view_angles import view_options
from ncdc_model.correction import correct
from ncdc_model.golden.view_list import compose
from ncdc_spec.errors import InputError, reading
from ncdc_spec.files import parse_text
from ncdc_spec.frames import BGRX8, stored_picture
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE
from ncdc_spec.view_list import MAX_VIEWS, PITCH_BITS, placed
from ncdc_spec.view_matrix import LIMITS, Angles, PlaneCamera

__all__ = ["ViewsFile", "add_view_list", "check_alone"]

_SIDES = "width", "height"
_CORNER = "column", "row"
_MAX_WIDTH = ((1 << PITCH_BITS) - 1) // BGRX8.pixel_bytes
_MAX_HEIGHT = MAX_VIEWS * MAX_SIZE


def add_view_list(parser):
    """Declare the option --view-list."""
    parser.add_argument("--view-list", metavar="FILE",
                        help="several views in one picture, of a TOML file: its width and height, "
                             "and of each [[view]] column, row, width, height, pan, tilt, roll and "
                             "zoom")


def check_alone(args, *more):
    """Raise :class:`InputError` if an option is given that --view-list does not take: those of
    colour, of one view and of stabilisation, and ``more`` of (option, value or None)."""
    for option, given in (("--tone", args.tone), ("--crest", args.crest if args.crest != "off"
                                                   else None),
                          ("--white-balance", args.white_balance),
                          ("--raw-balance", args.raw_balance), *view_options(args), *more):
        if given is not None:
            raise InputError(f"{option} is given with --view-list, which does not take it")


@dataclass(frozen=True)
class ViewsFile:
    """A file of views.

    Parameters
    ----------
    size : (int, int)
        Width and height of the picture.
    views : tuple of (Angles, (int, int), (int, int))
        Of each view its angles, the column and row of its first pixel, its width and height.
    """
    size: tuple
    views: tuple

    @classmethod
    def load(cls, path):
        """The file ``path``.

        Raises
        ------
        InputError
            If it is no such file, a value is missing, unknown, or beyond its limits.
        """
        table = parse_text(path, "list of views", tomllib.loads)
        with reading(path):
            _check_names(table, (*_SIDES, "view"))
            size = (_whole(table, "width", MIN_SIZE, _MAX_WIDTH),
                    _whole(table, "height", MIN_SIZE, _MAX_HEIGHT))
            views = table["view"]
            if not isinstance(views, list) or not 1 <= len(views) <= MAX_VIEWS:
                raise InputError(f"1 to {MAX_VIEWS} tables [[view]] are needed")
            return cls(size, tuple(_view(k, view) for k, view in enumerate(views)))

    def entries(self, descriptor, form=BGRX8):
        """The :class:`~ncdc_spec.view_list.Entry` of each view, of pictures of ``descriptor``.

        Raises
        ------
        InputError
            If a view is not inside the picture, or too far off the axis, or the descriptor does not
            state its focal length.
        """
        camera = PlaneCamera.of(descriptor)
        return placed([camera.looking(angles, size) for angles, _, size in self.views],
                      [corner for _, corner, _ in self.views], self.size, form)

    def picture(self, descriptor, raw, model=None):
        """The picture of a ``raw`` frame, uint8 RGB; pixels of no view are black.

        ``model``: as of :func:`ncdc_model.correction.correct`.
        """
        width, height = self.size
        stored = np.zeros((height, width, BGRX8.pixel_bytes), np.uint8)
        compose(descriptor, raw, self.entries(descriptor), stored.reshape(-1), correct,
                model=model)
        return stored_picture(stored)


def _view(number, table):
    with reading(f"view {number}"):
        if not isinstance(table, dict):
            raise InputError("a table is needed")
        _check_names(table, (*_CORNER, *_SIDES, *LIMITS))
        corner = tuple(_whole(table, name, 0, MAX_VIEWS * MAX_SIZE, 0) for name in _CORNER)
        size = tuple(_whole(table, name, MIN_SIZE, MAX_SIZE) for name in _SIDES)
        angles = Angles(**{name: _real(table, name) for name in LIMITS if name in table})
        return angles, corner, size


def _check_names(table, known):
    for name in table:
        if name not in known:
            raise InputError(f"it has the value {name}, {', '.join(known)} are known")


def _real(table, name):
    """The number ``name`` of a table."""
    value = table[name]
    if type(value) not in (int, float):
        raise InputError(f"{name} is {value!r}, a number is needed")
    return float(value)


def _whole(table, name, low, high, default=None):
    """The integer ``name`` of a table."""
    value = table[name] if default is None else table.get(name, default)
    if type(value) is not int or not low <= value <= high:
        raise InputError(f"{name} is {value!r}, an integer of {low} to {high} is needed")
    return value
