"""The planner: cache, scan and speed of a trained map, before any Verilog exists."""

from dataclasses import dataclass, replace

from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.tags import accesses, miss_count, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.traffic import distinct_bytes, live_tiles, worst_span
from ncdc_model.planner.writes import frame_writes
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.frames import FrameAddresses, check_format, output_format
from ncdc_spec.geometry import MAX_SIZE, check_strip_width
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import FAST

__all__ = ["CACHE_BYTES", "CLOCK_MHZ", "Choice", "Fixed", "GAIN", "Plan", "STRIPS", "best_split",
           "check_positive", "choose", "clocks_limit", "frame_figures", "plan", "worth_timing"]

CACHE_BYTES = 8192, 16384, 32768, 65536     # sizes to try
LARGE_CACHE_BYTES = 131072                  # also for pictures that are wider than the hardware's
STRIPS = 64, 128, 256                       # widths to try in addition to raster
CLOCK_MHZ = 100.0

# Goals for bytes read over distinct bytes: a strip reads its neighbours' edges too.
_RASTER_GOAL, _STRIP_GOAL = 1.02, 1.15
_CLOCKS_GOAL = 1.02                         # clocks per pixel
_COUNT = {1: "one pixel", 2: "two pixels", 4: "four pixels"}
_TIMINGS = 4                                # choices whose clocks are predicted, at most

GAIN = .99
"""Of the clocks: a later choice must be that much faster."""


@dataclass(frozen=True)
class Fixed:
    """The user's values of what the planner chooses; None leaves it to the planner.

    Parameters
    ----------
    cache_bytes : int, optional
        Bytes of samples in the tile cache.
    split : int, optional
        Register CACHE_SPLIT.
    strip : int, optional
        Register STRIP_WIDTH; 0: a raster.
    pending, outstanding : int, optional
        As of :class:`CacheOptions`, whose defaults the planner takes.

    Raises
    ------
    InputError
        If there is no such tile cache, split or strip.
    """
    cache_bytes: int | None = None
    split: int | None = None
    strip: int | None = None
    pending: int | None = None
    outstanding: int | None = None

    def __post_init__(self):
        check_strip_width(self.strip or 0)
        sizes = self.caches()
        if self.split is not None and not sizes:
            raise InputError(f"the cache's split is {self.split}, the limits are 0 and "
                             f"{CacheOptions.of_bytes(CACHE_BYTES[-1]).max_split}")

    @property
    def everything(self):
        """Whether nothing is left to the planner."""
        return None not in (self.cache_bytes, self.split, self.strip)

    def caches(self, interpolation=FAST, width=0):
        """Tile caches to choose from for a corrected picture ``width`` pixels wide, the smallest
        first: list of CacheOptions."""
        there = (*CACHE_BYTES, LARGE_CACHE_BYTES) if width > MAX_SIZE else CACHE_BYTES
        sizes = [CacheOptions.of_bytes(size, interpolation) for size in
                 (there if self.cache_bytes is None else [self.cache_bytes])]
        if self.split is None:
            return self._deep(sizes)
        if self.cache_bytes is not None:
            sizes[0].check_split(self.split)
        return self._deep(cache for cache in sizes if 0 <= self.split <= cache.max_split)

    def _deep(self, caches):
        """List of ``caches`` with as many look-ups and tiles under way as are given."""
        given = {name: getattr(self, name) for name in ("pending", "outstanding")
                 if getattr(self, name) is not None}
        return [replace(cache, **given) for cache in caches]

    def strips(self, width, stream):
        """Widths of strips to choose from for a corrected picture ``width`` pixels wide.

        Raises
        ------
        InputError
            If strips are asked of a stream.
        """
        if self.strip is not None:
            if stream and self.strip:
                raise InputError(f"the strip width is {self.strip}, a video stream needs 0 "
                                 f"(raster)")
            return [self.strip]
        return [0, *(strip for strip in STRIPS if strip < width and not stream)]


@dataclass(frozen=True)
class Choice:
    """Hardware with a tile cache, a split and a scan, and the tiles that it reads for a frame."""
    hardware: Hardware
    misses: int

    @property
    def bytes_read(self):
        """Bytes read for a frame."""
        return self.misses * self.hardware.cache.tile_bytes

    def good(self, distinct):
        """Whether it reads little more than the ``distinct`` bytes."""
        return self.bytes_read <= (_STRIP_GOAL if self.hardware.strip else _RASTER_GOAL) * distinct


