"""``ncdc lot`` on PostgreSQL, Debian's: two stations at once."""

import os
import shutil
import socket
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from lots import begun, driven, outcome, together

pytestmark = pytest.mark.longer
PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
UNITS = 60


@pytest.fixture
def server():
    """Address of an empty database, on a server that ends with the test."""
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
    run("pg_ctl", "-w", "-l", folder / "log", "start", "-o",
        f"-p {port} -k {folder} -c listen_addresses=127.0.0.1 -c fsync=off")
    yield f"postgresql+psycopg://postgres@127.0.0.1:{port}/postgres"
    run("pg_ctl", "-m", "immediate", "stop")
    shutil.rmtree(folder)


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
