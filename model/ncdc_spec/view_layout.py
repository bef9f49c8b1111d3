"""Several views in one picture: where each one is, as devices on a network send them."""

from dataclasses import dataclass

from ncdc_spec.geometry import MIN_SIZE

__all__ = ["LAYOUTS", "MAX_SHOWN", "Area", "areas"]

LAYOUTS = ("Single", "Quad", "Detail")
"""One view, four of equal size, or one over the whole picture with a second one in its corner."""

MAX_SHOWN = 4
"""Views of the layout that has most."""

_STEP = 8                   # pixels: parts begin and end at whole words of a memory
_SHARE = 3 / 8              # of the picture's sides that the corner takes


@dataclass(frozen=True)
class Area:
    """The part of a picture that shows one view.

    Parameters
    ----------
    x, y : int
        Column and row of its first pixel.
    size : (int, int)
        Width and height in pixels.
    """
    x: int
    y: int
    size: tuple

    def holds(self, x, y):
        """Whether the point (x, y) of the picture is in it."""
        return self.x <= x < self.x + self.size[0] and self.y <= y < self.y + self.size[1]


def areas(layout, size):
    """The :class:`Area` of each view of a ``layout`` in a picture of ``size``; later ones cover
    earlier ones.

    A quad whose halves are no multiple of eight pixels leaves columns or rows at its end blank. A
    picture that is too small for several views has one.
    """
    width, height = size
    if layout == "Quad":
        half = tuple(side // 2 // _STEP * _STEP for side in size)
        found = [Area(x, y, half) for y in (0, half[1]) for x in (0, half[0])]
    elif layout == "Detail":
        part = tuple(int(_SHARE * side) // _STEP * _STEP for side in size)
        found = [Area(0, 0, size), Area(width - part[0], height - part[1], part)]
    else:
        found = [Area(0, 0, size)]
    return found if min(found[-1].size) >= MIN_SIZE else [Area(0, 0, size)]