@dataclass(frozen=True)
class Plan:
    """Predicted figures of a configuration for a map and a memory.

    Parameters
    ----------
    hardware : Hardware
        With the chosen tile cache, split and scan.
    memory : str
    clock_mhz : float
    pixels, misses, clocks, interlock, credit, unhindered : int
        Figures of a frame: corrected pixels, tiles read, clocks, stall clocks, clocks without a
        wait for memory, see :class:`ncdc_model.planner.timing.Clocks`.
    distinct : int
        Bytes of the raw frame that are in any window.
    worst : float
        Bytes read per pixel in the worst 8192 consecutive pixels.
    live : int
        Bytes of the tiles between first and last use, at most.
    """
    hardware: Hardware
    memory: str
    clock_mhz: float
    pixels: int
    misses: int
    clocks: int
    interlock: int
    credit: int
    unhindered: int
    distinct: int
    worst: float
    live: int

    @property
    def clocks_per_pixel(self):
        """Clocks of a frame over its pixels."""
        return self.clocks / self.pixels

    @property
    def amplification(self):
        """Bytes read over distinct bytes."""
        return self.misses * self.hardware.cache.tile_bytes / max(1, self.distinct)

    @property
    def frames_per_second(self):
        """Frames per second at the plan's clock."""
        return self.clock_mhz * 1e6 / self.clocks

    def check_rate(self, rate):
        """Raise :class:`InputError` unless it corrects ``rate`` frames per second; None: any."""
        if rate is None or self.frames_per_second >= rate:
            return
        strip = self.hardware.strip
        scan = f"strips of {strip} columns" if strip else "raster scan"
        raise InputError(
            f"{self.frames_per_second:.1f} frames per second are predicted for a cache of "
            f"{self.hardware.cache.bytes} bytes in {scan} on {self.memory} at "
            f"{self.clock_mhz:g} MHz, {rate:g} are asked for")

    def report(self):
        """The figures under their names in every report."""
        hardware = self.hardware
        return {
            "cache_bytes": hardware.cache.bytes, "cache_split": hardware.split,
            "strip": hardware.strip, "scan": "strip" if hardware.strip else "raster",
            "memory": self.memory, "clock_mhz": self.clock_mhz, "data_width": hardware.data_width,
            "misses": self.misses,
            "predicted_clocks_per_pixel": self.clocks_per_pixel,
            "bytes_read_per_pixel": self.misses * hardware.cache.tile_bytes / self.pixels,
            "distinct_bytes_per_pixel": self.distinct / self.pixels,
            "amplification": self.amplification, "worst_bytes_per_pixel": self.worst,
            "live_bytes": self.live, "interlock_clocks": self.interlock,
            "credit_clocks": self.credit, "frames_per_second": self.frames_per_second}


def choose(windows, distinct, geometry, hardware, fixed=Fixed(), progress=lambda fraction: None):
    """Configurations of ``hardware`` for a map, the best first: list of :class:`Choice`.

    First come configurations that read little more than the distinct bytes (2 % more; 15 % in
    strips, whose edges are read twice), by cache size and then by bytes read. The others come
    after them, by bytes read.

    Parameters
    ----------
    windows : Windows
    distinct : int
        See :func:`ncdc_model.planner.traffic.distinct_bytes`.
    geometry : Geometry
    hardware : Hardware
    fixed : Fixed
        Chosen by the user.
    progress : callable
        Called with the fraction done.

    Raises
    ------
    InputError
        If strips are asked of a stream.
    """
    found, caches = [], fixed.caches(geometry.interpolation, geometry.corrected_width)
    strips = fixed.strips(geometry.corrected_width, hardware.stream)
    for k, strip in enumerate(strips):
        accessed = accesses(lookups(windows, strip))
        for j, cache in enumerate(caches):
            splits = range(cache.max_split + 1) if fixed.split is None else [fixed.split]
            found += [Choice(replace(hardware, cache=cache, split=split, strip=strip),
                             miss_count(accessed, cache, split)) for split in splits]
            progress((k * len(caches) + j + 1) / (len(strips) * len(caches)))

    def order(choice):
        tiles = choice.hardware.cache.tiles
        return (0, tiles, choice.misses) if choice.good(distinct) else (1, choice.misses, tiles)
    return sorted(found, key=order)


