"""What the page of a station shows, from the database of its lot."""

import json
from datetime import UTC

from sqlalchemy import func, select

from ncdc.lot.figures import FAIL, LOOK, PASS, VERDICTS
from ncdc.lot.schema import FILES, UNITS

__all__ = ["READY", "WORKING", "state_of"]

READY, WORKING = "ready", "working"         # signs in addition to the verdicts

_RECENT, _BAD = 8, 3        # units of the station that are shown
_SHOWN = UNITS.c.serial, UNITS.c.verdict, UNITS.c.reasons, UNITS.c.judged, UNITS.c.seconds


def state_of(database, station):
    """The state of a ``station`` as a dict.

    Parameters
    ----------
    database : ncdc.lot.database.Database
    station : str

    Returns
    -------
    dict
        ``newest``: the unit that arrived last, which the sign is of; None if there is none.
        ``recent``: the units that were judged last. ``bad``: those of them that did not pass, or
        earlier ones. ``counts``: of the station, then of all if there are others; each with a
        ``title``, the numbers of :meth:`Database.counts`, and ``percent``, that of units that
        pass. A unit has ``serial``, ``sign`` (a verdict or WORKING), ``reasons``, ``time`` of its
        verdict, ``seconds`` of work, and whether it has a ``picture``.
    """
    mine = select(*_SHOWN).where(UNITS.c.station == station)
    judged = mine.where(UNITS.c.verdict.is_not(None)).order_by(UNITS.c.judged.desc())
    with database.engine.connect() as connection:
        newest = connection.execute(mine.order_by(UNITS.c.number.desc()).limit(1)).all()
        recent = connection.execute(judged.limit(_RECENT)).all()
        bad = connection.execute(judged.where(UNITS.c.verdict.in_([LOOK, FAIL])).limit(_BAD)).all()
        counts = connection.execute(select(UNITS.c.station, UNITS.c.verdict, func.count()).group_by(
            UNITS.c.station, UNITS.c.verdict)).all()
        pictures = set(connection.scalars(select(FILES.c.serial).where(
            FILES.c.name == "picture.jpg",
            FILES.c.serial.in_({row.serial for row in (*newest, *bad)}))))

    def units(rows):
        return [_unit(row, row.serial in pictures) for row in rows]
    shown = [_counts("this station", [row for row in counts if row[0] == station])]
    if any(row[0] != station for row in counts):
        shown.append(_counts("all stations", counts))
    return {"newest": (units(newest) or [None])[0], "recent": units(recent), "bad": units(bad),
            "counts": shown}


def _unit(row, picture):
    time = row.judged and row.judged.replace(tzinfo=UTC).astimezone().strftime("%H:%M:%S")
    return {"serial": row.serial, "sign": row.verdict or WORKING, "time": time or "",
            "reasons": json.loads(row.reasons or "[]"), "seconds": row.seconds, "picture": picture}


def _counts(title, rows):
    found = dict.fromkeys(("units", *VERDICTS), 0)
    for _, verdict, count in rows:
        found["units"] += count
        if verdict:
            found[verdict] += count
    judged = sum(found[name] for name in VERDICTS)
    return {"title": title, **found,
            "percent": f"{100 * found[PASS] / judged:.1f} %" if judged else "-"}
