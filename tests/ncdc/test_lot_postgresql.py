"""``ncdc lot`` on PostgreSQL, Debian's: two stations at once."""

import os
import shutil
import socket
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import psycopg
import pytest
from sqlalchemy.exc import OperationalError

from lots import begun, driven, outcome, together

pytestmark = pytest.mark.longer
PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
UNITS = 60


@pytest.fixture
def running():
    """An empty database on a server that ends with the test: its ``address``, and functions that
    ``start`` and ``stop`` the server."""
    if not PROGRAMS:
        pytest.skip("apt install postgresql")
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    # The server runs under no root account, and its socket's path has to be short.
    user = ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"]
    user = user if os.getuid() == 0 else []
    folder = Path(tempfile.mkdtemp(prefix="pg-", dir="/tmp"))
    if user:
        shutil.chown(folder, "postgres")

    def run(program, *arguments):
        subprocess.run([*user, PROGRAMS[-1] / program, "-D", folder / "data", *arguments],
                       check=True, stdout=subprocess.DEVNULL, cwd=folder)
    run("initdb", "--no-sync", "-A", "trust", "-U", "postgres")

    def start():
        run("pg_ctl", "-w", "-l", folder / "log", "start", "-o",
            f"-p {port} -k {folder} -c listen_addresses=127.0.0.1 -c fsync=off")

    def stop():
        run("pg_ctl", "-m", "immediate", "stop")
    start()
    yield SimpleNamespace(address=f"postgresql+psycopg://postgres@127.0.0.1:{port}/postgres",
                          start=start, stop=stop)
    if (folder / "data/postmaster.pid").exists():
        stop()
    shutil.rmtree(folder)


@pytest.fixture
def server(running):
    """Address of the database."""
    return running.address


def test_two_stations_at_once_judge_every_unit_once(server):
    for database in together(lambda number: begun(server, station=f"station {number}"), 6):
        assert database.counts()["units"] == 6
        database.close()
    begun(server, UNITS).close()

    def station(name):
        return driven(begun(server, UNITS, name), lambda *tag: outcome(), station=name)
    with ThreadPoolExecutor(2) as pool:
        (one, lost_one), (two, lost_two) = pool.map(station, ("one", "two"))
    assert not lost_one and not lost_two and one and two
    serials = [done.serial for done in (*one, *two)]
    assert sorted(serials) == sorted(f"U{k}" for k in range(1, UNITS + 1))
    database = begun(server, UNITS)
    assert database.counts() == {"units": UNITS, "pass": UNITS, "look": 0, "fail": 0}
    rows = list(database.rows())
    assert [row["serial"] for row in rows] == [f"U{k}" for k in range(1, UNITS + 1)]
    assert {row["focal_px"] for row in rows} == {171.0}
    assert database.picture("U9") == b"jpeg" and database.unit("U9")["tries"] == 1
    database.close()


def test_a_connection_that_is_lost_is_tried_again(running, capsys):
    """The server goes while units are judged, and comes back after a second."""
    database, back = begun(running.address, 4), []

    def answer(serial, number):
        if serial == "U2":
            running.stop()
            back.append(threading.Timer(1, running.start))
            back[0].start()
        return outcome()
    done, lost = driven(database, answer, slots=1)
    back[0].join()
    assert [one.serial for one in done] == ["U1", "U2", "U3", "U4"] and not lost
    assert database.counts()["pass"] == 4
    assert [database.unit(f"U{k}")["tries"] for k in range(1, 5)] == [1] * 4
    said = capsys.readouterr().err
    assert "the database does not answer (" in said and "trying again for 60 s" in said
    assert said.count("the database answers again") >= 1
    running.stop()
    database.retry = 1.5
    start = time.monotonic()
    with pytest.raises(OperationalError):
        database.counts()
    assert 1 < time.monotonic() - start < 20
    start = time.monotonic()
    with pytest.raises(OperationalError):           # what ends the command does not wait again
        database.unit("U1")
    assert time.monotonic() - start < 1
    database.close()


def test_a_transaction_whose_end_was_not_confirmed_is_done_once(running, monkeypatch):
    """The connection goes between the commit and its confirmation."""
    database = begun(running.address, 2)
    number = database.start("U1", "bench")
    confirmed = database.engine.dialect.do_commit

    def unconfirmed(connection):
        confirmed(connection)
        monkeypatch.undo()
        raise OperationalError("COMMIT", None, psycopg.OperationalError("the connection is lost"))
    monkeypatch.setattr("ncdc.lot.database._PAUSE", .01)

    def lose_the_next():
        monkeypatch.setattr(database.engine.dialect, "do_commit", unconfirmed)
    lose_the_next()
    assert [(serial, verdict) for serial, verdict, *_ in database.save(
        "U1", number, outcome(), ("pass", "", []), 0)] == [("U1", "pass")]
    lose_the_next()
    assert database.start("U2", "bench") == 1 and database.start("U2", "bench") is None
    assert database.unit("U2")["tries"] == 1 and database.counts()["pass"] == 1
    database.close()
