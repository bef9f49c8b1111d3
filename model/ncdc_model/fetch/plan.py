"""The planner: cache, scan and speed of a trained map, before any Verilog exists."""

from dataclasses import dataclass
from itertools import islice

from ncdc_model.errors import InputError
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.lookups import frame_windows, lookups
from ncdc_model.fetch.tags import accesses, misses
from ncdc_model.fetch.timing import predict_clocks
from ncdc_model.fetch.traffic import TILE_BYTES, distinct_bytes, live_tiles, worst_span
from ncdc_model.fetch.writes import frame_writes
from ncdc_model.geometry import check_strip_width
from ncdc_model.memory_timing import memory_timing

__all__ = ["CACHE_BYTES", "CLOCK_MHZ", "Choice", "Plan", "STRIPS", "candidates", "choose",
           "plan"]

CACHE_BYTES = 8192, 16384, 32768, 65536     # sizes that are tried
STRIPS = 64, 128, 256                       # widths that are tried, besides raster
CLOCK_MHZ = 100.0

# Bytes read over distinct bytes that a choice may cost: a strip reads its neighbours' edges too.
_RASTER_GOAL, _STRIP_GOAL = 1.02, 1.15
_CLOCKS_GOAL = 1.02                         # clocks per pixel
_COUNT = {1: "one pixel", 2: "two pixels", 4: "four pixels"}
_GAIN = .99                                 # of the clocks, by a choice further back
_TIMINGS = 4                                # choices whose clocks are predicted, at most


@dataclass(frozen=True)
class Choice:
    """A cache, its split and a scan, and how many tiles it reads for a frame."""
    options: CacheOptions
    split: int
    strip: int
    misses: int

    @property
    def amplification_goal(self):
        """What reads may cost at most, over distinct bytes."""
        return _STRIP_GOAL if self.strip else _RASTER_GOAL


@dataclass(frozen=True)
class Plan:
    """What a configuration makes of a map on a memory.

    Parameters
    ----------
    options : CacheOptions
    split, strip : int
        Registers CACHE_SPLIT and STRIP_WIDTH.
    memory : str
    clock_mhz : float
    data_width : int
    pixels, misses, clocks, interlock, credit : int
        Of a frame: corrected pixels, tiles read, clocks, clocks waited, see
        :class:`ncdc_model.fetch.timing.Clocks`.
    distinct : int
        Bytes of the raw frame that some window holds.
    worst : float
        Bytes read per pixel in the worst 8192 pixels in a row.
    live : int
        Bytes of the tiles between first and last use, at most.
    """
    options: CacheOptions
    split: int
    strip: int
    memory: str
    clock_mhz: float
    data_width: int
    pixels: int
    misses: int
    clocks: int
    interlock: int
    credit: int
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
        return self.misses * TILE_BYTES / max(1, self.distinct)

    @property
    def frames_per_second(self):
        """At the plan's clock."""
        return self.clock_mhz * 1e6 / self.clocks

    def report(self):
        """The figures under their names in every report."""
        return {
            "cache_bytes": self.options.bytes, "cache_split": self.split, "strip": self.strip,
            "scan": "strip" if self.strip else "raster", "memory": self.memory,
            "clock_mhz": self.clock_mhz, "data_width": self.data_width, "misses": self.misses,
            "predicted_clocks_per_pixel": self.clocks_per_pixel,
            "bytes_read_per_pixel": self.misses * TILE_BYTES / self.pixels,
            "distinct_bytes_per_pixel": self.distinct / self.pixels,
            "amplification": self.amplification, "worst_bytes_per_pixel": self.worst,
            "live_bytes": self.live, "interlock_clocks": self.interlock,
            "credit_clocks": self.credit, "frames_per_second": self.frames_per_second}


def candidates(width, *, stream, cache_bytes=None, split=None, strip=None):
    """(sizes, strips) among which :func:`choose` chooses: lists of CacheOptions and of widths.

    Parameters
    ----------
    width : int
        Of the corrected picture.
    stream : bool
        Whether pixels go to a stream, which takes raster order only.
    cache_bytes, split, strip : int, optional
        Fixed instead of chosen.

    Raises
    ------
    InputError
        If a fixed value is outside its limits, or strips are asked of a stream.
    """
    if stream and strip:
        raise InputError(f"the strip width is {strip}, a video stream needs 0 (raster)")
    check_strip_width(strip or 0)
    sizes = list(map(CacheOptions.of_bytes,
                     CACHE_BYTES if cache_bytes is None else [cache_bytes]))
    if split is not None:
        sizes[-1].check_split(split)
        sizes = [options for options in sizes if split <= options.max_split]
    strips = [strip] if strip is not None else [0, *(s for s in STRIPS if s < width and not stream)]
    return sizes, strips


