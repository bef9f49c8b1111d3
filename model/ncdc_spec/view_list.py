"""A list of views that the corrector makes of one raw frame, each in its part of one buffer."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGRX8, OutputFormat, check_format
from ncdc_spec.geometry import check_strip_width
from ncdc_spec.view import VIEW_REGISTERS, View

__all__ = ["ENTRY_WORDS", "MAX_VIEWS", "OFFSET", "ONE_VIEW", "PITCH", "PITCH_BITS", "Entry",
           "buffer_bytes", "check_entries", "check_largest", "entry_register", "list_values",
           "placed", "quad"]

MAX_VIEWS = 8
PITCH_BITS = 16

OFFSET, PITCH = "TARGET_OFFSET", "TARGET_PITCH"

ENTRY_WORDS = {
    **{name.removeprefix("VIEW_"): name for name in VIEW_REGISTERS},
    "SPLIT": "CACHE_SPLIT", "STRIP": "STRIP_WIDTH", "WIDTH": "CORRECTED_WIDTH",
    "HEIGHT": "CORRECTED_HEIGHT", "FORMAT": "OUTPUT_FORMAT", "OFFSET": OFFSET, "PITCH": PITCH}
"""What an entry's register is called after ``VIEW`` and its number: the value of the set that it
replaces. All but the last two are registers of their own, which are entry 0."""


def entry_register(number, word):
    """Name of the register of a ``word`` of :data:`ENTRY_WORDS` of the entry ``number``."""
    return f"VIEW{number}_{word}"


ONE_VIEW = {"VIEWS": 1, entry_register(0, "OFFSET"): 0, entry_register(0, "PITCH"): 0}
"""Register values with which the list has only the view of the set."""


@dataclass(frozen=True)
class Entry:
    """A view, and where and how its pixels are stored.

    Parameters
    ----------
    view : View
    offset : int
        Bytes from the start of the buffer to the first pixel, a multiple of the memory word.
    pitch : int
        Bytes from row to row, a multiple of the memory word; 0: rows follow without a gap.
    form : OutputFormat
    strip, split : int, optional
        Columns of the strips in whose order pixels are made; the tile cache's split. Those of the
        hardware if absent.
    """
    view: View
    offset: int = 0
    pitch: int = 0
    form: OutputFormat = BGRX8
    strip: int | None = None
    split: int | None = None

    @property
    def row_bytes(self):
        """Bytes of a row's pixels."""
        return self.view.size[0] * self.form.pixel_bytes

    @property
    def stride(self):
        """Bytes from row to row."""
        return self.pitch or self.row_bytes

    @property
    def end(self):
        """Bytes from the start of the buffer to the end of the last pixel."""
        return self.offset + self.stride * (self.view.size[1] - 1) + self.row_bytes


def placed(views, corners, size, form=BGRX8):
    """Entries of ``views`` in one picture of ``size`` (width, height), in pixels.

    Each of ``corners`` is (column, row) of a view's first pixel. Later views cover earlier ones.

    Raises
    ------
    InputError
        If a view is not inside the picture.
    """
    width, height = size
    for k, (view, corner) in enumerate(zip(views, corners, strict=True)):
        if min(corner) < 0 or any(first + side > limit for first, side, limit in
                                  zip(corner, view.size, size)):
            raise InputError(f"view {k} has {view.size[0]}x{view.size[1]} pixels from column "
                             f"{corner[0]}, row {corner[1]} on, the picture has {width}x{height}")
    n = form.pixel_bytes
    return tuple(Entry(view, n * (v * width + u), n * width, form)
                 for view, (u, v) in zip(views, corners))


def quad(views, form=BGRX8):
    """Entries of four ``views`` of equal size, each in a quarter of one picture: upper left and
    right, lower left and right.

    Raises
    ------
    InputError
        If there are not four, or their sizes differ.
    """
    sizes = sorted({view.size for view in views})
    if len(views) != 4 or len(sizes) != 1:
        raise InputError(f"there are {len(views)} views of {len(sizes)} sizes, a quad needs 4 of "
                         f"one")
    [(width, height)] = sizes
    corners = [(u, v) for v in (0, height) for u in (0, width)]
    return placed(views, corners, (2 * width, 2 * height), form)


def buffer_bytes(entries, data_width):
    """Bytes of the buffer that ``entries`` need, in whole words of ``data_width`` bits."""
    word = data_width // 8
    return -(-max(entry.end for entry in entries) // word) * word


def check_entries(entries, hardware, geometry):
    """Raise :class:`InputError` unless ``hardware``, made for a camera of ``geometry``, can make
    this list of views."""
    if not 1 <= len(entries) <= hardware.views:
        raise InputError(f"there are {len(entries)} views, the limits are 1 and {hardware.views}")
    word = hardware.data_width // 8
    for k, entry in enumerate(entries):
        for name, value in (("offset", entry.offset), ("pitch", entry.pitch)):
            if value < 0 or value % word:
                raise InputError(f"the {name} of view {k} is {value} bytes, a multiple of the "
                                 f"memory word's {word} is needed")
        if not entry.row_bytes <= entry.stride < 1 << PITCH_BITS:
            raise InputError(f"the pitch of view {k} is {entry.stride} bytes, the limits are "
                             f"{entry.row_bytes} and {(1 << PITCH_BITS) - word}")
        if entry.view.size[0] % hardware.lanes:
            raise InputError(f"view {k} is {entry.view.size[0]} pixels wide, {hardware.lanes} "
                             f"pixels per clock need a multiple of {hardware.lanes}")
        check_strip_width(entry.strip or 0)
        check_format(entry.form, geometry)


def check_largest(entries, largest):
    """Raise :class:`InputError` if a view is beyond the ``largest`` (width, height) of the
    hardware, that of its register LARGEST."""
    for k, entry in enumerate(entries):
        if any(side > limit for side, limit in zip(entry.view.size, largest)):
            raise InputError(f"view {k} has {entry.view.size[0]}x{entry.view.size[1]} pixels, the "
                             f"hardware makes up to {largest[0]}x{largest[1]}")


def list_values(entries, hardware, geometry):
    """Register values, by name, of a list of views: their number, and each one's entry.

    Raises
    ------
    InputError
        As :func:`check_entries`.
    """
    check_entries(entries, hardware, geometry)
    values = {"VIEWS": len(entries)}
    for k, entry in enumerate(entries):
        split = hardware.split_for(geometry) if entry.split is None else entry.split
        strip = hardware.strip if entry.strip is None else entry.strip
        words = (*entry.view.matrix, split, strip, *entry.view.size, entry.form.code,
                 entry.offset, entry.pitch)
        values |= {entry_register(k, word): value for word, value in zip(ENTRY_WORDS, words)}
    return values
