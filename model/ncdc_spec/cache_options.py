"""Sizes of the tile cache, and the index rule of its tiles."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import FAST, Interpolation

__all__ = ["CacheOptions", "TILE_MEMORIES", "TILE_WIDTH"]

TILE_MEMORIES = ("blocks", "luts", "shared")
"""Of a cache's tiles: a block RAM or more for each bank, half of the banks in LUTs, or two banks
in a block RAM. Two that share it are not read in a clock in which either may be written."""
TILE_WIDTH = 16                     # samples, a byte each
_MIN_TILES, _MAX_TILES = 16, 4096
_MAX_PENDING = 1024
_MAX_OUTSTANDING = 64
_LINES = 16                         # of the raw frame, in a cache for a raster scan


@dataclass(frozen=True)
class CacheOptions:
    """A direct-mapped cache of ``tiles`` tiles of 16 x H bytes; all sizes give the same windows.

    The index rule: sample (x, y) of the raw frame lies in tile (tx, ty) = (x div 16, y div H),
    whose slot is::

        bank = (tx mod 2) + 2 (ty mod R)
        set  = ((ty div R) mod Ky) Kx + (tx div 2) mod Kx    Kx = 2**split, Kx Ky = tiles / (2 R)
        slot = bank tiles / (2 R) + set

    with the heights of a tile H and of a bank's pattern R of the interpolation: 4 and 2 for the
    fast one, 2 and 4 for the gradient-corrected one.

    Several pixels per clock form groups. A group is one look-up if its samples (x0, y0) to
    (x1, y1), the windows of all its pixels that are not blank, fit a box:
    ``x1 div w - x0 div w < n`` with n = 2 words of w = 8 samples (6x6 windows, four lanes: 4 of 4),
    ``y1 - y0 <= 3`` (6x6 windows: 7), and at most R rows of tiles. Else it is divided in halves
    from left to right, and these likewise.

    The tiles that a window, or a box, can touch are in different banks, so no window evicts its own
    tiles.
    ``split``, 0..max_split, is chosen at run time (register CACHE_SPLIT): Kx large for a scan along
    the rows of the raw frame, small for one along its columns.

    Parameters
    ----------
    tiles : int
        A power of two, 16..4096.
    pending : int
        Windows between the look-up of their tiles and the read of their samples, at most; a power
        of two, 4..1024. They hide the memory's latency.
    outstanding : int
        Tiles requested and not yet arrived, at most, 1..64.
    sequence_bits : int
        Bits of the number of a tile's last user; at least one more than those of ``pending``, at
        most 24. With more bits a free tile is less often taken for a used one.

    interpolation : Interpolation
        The interpolation whose windows are fetched.

    Raises
    ------
    InputError
        If a value is outside its limits.
    """
    tiles: int = 512
    pending: int = 128
    outstanding: int = 16
    sequence_bits: int = 12
    interpolation: Interpolation = FAST

    def __post_init__(self):
        for name, low, high in (("tiles", _MIN_TILES, _MAX_TILES),
                                  ("pending", 4, _MAX_PENDING)):
            value = getattr(self, name)
            if not low <= value <= high or value & (value - 1):
                raise InputError(f"the cache's {name} is {value}, a power of two from {low} to "
                                 f"{high} is needed")
        if not 1 <= self.outstanding <= _MAX_OUTSTANDING:
            raise InputError(f"the cache's outstanding is {self.outstanding}, the limits are 1 and "
                             f"{_MAX_OUTSTANDING}")
        if not self.pending < 1 << (self.sequence_bits - 1) <= 1 << 23:
            raise InputError(f"the cache's sequence_bits is {self.sequence_bits}, the limits are "
                             f"{self.pending.bit_length() + 1} and 24")

    @property
    def tile_height(self):
        """Rows of a tile, H."""
        return self.interpolation.tile_height

    @property
    def tile_bytes(self):
        """Bytes of samples in a tile."""
        return TILE_WIDTH * self.tile_height

    @property
    def tile_rows(self):
        """Rows of tiles in different banks, R."""
        return self.interpolation.tile_rows

    @property
    def tag_banks(self):
        """Number of tag banks: one for each parity of a tile's column and each row modulo R."""
        return 2 * self.tile_rows

    @property
    def bytes(self):
        """Bytes of samples in the cache."""
        return self.tiles * self.tile_bytes

    @property
    def options(self):
        """The options of ``ncdc generate`` that choose it."""
        usual = self.of_bytes(self.bytes, self.interpolation)
        return [f"--cache-bytes {self.bytes}",
                *(f"--cache-{name} {getattr(self, name)}" for name in ("pending", "outstanding")
                  if getattr(self, name) != getattr(usual, name))]

    @property
    def sets(self):
        """Tiles of each tag bank."""
        return self.tiles // self.tag_banks

    @property
    def max_split(self):
        """The largest ``split``: one row of sets."""
        return self.sets.bit_length() - 1

    @classmethod
    def for_width(cls, width, interpolation=FAST):
        """The smallest cache of 16 lines of a raw frame ``width`` samples wide: enough for a
        raster scan of a moderately rotated lens of up to 120 degrees."""
        tiles_across = 1 << max(0, (width - 1).bit_length() - (TILE_WIDTH - 1).bit_length())
        rows = _LINES // interpolation.tile_height
        return cls._sized(max(_MIN_TILES, rows * tiles_across), interpolation)

    @classmethod
    def of_bytes(cls, size, interpolation=FAST):
        """The cache of ``size`` bytes of samples.

        Raises
        ------
        InputError
            If that is no power of two, or outside the limits.
        """
        tile = TILE_WIDTH * interpolation.tile_height
        low, high = _MIN_TILES * tile, _MAX_TILES * tile
        if not low <= size <= high or size & (size - 1):
            raise InputError(f"the cache's size is {size} bytes, a power of two from {low} to "
                             f"{high} is needed")
        return cls._sized(size // tile, interpolation)

    @classmethod
    def _sized(cls, tiles, interpolation):
        """A cache of ``tiles`` tiles; the bytes outstanding do not depend on the tiles' height."""
        return cls(tiles=tiles, interpolation=interpolation,
                   outstanding=cls.outstanding * FAST.tile_height // interpolation.tile_height)

    def split_for(self, width):
        """The split with separate sets for each tile column of a raw frame ``width`` samples wide,
        or the largest."""
        pairs = -(-width // (2 * TILE_WIDTH))
        return min(self.max_split, (pairs - 1).bit_length())

    def check_split(self, split):
        """Return ``split``.

        Raises
        ------
        InputError
            If it is outside 0..max_split.
        """
        if not 0 <= split <= self.max_split:
            raise InputError(f"the cache's split is {split}, the limits are 0 and {self.max_split}")
        return split
