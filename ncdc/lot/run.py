"""Runs a lot: hands units to workers, judges what comes back, goes on where it was."""

from dataclasses import dataclass

from ncdc.lot.database import DIED, INTERRUPTED
from ncdc.lot.figures import judge
from ncdc.lot.work import Outcome

__all__ = ["Done", "SchedulerLost", "run_lot"]

_DEATHS = 3             # workers that a unit may end; from the second on it runs alone


class SchedulerLost(Exception):
    """The scheduler has gone, and with it the work in progress."""


@dataclass(frozen=True)
class Done:
    """A unit that was judged: its serial number, verdict, reasons, and seconds of work."""
    serial: str
    verdict: str
    reasons: list
    seconds: float


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
    def record(tag, outcome):
        serial, number = tag
        verdict = judge(outcome.figures, outcome.warnings, outcome.error, limits)
        if database.save(serial, number, outcome, verdict, request.seed):
            yield Done(serial, verdict[0], verdict[2], outcome.seconds)

    def work(units, slots):
        """Hand out ``units`` as workers become free, as many at a time as ``slots()``."""
        while True:
            while len(workers) < slots() and (unit := next(units, None)):
                serial, photos, deaths = unit
                tag = serial, database.start(serial, station)
                if tag[1] is None:
                    continue            # another station has it
                if deaths >= _DEATHS:
                    yield from record(tag, Outcome(error=(
                        f"the work on this unit ended its worker {deaths} times, at last alone: it "
                        f"crashed, or took longer than --timeout")))
                else:
                    workers.submit(tag, photos, request)
            if not len(workers):
                return
            for tag, outcome in workers.finished():
                if outcome is None:
                    database.end(*tag, DIED)
                else:
                    yield from record(tag, outcome)

    try:
        yield from work(database.waiting(suspects=False), lambda: workers.slots)
        while suspect := next(database.waiting(suspects=True), None):
            yield from work(iter([suspect]), lambda: 1)
    finally:
        for tag in workers.running:
            database.end(*tag, INTERRUPTED)
