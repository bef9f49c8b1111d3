"""The workers of a lot: processes on this machine, or those of a Dask scheduler."""

import logging
import os
import signal
import threading
import uuid
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker

import dask
from distributed import Client, KilledWorker, LocalCluster, wait

from ncdc.lot.run import SchedulerLost
from ncdc.lot.work import Outcome, process
from ncdc_spec.errors import InputError

__all__ = ["Workers", "connect"]

_CHECK = 2.0            # seconds between two looks at whether the scheduler is there
_TIMEOUT = 30.0         # seconds until a scheduler must answer and have a worker
# A unit that ends its worker comes back at once: the lot counts its tries, not the scheduler.
# A worker imports what it needs when it starts, not with its first unit.
_LOCAL = {"distributed.worker.preload": ["ncdc.lot.workers"],
          "distributed.scheduler.allowed-failures": 0,
          "distributed.scheduler.worker-saturation": 1.0}


@contextmanager
def connect(scheduler=None, count=None, limit=3600.0):
    """Yield :class:`Workers`.

    Parameters
    ----------
    scheduler : str, optional
        Address of a Dask scheduler, such as ``tcp://10.0.0.5:8786``. Without it ``count`` processes
        are started on this machine, as many as processors if that is None, and ended afterwards.
    limit : float
        Seconds after which the work on a unit ends its worker.

    Raises
    ------
    InputError
        If no scheduler answers, or none of its workers is there in time.
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
    try:
        client = Client(scheduler, timeout=_TIMEOUT)
    except (OSError, ValueError) as error:
        raise InputError(f"no scheduler answers at {scheduler}") from error
    try:
        client.wait_for_workers(1, timeout=_TIMEOUT)
        yield Workers(client, limit)
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
    """Units that are being worked on, at most one for each thread of a worker."""

    def __init__(self, client, limit):
        self.client, self.limit, self._running = client, limit, {}

    def __len__(self):
        return len(self._running)

    @property
    def running(self):
        """Tags of the units that are being worked on."""
        return list(self._running.values())

    @property
    def slots(self):
        """How many units the workers can take at a time.

        Raises
        ------
        SchedulerLost
            If the scheduler has gone.
        """
        try:
            return max(1, sum(self.client.nthreads().values()))
        except OSError as error:
            raise SchedulerLost from error

    def submit(self, tag, photos, request):
        """Start the work on a unit, which ``tag`` will name."""
        future = self.client.submit(_limited, photos, request, self.limit,
                                    key=f"unit-{uuid.uuid4().hex}", pure=False)
        self._running[future] = tag

    def finished(self, seconds=None):
        """Wait for a unit; a list of (tag, :class:`Outcome` or None if its worker died).

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
            if done or seconds is not None:
                return [(self._running.pop(future), _result(future)) for future in done]


def _limited(photos, request, seconds):
    """The :class:`Outcome` of a unit; after ``seconds`` it ends the worker, as a crash does.

    A thread that hangs cannot be ended alone.
    """
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
