"""The workers of a lot: processes on this machine, or those of a Dask scheduler."""

import logging
import os
import signal
import threading
import uuid
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import resource_tracker

import dask
from distributed import Client, KilledWorker, LocalCluster, Security, wait

from ncdc.lot.identity import differences, identity
from ncdc.lot.run import REJECTED, SchedulerLost
from ncdc.lot.work import Outcome, process
from ncdc.terminal import say
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes

__all__ = ["Tls", "Workers", "connect"]

_CHECK = 2.0            # seconds between two looks at whether the scheduler is there
_TIMEOUT = 30.0         # seconds until a scheduler must answer and have a worker
# A unit that ends its worker comes back at once: the lot counts its tries, not the scheduler.
# A worker imports what it needs when it starts, not with its first unit.
_LOCAL = {"distributed.worker.preload": ["ncdc.lot.workers"],
          "distributed.scheduler.allowed-failures": 0,
          "distributed.scheduler.worker-saturation": 1.0}


@dataclass(frozen=True)
class Tls:
    """Files, in PEM, by which this command and a scheduler at ``tls://`` know each other.

    Parameters
    ----------
    ca_file, cert, key : str
        Certificate of the authority that signed those of all, certificate of this command, and
        its key.
    """
    ca_file: str
    cert: str
    key: str

    def security(self):
        """The :class:`distributed.Security`; raises InputError if a file cannot be used."""
        for path in (self.ca_file, self.cert, self.key):
            read_bytes(path)
        found = Security(tls_ca_file=self.ca_file, tls_client_cert=self.cert,
                         tls_client_key=self.key, require_encryption=True)
        try:
            found.get_connection_args("client")
        except (OSError, ValueError) as error:      # ssl.SSLError is an OSError
            raise InputError(f"{self.ca_file}, {self.cert} and {self.key} are no certificate of an "
                             f"authority, a certificate and its key, in PEM: {error}") from error
        return found


@contextmanager
def connect(scheduler=None, count=None, limit=3600.0, tls=None):
    """Yield :class:`Workers`.

    Parameters
    ----------
    scheduler : str, optional
        Address of a Dask scheduler, such as ``tcp://10.0.0.5:8786``. Without it ``count`` processes
        are started on this machine, as many as processors if that is None, and ended afterwards.
    limit : float
        Seconds after which the work on a unit ends its worker.
    tls : Tls, optional
        For a scheduler at an address such as ``tls://10.0.0.5:8786``.

    Raises
    ------
    InputError
        If no scheduler answers, none of its workers is there in time, or all of them are rejected.
    """
    for name in logging.root.manager.loggerDict:
        if name.startswith("distributed"):
            logging.getLogger(name).setLevel(logging.CRITICAL)      # the lot says what happened
    if scheduler is None:
        with ExitStack() as stack:
            stack.enter_context(dask.config.set(_LOCAL))
            with _uninterrupted():
                local = stack.enter_context(LocalCluster(
                    n_workers=count, threads_per_worker=1, dashboard_address=None,
                    silence_logs=logging.CRITICAL))
            yield Workers(stack.enter_context(Client(local)), limit)
        return
    security = tls and tls.security()
    try:
        client = Client(scheduler, timeout=_TIMEOUT, security=security)
    except (OSError, ValueError, RuntimeError, TypeError) as error:
        raise InputError(f"no scheduler answers at {scheduler}"
                         f"{' with these certificates' if tls else ''}") from error
    try:
        client.wait_for_workers(1, timeout=_TIMEOUT)
        workers = Workers(client, limit)
        if not workers.slots:
            raise InputError(f"the scheduler at {scheduler} has no worker with the software of "
                             f"this command")
        yield workers
    except TimeoutError as error:
        raise InputError(f"the scheduler at {scheduler} has no worker") from error
    finally:
        with suppress(TimeoutError):    # a scheduler that is gone does not answer
            client.close(timeout=_CHECK)


@contextmanager
def _uninterrupted():
    """Raise the KeyboardInterrupt of the block after it: Dask cannot close a cluster that starts.

    Processes that are started in the block, or later by its threads, get no Ctrl-C: it is for the
    command alone, which ends them.
    """
    caught = []
    resource_tracker.ensure_running()       # its start would let Ctrl-C through again
    before = {number: signal.signal(number, lambda *_: caught.append(True))
              for number in (signal.SIGINT, signal.SIGTERM)
              if signal.getsignal(number) is signal.default_int_handler}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in before.items():
            signal.signal(number, handler)
    if caught:
        raise KeyboardInterrupt


