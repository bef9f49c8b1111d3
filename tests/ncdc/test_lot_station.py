"""``ncdc lot watch`` as a process: a real unit, a kill, Ctrl-C."""

from contextlib import closing

import pytest

from ncdc.cli.lot_run import database_at
from ncdc_bench.lot.processes import station
from ncdc_bench.lot.units import make_unit, write_photos

pytestmark = pytest.mark.longer
OPTIONS = "--neurons", "2", "--settle", "0.5", "--max-error", "20"


def arrive(folder, number):
    """Put a unit of one photo into a folder, as a program does that renames it when it is whole."""
    unit = make_unit(number)
    write_photos(folder.parent, unit)
    for more in ("1.png", "2.png"):
        (folder.parent / unit.serial / more).unlink()
    (folder.parent / unit.serial).rename(folder / unit.serial)
    return unit.serial


def test_a_station_is_killed_and_goes_on_and_ends_in_order(tmp_path):
    folder, lot = tmp_path / "photos", str(tmp_path / "lot")
    folder.mkdir()
    with station(folder, lot, *OPTIONS) as running:
        running.wait_for(("READY", "no unit yet"))
        first = arrive(folder, 3)
        running.wait_for(("PASS", first))
        second = arrive(folder, 4)
        running.wait_for(("WORKING", second))
    third = arrive(folder, 5)
    with station(folder, lot, *OPTIONS) as running:
        running.wait_for(("PASS", third))
        status, out, errors = running.interrupt()
    assert (status, out) == (0, "3 units: 3 pass, 0 to look at, 0 fail\n"), errors
    assert errors == f"{second}: pass\n{third}: pass\n"
    with closing(database_at(lot)) as database:
        units = [database.unit(serial) for serial in (first, second, third)]
    assert [unit["tries"] for unit in units] == [1, 2, 1]
