"""``ncdc lot`` on real worker processes: kills, and the same networks everywhere."""

import json
import os
import shutil
import signal
import subprocess
import threading
import time
from importlib import import_module

import pytest
from distributed import Client

from ncdc.cli import main
from ncdc.lot.identity import identity
from ncdc.lot.run import REJECTED, SchedulerLost
from ncdc.lot.work import Request
from ncdc.lot.workers import Tls, connect
from ncdc_bench.lot.processes import cluster
from ncdc_bench.lot.units import BAD, make_unit, write_photos
from ncdc_spec.errors import InputError

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


def test_a_worker_with_other_code_is_rejected_by_name(units, tmp_path, capsys):
    """It is asked before it gets work, also if it joins later, and none of its answers count."""
    altered = tmp_path / "altered"
    for package in ("ncdc", "ncdc_model", "ncdc_spec"):
        [folder] = import_module(package).__path__
        shutil.copytree(folder, altered / package, ignore=shutil.ignore_patterns("__pycache__"))
    source = altered / "ncdc_model" / "flaw_figures.py"
    text = source.read_text().replace("roll_deg=roll,", "roll_deg=42.0,")
    assert text != source.read_text()
    source.write_text(text)
    paths = os.pathsep.join([str(altered), *filter(None, [os.environ.get("PYTHONPATH")])])
    with cluster(0) as processes:
        processes.start_worker(PYTHONPATH=paths)
        with pytest.raises(InputError, match="no worker with the software of this command"):
            with connect(processes.address):
                pass
        said = capsys.readouterr().err
        assert "the worker tcp://127.0.0.1:" in said and "is rejected, it has code of NCDC" in said
        assert f"here {identity()['code']}" in said and "NumPy" not in said
        processes.start_worker()
        with Client(processes.address) as client:
            client.wait_for_workers(2, timeout=60)
        with connect(processes.address) as workers:
            submitted(workers, "good", units["U0003"], REQUEST)
            assert workers.slots == 1
            processes.start_worker(PYTHONPATH=paths)
            workers.client.wait_for_workers(3, timeout=60)
            assert workers.slots == 1
            done = []
            while not done:
                done = workers.finished()
            # A process that takes the place of the one that was asked says who it is.
            [good] = [address for address, why in workers._rejected.items() if not why]
            workers.client.run(_other_software, workers=[good])
            submitted(workers, "rejected", units["U0003"], REQUEST)
            assert workers.finished() == [("rejected", REJECTED)] and workers.slots == 0
    [(tag, outcome)] = done
    assert tag == "good" and outcome.made_by == identity()
    assert abs(outcome.figures["roll_deg"]) < 5
    said = capsys.readouterr().err
    assert said.count("is rejected") == 3 and "has NumPy 0.1, here" in said


def _other_software():
    import ncdc.lot.workers
    ncdc.lot.workers.identity = lambda other=identity() | {"numpy": "0.1"}: other


def test_a_scheduler_with_certificates_is_reached_with_them_only(tmp_path):
    """Certificates by OpenSSL: of an authority, and one for all that it signed."""
    made = {}
    for name in ("one", "other"):
        folder = tmp_path / name
        folder.mkdir()

        def openssl(line):
            subprocess.run(["openssl", *line.split()], cwd=folder, check=True, capture_output=True)
        openssl("req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -subj /CN=line")
        openssl("req -newkey rsa:2048 -nodes -keyout key.pem -out request.pem -subj /CN=station")
        openssl("x509 -req -in request.pem -CA ca.pem -CAkey ca.key -CAcreateserial -out cert.pem")
        made[name] = [str(folder / file) for file in ("ca.pem", "cert.pem", "key.pem")]
    with cluster(1, made["one"]) as processes:
        assert processes.address.startswith("tls://")
        with connect(processes.address, tls=Tls(*made["one"])) as workers:
            assert workers.slots == 1
        for tls in (Tls(*made["other"]), None):
            with pytest.raises(InputError, match="no scheduler answers at tls://"):
                with connect(processes.address, tls=tls):
                    pass
    ca, cert, key = made["one"]
    with pytest.raises(InputError, match="no certificate of an authority, a certificate and its"):
        Tls(ca, cert, made["other"][2]).security()
    with pytest.raises(InputError, match="cannot read .*none.pem: No such file"):
        Tls(ca, str(tmp_path / "none.pem"), key).security()


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
    """Each way to be bad once, and some good units."""
    assert main(["bench", "lot", "--units", str(len(BAD) + 6), "--bad", str(len(BAD)), "--kill",
                 "--json", "-", "--folder", str(tmp_path)]) == 0
    [row] = json.loads(capsys.readouterr().out)["rows"]
    assert row["kills"] == 3 and row["resumed"] >= 1
    assert [row[name] for name in ("passed_bad", "failed_good", "looked_at_good", "repeated",
                                   "lost")] == [0, 0, 0, 0, 0]
    assert row["flaws"].keys() == {"short lens", "off axis", "decentred", "tilted", "aspect",
                                   "rolled"}
    assert row["mixed"] == 1
    assert row["worst_flaw_percent"] < 10