class Workers:
    """Units that are being worked on, at most one for each thread of a worker.

    A worker gets work if its :func:`ncdc.lot.identity.identity` is that of this process. It is
    asked before it gets any, and again by each unit. The others are rejected by name. A unit
    belongs to one worker: if that one goes, its work has ended.
    """

    def __init__(self, client, limit):
        self.client, self.limit = client, limit
        self._running = {}          # tag and worker, by future
        self._free = {}             # threads by address, when `slots` was asked
        self._rejected = {}         # what differs, by address; empty for a worker that gets work

    def __len__(self):
        return len(self._running)

    @property
    def running(self):
        """Tags of the units that are being worked on."""
        return [tag for tag, _ in self._running.values()]

    @property
    def slots(self):
        """How many units the workers can take at a time; 0 without one that gets work.

        Raises
        ------
        SchedulerLost
            If the scheduler has gone.
        """
        self._free = self._threads()
        return sum(self._free.values())

    def _threads(self):
        """Number of threads by address of the workers that get work. New ones are asked."""
        try:
            there = self.client.nthreads()
            new = [address for address in there if address not in self._rejected]
            answers = self.client.run(identity, workers=new, on_error="return") if new else {}
        except OSError as error:
            raise SchedulerLost from error
        self._rejected = {address: why for address, why in self._rejected.items()
                          if address in there}
        for address, answer in answers.items():
            if not isinstance(answer, OSError):     # it has gone, and is asked if it comes back
                self._judge(address, answer)
        return {address: count for address, count in there.items()
                if self._rejected.get(address) == ""}

    def _judge(self, address, answer):
        """Note whether the worker with the identity ``answer``, or with an error, gets work."""
        why = (differences(answer, identity()) if isinstance(answer, dict)
               else f"no NCDC of this version ({type(answer).__name__}: {answer})")
        self._rejected[address] = why
        if why:
            say(f"the worker {address} is rejected, it has {why}")

    def submit(self, tag, photos, request):
        """Start the work on a unit, which ``tag`` will name; there are fewer than ``slots``."""
        free = self._free.copy()
        for _, address in self._running.values():
            if address in free:
                free[address] -= 1
        address = max(free, key=free.get)
        future = self.client.submit(_limited, photos, request, self.limit, identity(),
                                    key=f"unit-{uuid.uuid4().hex}", pure=False,
                                    workers=[address], allow_other_workers=False)
        self._running[future] = tag, address

    def finished(self, seconds=None):
        """Wait for a unit; a list of (tag, :class:`Outcome`, None if its worker died, or REJECTED
        if it went to another process than the one that was asked).

        ``seconds``: the list is empty if none is finished by then.

        Raises
        ------
        SchedulerLost
            If the scheduler has gone.
        """
        while True:
            try:
                done = wait(list(self._running), timeout=_CHECK if seconds is None else seconds,
                            return_when="FIRST_COMPLETED").done
            except TimeoutError:
                done = ()
            except CancelledError as error:
                raise SchedulerLost from error
            if self.client.status != "running":
                raise SchedulerLost
            results = [(*self._running.pop(future), _result(future)) for future in done]
            results += self._orphans() if not done else []
            if results or seconds is not None:
                return [(tag, self._accepted(address, result)) for tag, address, result in results]

    def _accepted(self, address, result):
        """The result of a unit; REJECTED for the identity of a process that must not judge."""
        if not isinstance(result, dict):
            return result
        self._judge(address, result)
        return REJECTED

    def _orphans(self):
        """(tag, address, None) of the units whose worker has gone: they are waited for no more."""
        there = self._threads()
        lost = [future for future, (_, address) in self._running.items() if address not in there]
        self.client.cancel(lost)
        return [(*self._running.pop(future), None) for future in lost]


def _limited(photos, request, seconds, wanted):
    """The :class:`Outcome` of a unit; after ``seconds`` it ends the worker, as a crash does.

    A thread that hangs cannot be ended alone. A process whose identity is not the ``wanted`` one
    returns its own instead.
    """
    if identity() != wanted:
        return identity()
    alarm = threading.Timer(seconds, os._exit, (1,))
    alarm.daemon = True
    alarm.start()
    try:
        return process(photos, request)
    finally:
        alarm.cancel()


def _result(future):
    """The outcome; None if the worker died."""
    if future.status == "finished":
        return future.result()
    if future.status != "error":
        raise SchedulerLost
    error = future.exception()
    if isinstance(error, KilledWorker):
        return None
    # Such as a worker without NCDC, or with another version of it.
    return Outcome(error=f"the worker failed: {type(error).__name__}: {error}")
