"""Choices of the gateware that change its size and speed, never its results."""

from dataclasses import dataclass

from ncdc_model.errors import InputError
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.geometry import check_strip_width

__all__ = ["FETCHERS", "FetchOptions", "FrontEndOptions", "HIDDEN", "LANES", "PRODUCTS"]

FETCHERS = ("cache", "multiport")

HIDDEN = ("multiply", "raster")
PRODUCTS = (27, 18)
LANES = (1, 2, 4)


@dataclass(frozen=True)
class FrontEndOptions:
    """How the network of the front end is built; every choice gives the same coordinates.

    Parameters
    ----------
    hidden : str
        "multiply": two multipliers per hidden neuron; "raster": one adder per hidden neuron,
        which follows the scan.
    share : int
        Hidden neurons that one tan-sigmoid serves in turn: one coordinate every ``share``
        clocks. The multipliers are shared likewise.
    products : int
        Bits of the device's multiplier blocks: 27 makes each product of the neurons one
        multiplication, 18 cuts it into parts that fit blocks of 18 x 18 bits.
    lanes : int
        Pixels per clock, 1, 2 or 4: neighbours of a row, each with a network of its own.

    Raises
    ------
    InputError
        If ``hidden``, ``products`` or ``lanes`` is none of the above, or ``share`` is not positive.
    """
    hidden: str = "multiply"
    share: int = 1
    products: int = 27
    lanes: int = 1

    def __post_init__(self):
        if self.hidden not in HIDDEN:
            raise InputError(f"hidden is {self.hidden!r}, one of {', '.join(HIDDEN)} is needed")
        if self.share < 1:
            raise InputError(f"share is {self.share}, the least is 1")
        if self.products not in PRODUCTS:
            raise InputError(f"products is {self.products}, one of "
                             f"{', '.join(map(str, PRODUCTS))} is needed")
        if self.lanes not in LANES:
            raise InputError(f"pixels per clock is {self.lanes}, one of "
                             f"{', '.join(map(str, LANES))} is needed")

    def units(self, hidden_neurons):
        """Tan-sigmoids of a network of ``hidden_neurons``.

        Raises
        ------
        InputError
            If there are fewer neurons than one tan-sigmoid could serve.
        """
        if self.share > hidden_neurons:
            raise InputError(f"share is {self.share}, the limit is the number of hidden neurons, "
                             f"{hidden_neurons}")
        return -(-hidden_neurons // self.share)


@dataclass(frozen=True)
class FetchOptions:
    """How raw windows are read; every choice gives the same windows.

    Parameters
    ----------
    fetcher : str
        "cache": a prefetching cache of tiles; "multiport": the paper's three burst readers.
    cache : CacheOptions
        Sizes of the cache; those of :meth:`CacheOptions.for_width` if absent.
    split : int
        Of the cache, after configuration; that of :meth:`CacheOptions.split_for` if absent.
    strip : int
        Columns of the strips in whose order pixels are made, after configuration; 0: a raster.

    Raises
    ------
    InputError
        If ``fetcher`` is none of the above, or there is no such strip.
    """
    fetcher: str = "cache"
    cache: CacheOptions | None = None
    split: int | None = None
    strip: int = 0

    def __post_init__(self):
        check_strip_width(self.strip)
        if self.fetcher not in FETCHERS:
            raise InputError(f"fetch is {self.fetcher!r}, one of {', '.join(FETCHERS)} is needed")

    def cache_for(self, geometry):
        """Sizes of the cache for a camera of ``geometry``."""
        return self.cache or CacheOptions.for_width(geometry.distorted_width)

    def split_for(self, geometry):
        """The cache's split for a camera of ``geometry``.

        Raises
        ------
        InputError
            If the cache has no such split.
        """
        cache = self.cache_for(geometry)
        if self.split is None:
            return cache.split_for(geometry.distorted_width)
        return cache.check_split(self.split)
