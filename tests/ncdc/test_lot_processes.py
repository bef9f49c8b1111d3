"""``ncdc lot`` on real worker processes: kills, and the same networks everywhere."""

import json
import os
import signal
import threading
import time

import pytest

from ncdc.cli import main
from ncdc.lot.run import SchedulerLost
from ncdc.lot.work import Request
from ncdc.lot.workers import connect
from ncdc_bench.lot.processes import cluster
from ncdc_bench.lot.units import make_unit, write_photos

pytestmark = [pytest.mark.longer, pytest.mark.filterwarnings("ignore::DeprecationWarning")]
REQUEST = Request("dots", neurons=2, bayer="MONO")


@pytest.fixture
def units(tmp_path):
    """Photos of two units, one each, by serial number."""
    for number in (3, 4):
        write_photos(tmp_path, make_unit(number))
    return {serial: [str(tmp_path / serial / "0.png")] for serial in ("U0003", "U0004")}


def test_a_unit_that_hangs_ends_its_worker(units):
    photos = units["U0003"]
    with connect(count=1, limit=.5) as workers:
        workers.client.run(_hang)
        submitted(workers, "hangs", photos, REQUEST)
        assert workers.finished() == [("hangs", None)]
        workers.limit = 600
        submitted(workers, "again", photos, REQUEST)
        [(tag, again)] = workers.finished()
    assert tag == "again" and again.digest


def submitted(workers, tag, photos, request):
    """Submit a unit as soon as a worker is free, within a minute."""
    for _ in range(600):
        if len(workers) < workers.slots:
            return workers.submit(tag, photos, request)
        time.sleep(.1)
    raise TimeoutError


def _hang():
    import ncdc.lot.workers
    ncdc.lot.workers.process = lambda photos, request: threading.Event().wait()


def test_three_processes_started_apart_give_the_same_networks(units):
    """A scheduler and two workers; on this machine a worker ends while it works."""
    here, there, photos = {}, {}, units["U0003"]
    with connect(count=1) as workers:
        workers.client.run(_hang)
        submitted(workers, "here", photos, REQUEST)
        # The worker ends while it works: its unit comes back without an outcome.
        [pid] = workers.client.run(os.getpid).values()
        os.kill(pid, signal.SIGKILL)
        assert workers.finished() == [("here", None)]
        for serial in units:
            submitted(workers, serial, units[serial], REQUEST)
            here.update(workers.finished())
    with cluster(2) as processes, connect(processes.address) as workers:
        workers.client.wait_for_workers(2, timeout=60)
        assert workers.slots == 2
        for serial in units:
            submitted(workers, serial, units[serial], REQUEST)
        assert busy(workers.client)
        while len(workers):
            there.update(workers.finished())
        workers.client.run(_hang)
        submitted(workers, "lost", photos, REQUEST)
        processes.scheduler.kill()
        with pytest.raises(SchedulerLost):
            workers.finished()
        assert workers.running == ["lost"]
    assert here["U0003"].descriptor != here["U0004"].descriptor
    for serial in units:
        one, other = here[serial], there[serial]
        assert not one.error and one.descriptor == other.descriptor
        assert one.photo_hashes == other.photo_hashes and one.figures == other.figures


def busy(client):
    """Whether two workers have a unit each, within five seconds."""
    for _ in range(100):
        if sorted(len(keys) for keys in client.processing().values()) == [1, 1]:
            return True
        time.sleep(.05)
    return False


@pytest.mark.regress
@pytest.mark.timeout(3600)
def test_a_lot_of_bad_units_that_is_killed_three_times(tmp_path, capsys):
    """Each way to be bad once, and four good units."""
    assert main(["bench", "lot", "--units", "12", "--bad", "8", "--kill", "--json", "-",
                 "--folder", str(tmp_path)]) == 0
    [row] = json.loads(capsys.readouterr().out)["rows"]
    assert row["kills"] == 3 and row["resumed"] >= 1
    assert [row[name] for name in ("passed_bad", "failed_good", "looked_at_good", "repeated",
                                   "lost")] == [0, 0, 0, 0, 0]
    assert row["flaws"].keys() == {"short lens", "off axis", "decentred", "tilted", "rolled"}
    assert row["worst_flaw_percent"] < 10