def choose(windows, distinct, sizes, strips, split=None, progress=lambda fraction: None):
    """Configurations for a map, the best first: list of :class:`Choice`.

    The smallest cache comes first that reads little more than the distinct bytes (2 % more; 15 %
    in strips, whose edges are read twice); of one size, what reads least. Those that read more
    follow, by what they read.

    Parameters
    ----------
    windows : Windows
    distinct : int
        See :func:`ncdc_model.fetch.traffic.distinct_bytes`.
    sizes, strips : list
        Of :func:`candidates`.
    split : int, optional
        Fixed instead of chosen.
    progress : callable
        Called with the fraction done.
    """
    found = []
    for k, strip in enumerate(strips):
        accessed = accesses(lookups(windows, strip))
        for j, options in enumerate(sizes):
            splits = range(options.max_split + 1) if split is None else [split]
            found += [Choice(options, s, strip, len(misses(accessed, options, s))) for s in splits]
            progress((k * len(sizes) + j + 1) / (len(strips) * len(sizes)))

    def order(choice):
        good = choice.misses * TILE_BYTES <= choice.amplification_goal * distinct
        return ((0, choice.options.tiles, choice.misses) if good
                else (1, choice.misses, choice.options.tiles))
    return sorted(found, key=order)


def plan(descriptor, *, memory="ddr3", clock_mhz=CLOCK_MHZ, data_width=32, lanes=1, stream=False,
         cache_bytes=None, split=None, strip=None, rate=None, base=0, pitch=None, target=None,
         progress=lambda fraction: None):
    """:class:`Plan` of the first of :func:`choose` that needs at most 1.02 clocks per pixel (of
    each lane), or that corrects ``rate`` frames per second if that is given; else of the fastest.

    Parameters
    ----------
    descriptor : Descriptor
    memory : str
        Of :func:`ncdc_model.memory_timing.memory_timing`; ``sdram`` and ``ddr3`` at ``clock_mhz``.
    clock_mhz : float
        The corrector's clock.
    data_width : int
        Bits of the memory port: 32, 64 or 128.
    lanes : int
        Pixels per clock: 1, 2 or 4.
    stream, cache_bytes, split, strip :
        As of :func:`candidates`.
    rate : float, optional
        Frames per second.
    base, pitch, target : int
        Addresses of the raw and of the corrected frame and the bytes from one raw row to the next;
        by default the rows, and the frames, follow each other as closely as the port allows.
    progress : callable
        Called with the fraction done.

    Raises
    ------
    InputError
        If a value is outside its limits, or no configuration holds the map at the rate.
    """
    timing = memory_timing(f"{memory}@{clock_mhz:g}" if memory in ("sdram", "ddr3") else memory)
    if rate is not None and not rate > 0:
        raise InputError(f"the rate is {rate:g} frames per second, it must be positive")
    geometry = descriptor.geometry
    word = data_width // 8
    pitch = pitch or -(-geometry.distorted_width // word) * word
    target = base + pitch * geometry.distorted_height if target is None else target
    width, height = geometry.corrected
    pixels = width * height
    limit = _CLOCKS_GOAL * pixels / lanes if rate is None else clock_mhz * 1e6 / rate
    if limit < pixels / lanes:
        raise InputError(f"{rate:g} frames per second are asked for, {_COUNT[lanes]} per clock "
                         f"{'give' if lanes > 1 else 'gives'} "
                         f"{clock_mhz * 1e6 * lanes / pixels:.1f} at {clock_mhz:g} MHz")
    sizes, strips = candidates(width, stream=stream, cache_bytes=cache_bytes, split=split,
                               strip=strip)
    windows = frame_windows(descriptor, lambda done, total: progress(.5 * done / total))
    distinct = distinct_bytes(windows, geometry)
    choices = choose(windows, distinct, sizes, strips, split,
                     lambda fraction: progress(.5 + .2 * fraction))
    made = None
    for k, choice in enumerate(islice(_worth_timing(choices), _TIMINGS)):
        boxes = lookups(windows, choice.strip, lanes)
        accessed = accesses(boxes)
        missed = misses(accessed, choice.options, choice.split)
        writes = None if stream else frame_writes(
            width, height, choice.strip, data_width, getattr(timing, "access_bytes", 1), target)
        clocks = predict_clocks(missed, boxes, choice.options, timing, data_width, base=base,
                                pitch=pitch, writes=writes,
                                progress=lambda done, total: progress(
                                    .7 + .3 * (k + done / total) / _TIMINGS))
        fast = clocks.clocks <= limit
        if made is None or fast or clocks.clocks < _GAIN * made.clocks:
            made = Plan(choice.options, choice.split, choice.strip, memory, clock_mhz, data_width,
                        pixels, len(missed), clocks.clocks, clocks.interlock, clocks.credit,
                        distinct, worst_span(missed, len(boxes)), live_tiles(accessed) * TILE_BYTES)
        if fast:
            break
    progress(1)
    if rate is not None and made.frames_per_second < rate:
        scan = f"strips of {made.strip} columns" if made.strip else "raster scan"
        raise InputError(
            f"{made.frames_per_second:.1f} frames per second are predicted for a cache of "
            f"{made.options.bytes} bytes in {scan} on {memory} at {clock_mhz:g} MHz, "
            f"{rate:g} are asked for")
    return made


def _worth_timing(choices):
    """The best of each size and scan, in order: of one size and scan, what reads more is slower."""
    seen = set()
    for choice in choices:
        key = choice.options.tiles, choice.strip
        if key not in seen:
            seen.add(key)
            yield choice

