"""The planner of a range of views: tile cache, scan and speed of the slowest one."""

from dataclasses import dataclass, replace
from functools import cache, partial
from math import ceil

import numpy as np

from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.plan import (
    CLOCK_MHZ,
    GAIN,
    Choice,
    Fixed,
    Plan,
    choose,
    clocks_limit,
    frame_figures,
    worth_timing,
)
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.traffic import distinct_bytes
from ncdc_spec.frames import check_format, output_format
from ncdc_spec.view import check_view_nodes
from ncdc_spec.view_matrix import Angles

__all__ = ["ViewPlan", "ViewPlanner"]

_MARGIN = .02           # of the clocks of the slowest view found: what the bound adds
_ROUNDS = 3             # choices of a cache, each for one more view
_TIMED = 4              # views with the largest estimates, whose clocks are predicted
_BLOCK = 1024           # look-ups in which the estimate has either memory or cache decide
_HALVINGS = 16          # of an interval in which a number of the estimate is


@dataclass(frozen=True)
class ViewPlan:
    """Predicted figures of a configuration for a range of views.

    Parameters
    ----------
    slowest : Plan
        Of the slowest view that was found.
    slowest_at : Angles
        That view.
    bytes_per_pixel : float
        Bytes read per pixel by the view that reads most.
    bytes_at : Angles
        That view.
    scanned : int
        Views of the range that were tried with the chosen cache.
    """
    slowest: Plan
    slowest_at: Angles
    bytes_per_pixel: float
    bytes_at: Angles
    scanned: int

    @property
    def hardware(self):
        """The hardware, with the chosen tile cache, split and scan."""
        return self.slowest.hardware

    @property
    def clocks_bound(self):
        """Clocks of a frame of any view of the range, at most: those of the slowest one found,
        and two hundredths for what the search has missed."""
        return ceil((1 + _MARGIN) * self.slowest.clocks)

    def report(self):
        """The figures under their names in every report; those of one view are the slowest's."""
        return self.slowest.report() | {
            "slowest_view": vars(self.slowest_at),
            "bound_clocks_per_pixel": self.clocks_bound / self.slowest.pixels,
            "most_bytes_read_per_pixel": self.bytes_per_pixel,
            "most_bytes_view": vars(self.bytes_at), "views_scanned": self.scanned}


class ViewPlanner:
    """Plans hardware for a range of views.

    Parameters
    ----------
    descriptor, memory, timing, clock_mhz
        As for :func:`ncdc_model.planner.plan.plan`.
    views : ViewRange

    Raises
    ------
    InputError
        If the network is evaluated at every pixel, or a value is outside its limits.
    """
    def __init__(self, descriptor, memory, timing, views, clock_mhz=CLOCK_MHZ):
        check_view_nodes(descriptor.nodes)
        self._descriptor, self._views, self._timing = descriptor, views, cache(timing)
        self._memory, self._clock_mhz = memory, clock_mhz
        self._model = memory_at(memory, clock_mhz)

    def plan(self, hardware, fixed=Fixed(), rate=None, progress=lambda fraction: None):
        """The :class:`ViewPlan`.

        A tile cache is chosen for few views, as :func:`ncdc_model.planner.plan.plan` chooses it for
        one. Then the slowest view of the range is searched for, and if it is slower than these, it
        becomes one of them.

        Parameters
        ----------
        hardware : Hardware
            With a view; the planner chooses its tile cache, split and strip.
        fixed, rate, progress
            As for :func:`ncdc_model.planner.plan.plan`.

        Raises
        ------
        InputError
            If the format would lose the camera's colours, or the slowest view does not reach the
            rate.
        """
        geometry = self._views.view(self._views.low).geometry(self._descriptor.geometry)
        check_format(output_format(hardware.format), geometry)
        limit = clocks_limit(geometry, hardware.lanes, self._clock_mhz, rate)
        known, made = [self._views.low], None
        for k in range(_ROUNDS):
            chosen, clocks = self._hardware_for(known, hardware, fixed, limit)
            found = self._slowest(chosen, known, lambda part: progress((k + part) / _ROUNDS))
            if made is None or found.slowest.clocks < GAIN * made.slowest.clocks:
                made = found
            if GAIN * found.slowest.clocks <= max(limit, clocks):
                break
            known.append(found.slowest_at)
        progress(1)
        made.slowest.check_rate(rate)
        return made

    def plan_of(self, angles, hardware):
        """The :class:`Plan` of one view, with the tile cache, split and strip of ``hardware``."""
        windows, geometry = self._map(angles)
        return Plan(hardware, self._memory, self._clock_mhz,
                    distinct=distinct_bytes(windows, geometry),
                    **frame_figures(windows, geometry, hardware, self._model,
                                    self._timing(hardware)))

    def _hardware_for(self, known, hardware, fixed, limit):
        """``hardware`` with a tile cache, a split and a scan for the views ``known``, and clocks of
        the slowest of them.

        It is the first of those to choose from that is fast enough for all of them, or the
        fastest.
        """
        best, least = None, np.inf
        for choice in worth_timing(self._choices(known, hardware, fixed)):
            clocks = max(self.plan_of(angles, choice.hardware).clocks for angles in known)
            if clocks <= limit or clocks < GAIN * least:
                best, least = choice.hardware, clocks
            if clocks <= limit:
                break
        return best, least

    def _choices(self, known, hardware, fixed):
        """As :func:`~ncdc_model.planner.plan.choose`, with the tiles of the worst view."""
        tiles, good = {}, {}
        for angles in known:
            windows, geometry = self._map(angles)
            distinct = distinct_bytes(windows, geometry)
            for choice in choose(windows, distinct, geometry, hardware, fixed):
                made = choice.hardware
                tiles[made] = max(tiles.get(made, 0), choice.misses)
                good[made] = good.get(made, True) and choice.good(distinct)
        return [Choice(made, tiles[made]) for made in sorted(tiles, key=lambda made: (
            (0, made.cache.tiles, tiles[made]) if good[made] else
            (1, tiles[made], made.cache.tiles)))]

    def _slowest(self, hardware, known, progress):
        """The :class:`ViewPlan` of ``hardware``, by a search of the range and of ``known``.

        Clocks are predicted of the view that reads most, and of those with the largest estimates,
        to which the estimate is then fitted. At last these views are varied.
        """
        plan, trace = (cache(partial(of, hardware=hardware)) for of in (self.plan_of, self._trace))
        scanned = self._views.scan()
        tried, timed = [*known, *scanned], list(known)
        for k, angles in enumerate(scanned):
            trace(angles)
            progress(k / len(scanned))
        timed.append(max(tried, key=lambda angles: trace(angles).misses))

        def estimated(angles):
            return estimate.clocks(trace(angles))

        for climbs in (False, False, True):
            estimate = _Estimate.of([(plan(angles), trace(angles)) for angles in timed])
            best = sorted(tried, key=estimated, reverse=True)[:_TIMED]
            timed += [self._views.climb(estimated, angles) for angles in best] if climbs else best
        at, most = (max(timed, key=lambda angles: getattr(plan(angles), name))
                    for name in ("clocks", "misses"))
        return ViewPlan(plan(at), at, plan(most).report()["bytes_read_per_pixel"], most,
                        trace.cache_info().currsize)

    def _map(self, angles):
        """Windows of a view, and the geometry with its size."""
        view = self._views.view(angles)
        return frame_windows(self._descriptor, view=view), view.geometry(self._descriptor.geometry)

    def _trace(self, angles, hardware):
        """The :class:`_Trace` of a view."""
        boxes = lookups(self._map(angles)[0], hardware.strip, hardware.lanes)
        return _Trace.of(misses(accesses(boxes), hardware.cache, hardware.split), len(boxes),
                         hardware.cache)


