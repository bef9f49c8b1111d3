"""Verdicts and figures of a lot compared with the truth about its units."""

from dataclasses import replace

import numpy as np
from sqlalchemy import func, select

from ncdc.cli.lot_run import database_at
from ncdc.lot.database import JUDGED
from ncdc.lot.schema import TRIES
from ncdc_bench.lot.units import SIZE
from ncdc_model.flaw_figures import axis_pixel, effect, focal_length, tilt
from ncdc_model.lens import BrownWeng

__all__ = ["compared"]

# The figure that each kind of flaw shows in, and its true value.
_TRUTHS = {
    "short lens": ("focal_px", lambda unit: focal_length(unit.camera)),
    "off axis": ("axis_px", lambda unit: float(np.hypot(
        *(axis_pixel(unit.camera) - (np.array(SIZE) - 1) / 2)))),
    "decentred": ("decentring_px", lambda unit: effect(unit.camera, replace(
        unit.camera, decentring=BrownWeng()))),
    "tilted": ("tilt_deg", lambda unit: tilt(unit.camera)),
    "aspect": ("aspect", lambda unit: unit.camera.aspect),
    "rolled": ("roll_deg", lambda unit: unit.roll_deg),
}


def compared(lot, units):
    """Report on the lot in the folder ``lot`` of the :class:`TrueUnit` objects ``units``.

    ``passed_bad``, ``failed_good``, ``looked_at_good``; ``mixed``, units whose photos another one
    has as well, which are bad too; ``lost``, units without a verdict;
    ``repeated``, those judged twice; ``resumed``, those judged at their second try or later;
    ``flaws``: of each kind the largest difference of figure and truth in percent of the truth.
    """
    database = database_at(str(lot))
    rows = {row["serial"]: row for row in database.rows()}
    with database.engine.connect() as connection:
        ends = connection.execute(select(TRIES.c.serial, func.count()).where(
            TRIES.c.end == JUDGED).group_by(TRIES.c.serial)).all()
        again = connection.scalar(select(func.count(TRIES.c.serial.distinct())).where(
            TRIES.c.number > 1))
    database.close()
    mixed = {unit.other.serial for unit in units if unit.kind == "duplicate photos"}
    good = [unit for unit in units if not unit.kind and unit.serial not in mixed]
    verdicts = [rows[unit.serial]["verdict"] for unit in good if unit.serial in rows]
    missed = [f"{unit.serial}, {unit.kind or 'its photos are those of another unit'}"
              for unit in units if (unit.kind or unit.serial in mixed)
              and rows.get(unit.serial, {}).get("verdict") == "pass"]
    flaws = _flaws(rows, units)
    return {"units": len(units), "good": len(good), "mixed": len(mixed),
            "passed_bad": len(missed), "missed": missed,
            "failed_good": verdicts.count("fail"), "looked_at_good": verdicts.count("look"),
            "resumed": again, "repeated": sum(count > 1 for _, count in ends),
            "lost": len(units) - len(rows), "flaws": flaws,
            "worst_flaw_percent": max(flaws.values(), default=None)}


def _flaws(rows, units):
    found = {}
    for unit in units:
        if unit.kind in _TRUTHS:
            name, truth = _TRUTHS[unit.kind]
            value, true = rows.get(unit.serial, {}).get(name), truth(unit)
            if value is not None:
                off = 100 * abs(abs(value) - abs(true)) / abs(true)
                found[unit.kind] = max(found.get(unit.kind, 0.0), off)
    return found
