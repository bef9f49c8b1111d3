"""Lots whose work is scripted: what the driver and the database make of it."""

from concurrent.futures import ThreadPoolExecutor
from itertools import count as counted
from threading import Barrier

from ncdc.lot.database import Database
from ncdc.lot.figures import FIGURES, LIMITS
from ncdc.lot.identity import identity
from ncdc.lot.run import SchedulerLost, run_lot
from ncdc.lot.units import Unit
from ncdc.lot.work import Outcome, Request

__all__ = ["GOOD", "Scripted", "begun", "driven", "outcome", "together"]

GOOD = {"points": 1100, "photos_used": 3, "coverage_percent": 99.0, "neurons": 6,
        "max_error_px": 0.2, "mean_error_px": 0.02, "straightness_px": 0.02, "focal_px": 171.0,
        "axis_px": 1.0, "decentring_px": 0.3, "tilt_deg": 0.0, "roll_deg": -0.2,
        "aspect": 1.0, "uneven_px": 0.02, "disagreement_px": 0.002, "blur_ratio": 1.02}
assert GOOD.keys() == {figure.name for figure in FIGURES}
GOOD |= {"focal_px_error": 0.1, "axis_px_error": 0.05, "decentring_px_error": 0.02,
         "tilt_deg_error": 0.1, "roll_deg_error": 0.01, "aspect_error": 0.0002}
_REQUEST = Request(target="dots", neurons=6)
_OPTIONS = {**vars(_REQUEST), **LIMITS}
_PHOTOS = counted()         # no two units have a photo in common


def outcome(**figures):
    """:class:`Outcome` of a good unit with other ``figures``."""
    return Outcome(figures=GOOD | figures, descriptor="version = 1\n", digest="0123456789ab",
                   photo_hashes=[f"{next(_PHOTOS):064x}"], picture=b"jpeg", seconds=2.0,
                   worker="bench", made_by=identity())


class Scripted:
    """Workers in one process; ``answer(serial, try)`` gives an outcome, None for a death of the
    worker, or raises :class:`SchedulerLost`. A death takes the other units on the worker along."""

    def __init__(self, answer, slots=2):
        self.answer, self.slots, self._running, self.most = answer, slots, [], 0

    def __len__(self):
        return len(self._running)

    @property
    def running(self):
        return list(self._running)

    def submit(self, tag, photos, request):
        self._running.append(tag)
        self.most = max(self.most, len(self))

    def finished(self, seconds=None):
        tag = self._running[0]
        answer = self.answer(*tag)
        if answer is None:
            dead, self._running = self._running, []
            return [(tag, None) for tag in dead]
        self._running.pop(0)
        return [(tag, answer)]


def begun(where, count=6, station="bench", **limits):
    """:class:`Database` of a lot of ``count`` units U1, U2, ..., in the folder or at the address
    ``where``; its options have other ``limits``."""
    where = str(where)
    database = Database(where if "://" in where else f"sqlite:///{where}/lot.db", create=True)
    units = [Unit(f"U{k}", (f"/photos/{k}.png",)) for k in range(1, count + 1)]
    database.begin(_OPTIONS | limits, units, station)
    return database


def together(work, count):
    """List of ``work(number)`` of ``count`` threads, all of which begin at one moment."""
    barrier = Barrier(count)

    def waited(number):
        barrier.wait()
        return work(number)
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(waited, range(count)))


def driven(database, answer, slots=2, station="bench"):
    """The units that a run judges, and whether the scheduler was lost."""
    done = []
    try:
        for one in run_lot(database, Scripted(answer, slots), _REQUEST, LIMITS, station):
            done.append(one)
    except SchedulerLost:
        return done, True
    return done, False
