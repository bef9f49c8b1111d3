"""Runs a lot: hands units to workers, judges what comes back, goes on where it was."""

import time
from dataclasses import dataclass

from ncdc.lot.database import DIED, INTERRUPTED
from ncdc.lot.figures import judge
from ncdc.lot.identity import identity
from ncdc.lot.work import Outcome

__all__ = ["Done", "REJECTED", "SchedulerLost", "run_lot", "watch_lot"]

REJECTED = "rejected"     # instead of an outcome: the worker has other software than it had
_DEATHS = 3             # workers that a unit may end; from the second on it runs alone
_LOOK = 0.5             # seconds between two looks at what has arrived


class SchedulerLost(Exception):
    """The scheduler has gone, and with it the work in progress."""


@dataclass(frozen=True)
class Done:
    """A unit that was judged: its serial number, verdict, reasons, and seconds of work.

    ``before``: its earlier verdict, if it was judged before and the photos of another unit have
    changed what is known of it; its last reason is the new one.
    """
    serial: str
    verdict: str
    reasons: list
    seconds: float
    before: str | None = None


def run_lot(database, workers, request, limits, station):
    """Yield :class:`Done` of every unit of a lot that waits.

    A unit whose worker dies waits until all others are judged. Then it runs alone: only what it
    does itself can end its worker again. If that happens, it fails.

    Parameters
    ----------
    database : ncdc.lot.database.Database
    workers : ncdc.lot.workers.Workers
    request : ncdc.lot.work.Request
    limits : dict
        See :func:`ncdc.lot.figures.judge`.
    station : str

    Raises
    ------
    SchedulerLost
        The units in progress wait again.
    """
    with _Work(database, workers, request, limits, station) as work:
        # A unit that came to another process than the one that was asked waits again.
        while next(database.waiting(suspects=False), None):
            yield from work.all_of(database.waiting(suspects=False))
        while suspect := next(database.waiting(suspects=True), None):
            yield from work.all_of(iter([suspect]))


def watch_lot(database, workers, request, limits, station, arrivals):
    """Yield :class:`Done` of every unit of a station, as its photos arrive; without an end.

    Units of other stations are left to them. A unit whose worker dies waits until the station has
    no other unit to work on, and then runs alone, as in :func:`run_lot`.

    Parameters
    ----------
    arrivals : callable
        Called every half second with the function that says which serial numbers are known; gives
        the new units.
    database, workers, request, limits, station
        Those of :func:`run_lot`.

    Raises
    ------
    SchedulerLost
        The units in progress wait again.
    """
    with _Work(database, workers, request, limits, station) as work:
        alone = False
        while True:
            if units := arrivals(database.known):
                database.add(units, station)
            if not alone or not len(workers):
                alone = False
                yield from work.start(database.waiting(suspects=False, station=station))
                if not len(workers):
                    suspect = next(database.waiting(suspects=True, station=station), None)
                    alone = suspect is not None
                    yield from work.start(iter([suspect] if alone else []))
            yield from work.finish(_LOOK)


class _Work:
    """Units that are handed to workers, and judged when they come back.

    At the end of a block the units that are still being worked on wait again.
    """

    def __init__(self, database, workers, request, limits, station):
        self.database, self.workers, self.station = database, workers, station
        self.request, self.limits = request, limits

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for tag in self.workers.running:
            self.database.end(*tag, INTERRUPTED)

    def all_of(self, units):
        """Hand out all ``units``; yield :class:`Done` of each. Without a worker it waits."""
        over = False
        while not over or len(self.workers):
            over = yield from self.start(units)
            if len(self.workers):
                yield from self.finish()
            elif not over:
                time.sleep(_LOOK)

    def start(self, units):
        """Hand out ``units`` while workers are free; yield :class:`Done` of those without hope.

        Returns whether there are no more units.
        """
        while len(self.workers) < self.workers.slots:
            if (unit := next(units, None)) is None:
                return True
            serial, photos, deaths = unit
            tag = serial, self.database.start(serial, self.station)
            if tag[1] is None:
                continue            # another station has it
            if deaths >= _DEATHS:
                yield from self._record(tag, Outcome(made_by=identity(), error=(
                    f"the work on this unit ended its worker {deaths} times, at last alone: it "
                    f"crashed, or took longer than --timeout")))
            else:
                self.workers.submit(tag, photos, self.request)
        return False

    def finish(self, seconds=None):
        """Wait for units, at most ``seconds``; yield :class:`Done` of those that are judged."""
        if not len(self.workers):
            time.sleep(seconds)
            return
        for tag, outcome in self.workers.finished(seconds):
            if outcome is None or outcome is REJECTED:
                self.database.end(*tag, INTERRUPTED if outcome else DIED)
            else:
                yield from self._record(tag, outcome)

    def _record(self, tag, outcome):
        serial, number = tag
        verdict = judge(outcome.figures, outcome.warnings, outcome.error, self.limits)
        for name, found, reasons, before in self.database.save(serial, number, outcome, verdict,
                                                               self.request.seed):
            yield Done(name, found, reasons, outcome.seconds, before)
