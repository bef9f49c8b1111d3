"""Readers that claim frames at any time and take any time, with a running camera."""

import random
from dataclasses import dataclass

import numpy as np

from ncdc_model.correction import correct
from ncdc_sim.system.host import Content
from ncdc_sim.system.running import running

__all__ = ["ReadersRun", "simulate_readers"]


@dataclass
class ReadersRun:
    """Frames of the readers, by result.

    Parameters
    ----------
    raw, corrected : int
        Frames that were read whole and are the golden model's.
    torn : int
        Frames that were not, and were not marked.
    lost : int
        Frames whose buffer was taken away meanwhile, as reported to the reader.
    begun, bad, skipped, taken : int
        The system's own counters: raw frames begun, ended as bad and skipped by the corrector;
        buffers taken from readers and the corrector.
    """
    raw: int = 0
    corrected: int = 0
    torn: int = 0
    lost: int = 0
    begun: int = 0
    bad: int = 0
    skipped: int = 0
    taken: int = 0


class _Reader:
    """One reader, which reads the first half of a frame when it claims it, the rest later."""

    def __init__(self, host, number, golden):
        self.host, self.number, self.golden, self.frame = host, number, golden, None

    def step(self, rng, run):
        """Claim a frame, or end the one that is held and say in ``run`` what it was."""
        host = self.host
        if self.frame is None:
            self.is_corrected = rng.random() < .5
            frame = host.camera.claim(self.number, self.is_corrected)
            self.frame = frame and (frame, host.live.memory(frame.base, frame.size // 2))
            return
        first, data = self.frame
        size = first.size // 2
        data += host.live.memory(first.base + size, first.size - size)
        lost = host.camera.lost(self.number)
        host.camera.release(self.number)
        self.frame = None
        if lost:
            run.lost += 1
            return
        whole = Content(first.number, first.time, data)
        seen = host.picture(whole) if self.is_corrected else host.raw(whole)
        if not np.array_equal(seen, self.golden(self.is_corrected, first.number)):
            run.torn += 1
        elif self.is_corrected:
            run.corrected += 1
        else:
            run.raw += 1


def simulate_readers(system, setup, light, *, count, seed, limit=0,
                     progress=lambda fraction: None, **run):
    """Let a camera run for ``count`` raw frames, with readers that come and go at random.

    Parameters
    ----------
    system, setup, light :
        As of :func:`running`.
    count, seed : int
    limit : int
        Clocks for which a buffer may be held; 0: for ever.
    progress : callable
        Called with the fraction of the frames that are done.
    run :
        As of :func:`running`.

    Returns
    -------
    ReadersRun
    """
    rng, result = random.Random(seed), ReadersRun()
    with running(system, setup, light, registers={"READER_LIMIT": limit}, seed=seed,
                 **run) as camera:
        host, live = camera.host, camera.host.live
        pictures = [correct(system.descriptor, raw, strip=system.hardware.strip).picture
                    for raw in camera.raw]

        def golden(is_corrected, number):
            return (pictures if is_corrected else camera.raw)[(number - 1) % len(pictures)]

        readers = [_Reader(host, k, golden) for k in range(system.stores.readers)]
        while (begun := host.get("RAW_BEGUN")) < count:
            rng.choice(readers).step(rng, result)
            live.wait(int(rng.choice((.01, .3, 3)) * camera.frame_clocks * rng.random()))
            progress(begun / count)
        result.begun, result.bad, result.skipped = (
            host.get(name) for name in ("RAW_BEGUN", "RAW_ENDED_BAD", "RAW_SKIPPED"))
        result.taken = host.get("RAW_TAKEN") + host.get("CORRECTED_TAKEN")
        live.end()
    return result