@dataclass(frozen=True)
class _Trace:
    """What an estimate needs of a view.

    Parameters
    ----------
    misses : int
        Tiles read.
    tiles : ndarray
        Tiles read in each block of look-ups.
    block, since : ndarray
        Of the misses of a slot that was in use a short while ago, or that seems so: number of the
        block, and look-ups since then.
    """
    misses: int
    tiles: np.ndarray
    block: np.ndarray
    since: np.ndarray

    @classmethod
    def of(cls, missed, count, options):
        """The trace of the :class:`Misses` of ``count`` look-ups in a cache of ``options``."""
        block, numbers = missed.lookup // _BLOCK, 1 << options.sequence_bits
        # The numbers of look-ups are modulo this: an old user may seem to be a recent one.
        since = 1 + (missed.lookup - 1 - np.maximum(missed.victim, 0)) % numbers
        near = since < options.pending
        return cls(len(missed), np.bincount(block, minlength=-(-count // _BLOCK)), block[near],
                   since[near])


@dataclass(frozen=True)
class _Estimate:
    """Clocks of a frame without the memory's rules: it says which views are worth a prediction.

    Parameters
    ----------
    tile_clocks : float
        Clocks in which the memory gives a tile.
    latency : float
        Look-ups after which the slot of a tile may be replaced.
    """
    tile_clocks: float
    latency: float

    @classmethod
    def of(cls, views):
        """The estimate of the (:class:`Plan`, :class:`_Trace`) of a few ``views``.

        It has the latency of the view that waits longest for slots, and the clocks of a tile of the
        one that reads most.
        """
        waits, waiting = max(views, key=lambda view: view[0].interlock)
        reads, reading = max(views, key=lambda view: view[0].misses)
        options = waits.hardware.cache
        estimate = cls(8 * options.tile_bytes / waits.hardware.data_width, 0)
        estimate = _fitted(estimate, "latency", options.pending,
                           lambda one: one._waits(waiting).sum() > waits.interlock)
        return _fitted(estimate, "tile_clocks", 64 * estimate.tile_clocks,
                       lambda one: one.clocks(reading) > reads.clocks)

    def _waits(self, trace):
        """Clocks of each near miss until its slot is free."""
        return np.maximum(self.latency - trace.since, 0)

    def clocks(self, trace):
        """Clocks of a frame: in each block either its look-ups or its tiles take the time."""
        waits = np.bincount(trace.block, self._waits(trace), minlength=len(trace.tiles))
        return float(np.maximum(self.tile_clocks * trace.tiles, _BLOCK + waits).sum())


def _fitted(estimate, name, high, too_large):
    """``estimate`` with the largest value of ``name``, up to ``high``, that is not too large."""
    low = getattr(estimate, name)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if too_large(replace(estimate, **{name: middle})) else (
            middle, high)
    return replace(estimate, **{name: low})