def plan(descriptor, hardware, memory, timing, *, fixed=Fixed(), clock_mhz=CLOCK_MHZ, rate=None,
         progress=lambda fraction: None):
    """:class:`Plan` of the first of :func:`choose` that needs at most 1.02 clocks per pixel (of
    each lane), or that corrects ``rate`` frames per second if given; else of the fastest.

    The frames are at their addresses after reset.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        The planner chooses its tile cache, split and strip; the format of the pixels is used.
    memory : str
        As for :func:`ncdc_model.planner.memory_timing.memory_timing`; ``sdram``, ``ddr3`` at
        the clock.
    timing : callable
        :class:`CorrectorTiming` of a corrector of this descriptor and a hardware: strips may need
        other units than a raster.
    fixed : Fixed
        Chosen by the user.
    clock_mhz : float
        The corrector's clock.
    rate : float, optional
        Frames per second.
    progress : callable
        Called with the fraction done.

    Raises
    ------
    InputError
        If a value is outside its limits, the format would lose the camera's colours, or no
        configuration reaches the rate.
    """
    model = memory_at(memory, clock_mhz)
    geometry = descriptor.geometry
    check_format(output_format(hardware.format), geometry)
    limit = clocks_limit(geometry, hardware.lanes, clock_mhz, rate)
    windows = frame_windows(descriptor, lambda done, total: progress(.5 * done / total))
    distinct = distinct_bytes(windows, geometry)
    choices = choose(windows, distinct, geometry, hardware, fixed,
                     lambda fraction: progress(.5 + .2 * fraction))
    made = None
    for k, choice in enumerate(worth_timing(choices)):
        found = frame_figures(
            windows, geometry, choice.hardware, model, timing(choice.hardware),
            lambda done, total: progress(.7 + .3 * (k + done / total) / _TIMINGS))
        fast = found["clocks"] <= limit
        if made is None or fast or found["clocks"] < GAIN * made.clocks:
            made = Plan(choice.hardware, memory, clock_mhz, distinct=distinct, **found)
        if fast:
            break
    progress(1)
    made.check_rate(rate)
    return made


def check_positive(rate):
    """Raise :class:`InputError` if a ``rate`` in frames per second is not positive; None: any."""
    if rate is not None and not rate > 0:
        raise InputError(f"the rate is {rate:g} frames per second, it must be positive")


def clocks_limit(geometry, lanes, clock_mhz, rate):
    """Largest acceptable number of clocks of a frame.

    Raises
    ------
    InputError
        If the rate is not positive, or a pixel per clock and lane is not fast enough.
    """
    check_positive(rate)
    pixels = geometry.corrected_width * geometry.corrected_height
    limit = _CLOCKS_GOAL * pixels / lanes if rate is None else clock_mhz * 1e6 / rate
    if limit < pixels / lanes:
        raise InputError(f"{rate:g} frames per second are asked for, {_COUNT[lanes]} per clock "
                         f"{'give' if lanes > 1 else 'gives'} "
                         f"{clock_mhz * 1e6 * lanes / pixels:.1f} at {clock_mhz:g} MHz")
    return limit


def frame_figures(windows, geometry, hardware, memory, timing,
                  progress=lambda done, total: None):
    """Figures of a frame, under their names in :class:`Plan`.

    Parameters
    ----------
    windows : Windows
    geometry : Geometry
        With the size of the corrected picture that the windows are of.
    hardware : Hardware
        With a tile cache, a split and a scan.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    progress : callable
        Called with (misses done, misses).
    """
    addresses = FrameAddresses.after_reset(geometry, hardware.data_width)
    boxes = lookups(windows, hardware.strip, hardware.lanes)
    accessed = accesses(boxes)
    missed = misses(accessed, hardware.cache, hardware.split)
    writes = None if hardware.stream else frame_writes(
        geometry, hardware, getattr(memory, "access_bytes", 1), addresses.target, timing)
    clocks = predict_clocks(missed, boxes, hardware, memory, timing, addresses, writes, progress)
    return {"pixels": boxes.pixels, "misses": len(missed), "clocks": clocks.clocks,
            "interlock": clocks.interlock, "credit": clocks.credit,
            "unhindered": clocks.unhindered,
            "worst": worst_span(missed, len(boxes), hardware.cache.tile_bytes),
            "live": live_tiles(accessed) * hardware.cache.tile_bytes}


def worth_timing(choices):
    """The best choice of each size and scan, in order, a few at most: those that read more are
    slower."""
    best = {}
    for choice in choices:
        best.setdefault((choice.hardware.cache.tiles, choice.hardware.strip), choice)
    return list(best.values())[:_TIMINGS]


def best_split(descriptor, hardware):
    """The split of the tile cache of ``hardware`` that reads the fewest tiles for ``descriptor``;
    the default one if several do."""
    accessed = accesses(lookups(frame_windows(descriptor), hardware.strip, hardware.lanes))
    own = hardware.split_for(descriptor.geometry)
    return min(range(hardware.cache.max_split + 1),
               key=lambda split: (miss_count(accessed, hardware.cache, split), split != own))
