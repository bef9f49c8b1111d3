"""How raw samples become a corrected pixel: what each interpolation needs of its surroundings."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["CRESTS", "DEFAULT", "DIRECTIONAL", "FAST", "GRADIENT", "INTERPOLATIONS",
           "Interpolation", "check_crest", "interpolation_of"]


@dataclass(frozen=True)
class Interpolation:
    """An interpolation, and the window and the tiles that it needs.

    A pixel is interpolated bilinearly between four corners, two by two, that are one sample apart.
    The first corner has the indices x0 = floor(x' - offset), y0 likewise. The window has the
    samples from ``x0 - margin`` on, :attr:`window` in each direction. Those of the core, from x0
    on, are always in the frame. Samples of the margin outside the frame are mirrored about its
    first or last column or row.

    Parameters
    ----------
    name : str
    core : int
        Rows and columns of samples, from the first corner on, that must be in the frame.
    margin : int
        Rows and columns of samples around the core.
    offset : float
        Distance of a corner from the sample of its index, in samples, in each direction.
    unit_bits : int
        Colours of the corners are in units of ``2**-unit_bits`` grey levels.
    row_bits : int or None
        Fraction bits of a grey level that a colour between two corners of a row keeps, at least
        ``unit_bits``; None if it keeps all.
    tile_height : int
        Rows of a tile of the tile cache: 2 or 4.
    tile_rows : int
        Rows of tiles that the cache can look up in one clock: 2 or 4.
    reach : int
        Steps from the core, along rows and columns, of the farthest samples of the margin in use.
    """
    name: str
    core: int
    margin: int
    offset: float
    unit_bits: int
    row_bits: int | None
    tile_height: int
    tile_rows: int
    reach: int

    @property
    def window(self):
        """Rows and columns of the window."""
        return self.core + 2 * self.margin

    @property
    def after(self):
        """Rows and columns of the window after the sample of the first corner."""
        return self.core + self.margin - 1

    @property
    def samples(self):
        """(row, column) in the window of each sample that a pixel is made from, row by row.

        These are all of the core, and those of the margin at most ``reach`` steps away from it.
        """
        away = [max(self.margin - k, k - self.after, 0)
                for k in range(self.window)]
        return tuple((j, i) for j in range(self.window) for i in range(self.window)
                     if away[j] + away[i] <= self.reach)

    @property
    def box_rows(self):
        """Rows that the tile memory reads in one clock: a power of two, at least a window."""
        return 1 << (self.window - 1).bit_length()

    def box_words(self, lanes):
        """(number, samples) of the words of a box in a row, for ``lanes`` pixels per clock.

        Words begin at multiples of their size. They hold the windows of a group at any position
        if the map steps by up to two columns from pixel to pixel.
        """
        # Two words of 8 hold 9 columns at any position, four of 4 hold 13.
        return (2, 8) if self.window + 2 * (lanes - 1) <= 9 else (4, 4)

    @property
    def min_f_bits(self):
        """Fraction bits that coordinates need: 4 for the crest, whose table has eighths of a half.
        """
        return 1 if self.row_bits is None else 4

    def cut(self, f_bits):
        """Lowest bits that a colour between two corners of a row loses, for fractions of
        ``f_bits`` bits."""
        return 0 if self.row_bits is None else f_bits + self.unit_bits - self.row_bits

    def bounds(self, first, size):
        """First and last sample, of ``size`` in a direction, of windows with corners ``first``."""
        low, high = first - self.margin, first + self.after
        return (low, high) if not self.margin else (low.clip(0), high.clip(max=size - 1))


# The paper's: four overlapping quads of 2x2 samples, whose colours are half a sample further on.
FAST = Interpolation("fast", core=3, margin=0, offset=0.5, unit_bits=1, row_bits=None,
                     tile_height=4, tile_rows=2, reach=0)
# Four samples, each with a full colour by gradient-corrected kernels of 5x5 samples.
GRADIENT = Interpolation("gradient", core=2, margin=2, offset=0.0, unit_bits=4, row_bits=6,
                         tile_height=2, tile_rows=4, reach=2)
# The same four samples, by kernels that follow the direction in which colours vary less; of the
# window only the four corners are not used.
DIRECTIONAL = Interpolation("directional", core=2, margin=2, offset=0.0, unit_bits=4,
                            row_bits=6, tile_height=2, tile_rows=4, reach=3)
INTERPOLATIONS = {each.name: each for each in (FAST, GRADIENT, DIRECTIONAL)}
# Default of training. A descriptor without a name is older than the choice: it has FAST.
DEFAULT = DIRECTIONAL


CRESTS = {"off": 0, "mild": 1, "strong": 2}
"""What the directional interpolation adds where bilinear blending cuts off crests."""


def check_crest(crest, interpolation):
    """Raise :class:`InputError` unless ``interpolation`` has that strength of crest, 0 to 2."""
    if crest not in CRESTS.values():
        raise InputError(f"the crest is {crest}, one of {', '.join(map(str, CRESTS.values()))} is "
                         f"needed")
    if crest and interpolation != DIRECTIONAL:
        raise InputError(f"the interpolation is {interpolation.name}, a crest needs "
                         f"{DIRECTIONAL.name}")


def interpolation_of(name):
    """The :class:`Interpolation` called ``name``.

    Raises
    ------
    InputError
        If there is none.
    """
    if not isinstance(name, str) or name not in INTERPOLATIONS:
        raise InputError(f"the interpolation is {name!r}, one of {', '.join(INTERPOLATIONS)} is "
                         "needed")
    return INTERPOLATIONS[name]
