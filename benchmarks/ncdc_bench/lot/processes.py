"""Scheduler, workers, driver and station of a lot as processes, which can be killed."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from urllib.request import urlopen

from ncdc.cli.lot_run import database_at
from ncdc_bench.lot.units import LIMITS
from ncdc_spec.errors import InputError

__all__ = ["KILLS", "Cluster", "Station", "cluster", "lot_command", "run_with_kills", "station"]

KILLS = "worker", "driver", "scheduler"
_POLL = 0.2             # seconds
_STOP = 10.0            # seconds until a process that was asked to end is killed
_TIMEOUT = 300.0        # seconds until a station must have judged a unit


class Cluster:
    """A Dask scheduler and its workers, each a process.

    Parameters
    ----------
    count : int
        Workers, of one thread each.
    tls : sequence of str, optional
        Files of the authority's certificate, of a certificate, and of its key, for all of them.
    """

    def __init__(self, count, tls=()):
        with socket.socket() as one:
            one.bind(("127.0.0.1", 0))
            port = one.getsockname()[1]
        self.address = f"{'tls' if tls else 'tcp'}://127.0.0.1:{port}"
        self._tls = [part for option, file in zip(("--tls-ca-file", "--tls-cert", "--tls-key"), tls)
                     for part in (option, file)]
        self.scheduler = _dask("scheduler", "--host", self.address.rpartition(":")[0], "--port",
                               port, "--no-dashboard", *self._tls)
        self.workers = []
        for _ in range(count):
            self.start_worker()

    def start_worker(self, **environment):
        """Start one more worker, with other variables of the ``environment``."""
        self.workers.append(_dask("worker", self.address, "--nthreads", 1, "--no-dashboard",
                                  "--death-timeout", 20, *self._tls, **environment))

    def kill_worker(self):
        """Kill the process that works, which its nanny starts again."""
        nanny = self.workers[0].pid
        children = subprocess.run(["pgrep", "-P", str(nanny), "-f", "spawn_main"],
                                  capture_output=True, text=True).stdout.split()
        os.kill(int(children[-1]), signal.SIGKILL)

    def close(self):
        """End what still runs."""
        for process in (*self.workers, self.scheduler):
            process.terminate()
        for process in (*self.workers, self.scheduler):
            try:
                process.wait(_STOP)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@contextmanager
def cluster(count, tls=()):
    """Yield a :class:`Cluster` that ends with the block."""
    started = Cluster(count, tls)
    try:
        yield started
    finally:
        started.close()


class Station:
    """``ncdc lot watch`` on ``folder`` as a process with its workers, as in a terminal of its own.

    Parameters
    ----------
    folder, lot : path
    more : str
        Options.

    Attributes
    ----------
    process : subprocess.Popen
    url : str
        Address of its page.
    """

    def __init__(self, folder, lot, *more):
        # What a shell starts in the background ignores Ctrl-C, and so would the station.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "ncdc", "lot", "watch", str(folder), "-o", str(lot), "--target",
             "dots", "--bayer", "MONO", "--workers", "1", "--port", "0", *map(str, more)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        self.url = self.process.stderr.readline().split()[0]
        self.process.stderr.readline()      # its workers are ready

    def wait_for(self, *signs):
        """Wait until the page shows one of ``signs``, such as ("PASS", "U0001").

        Raises
        ------
        InputError
            If it does not in time.
        """
        end, shown = time.monotonic() + _TIMEOUT, None
        while time.monotonic() < end:
            with urlopen(self.url + "state", timeout=_TIMEOUT) as answer:
                shown = re.search(r"<h1>(.*)</h1>\s*<h2>(.*)</h2>", answer.read().decode()).groups()
            if shown in signs:
                return shown
            time.sleep(_POLL)
        raise InputError(f"the station shows {shown}, not one of {signs}")

    def interrupt(self):
        """End it as Ctrl-C does; (exit status, stdout, stderr)."""
        os.killpg(self.process.pid, signal.SIGINT)
        out, errors = self.process.communicate(timeout=_TIMEOUT)
        return self.process.returncode, out, errors


@contextmanager
def station(folder, lot, *more):
    """Yield a :class:`Station` that is killed with the block."""
    started = Station(folder, lot, *more)
    try:
        yield started
    finally:
        started.process.kill()
        started.process.communicate()


def _dask(*arguments, **environment):
    return subprocess.Popen([sys.executable, "-m", "dask", *map(str, arguments)],
                            env={**os.environ, **environment}, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)


def lot_command(units, lot, *more):
    """Arguments of the Python that runs `ncdc lot run` on synthetic units."""
    limits = [part for name, value in LIMITS.items()
              for part in (f"--{name.replace('_', '-')}", str(value))]
    return [sys.executable, "-m", "ncdc", "lot", "run", str(units), "--target", "dots",
            "--neurons", "8", "--bayer", "MONO", *limits, "-o", str(lot), *map(str, more)]


def run_with_kills(folder, workers, kills):
    """Run the lot of ``folder``/units into ``folder``/lot; (seconds, number of kills).

    A process is killed each time that another part of the units is judged, and what is missing
    afterwards is started again. Without ``kills`` the lot starts its own workers.
    """
    start, done = time.monotonic(), 0
    if not kills:
        _check(subprocess.run(lot_command(folder / "units", folder / "lot", "--workers", workers)))
        return time.monotonic() - start, 0
    count = sum(1 for _ in (folder / "units").iterdir())
    while done < len(kills) + 1:
        with cluster(workers) as running:
            command = lot_command(folder / "units", folder / "lot", "--scheduler", running.address)
            with open(folder / "driver.log", "ab") as log:
                driver = subprocess.Popen(command, stderr=log)
            for victim in kills[done:]:
                _wait_for(folder / "lot", count * (done + 1) / (len(kills) + 1), driver)
                done += 1
                if victim == "worker":
                    running.kill_worker()
                    continue
                (driver if victim == "driver" else running.scheduler).kill()
                driver.wait()
                break
            else:
                driver.wait()
                _check(driver)
                if "Traceback" in (folder / "driver.log").read_text():
                    raise InputError(f"the driver did not end in order: see {folder}/driver.log")
                return time.monotonic() - start, done


def _wait_for(lot, count, driver):
    """Wait until so many units are judged.

    Raises
    ------
    InputError
        If the driver ends before.
    """
    while True:
        ended = driver.poll() is not None
        with suppress(InputError):
            database = database_at(str(lot))
            counts = database.counts()
            database.close()
            if sum(counts.values()) - counts["units"] >= count:
                return
        if ended:
            raise InputError(f"ncdc lot run ended with status {driver.returncode} before {count:g} "
                             f"units were judged")
        time.sleep(_POLL)


def _check(done):
    if done.returncode:
        raise InputError(f"ncdc lot run ended with status {done.returncode}")
