"""``ncdc lot`` on real worker processes: kills, and the same networks everywhere."""

import json
import os
import signal
import threading

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
def photos(tmp_path):
    write_photos(tmp_path / "units", make_unit(3))
    folder = tmp_path / "units" / "U0003"
    (folder / "1.png").unlink()
    (folder / "2.png").unlink()
    return [str(folder / "0.png")]


def test_a_unit_that_hangs_ends_its_worker(photos):
    with connect(count=1, limit=.5) as workers:
        workers.client.run(_hang)
        workers.submit("hangs", photos, REQUEST)
        assert workers.finished() == [("hangs", None)]
        workers.client.wait_for_workers(1)
        workers.limit = 600
        workers.submit("again", photos, REQUEST)
        [(tag, again)] = workers.finished()
    assert tag == "again" and again.digest


def _hang():
    import ncdc.lot.workers
    ncdc.lot.workers.process = lambda photos, request: threading.Event().wait()


def test_separate_processes_give_the_same_network_and_a_lost_scheduler_is_named(photos):
    outcomes = []
    with connect(count=1) as workers:
        workers.submit("here", photos, REQUEST)
        # The worker ends while it works: its unit comes back without an outcome.
        [pid] = workers.client.run(os.getpid).values()
        os.kill(pid, signal.SIGKILL)
        assert workers.finished() == [("here", None)]
        workers.submit("again", photos, REQUEST)
        outcomes += [outcome for _, outcome in workers.finished()]
    with cluster(1) as processes, connect(processes.address) as workers:
        assert workers.slots == 1
        workers.submit("there", photos, REQUEST)
        outcomes += [outcome for _, outcome in workers.finished()]
        workers.submit("lost", photos, REQUEST)
        processes.scheduler.kill()
        with pytest.raises(SchedulerLost):
            workers.finished()
        assert workers.running == ["lost"]
    first, second = outcomes
    assert not first.error and first.descriptor == second.descriptor
    assert first.photo_hashes == second.photo_hashes and first.figures == second.figures


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
