"""Delay of each look-up's read after its number: a step function that only rises."""

from bisect import bisect_right
from collections import deque

import numpy as np

__all__ = ["DelaySteps"]


class DelaySteps:
    """Window i is read at clock i + delay(i); windows are read in order, so delays never fall.

    Steps are known up to the look-up that waits for memory now. A full writer adds postponed steps
    at higher look-ups.
    """

    def __init__(self, start):
        self.at, self.delay = [-1], [start]
        self.postponed = deque()            # (look-up, delay) of :meth:`postpone`, not applied

    def step(self, i, delay):
        """Look-up i has at least this delay; i ascends from call to call."""
        self.apply_postponed(i)
        if delay > self.delay[-1]:
            self.at.append(i)
            self.delay.append(delay)

    def postpone(self, i, clock):
        """Look-up i is not read before ``clock``; i ascends from call to call."""
        self.postponed.append((i, clock - i))

    def apply_postponed(self, i):
        """Apply the postponed steps up to look-up i."""
        while self.postponed and self.postponed[0][0] <= i:
            at, delay = self.postponed.popleft()
            if delay > self.delay[-1]:
                self.at.append(max(at, self.at[-1]))
                self.delay.append(delay)

    def clock(self, i):
        """Clock at which look-up i is read, by the steps so far."""
        return i + self.delay[bisect_right(self.at, i) - 1]

    def clocks(self, numbers):
        """:meth:`clock` of each of an array of look-ups."""
        return numbers + np.array(self.delay)[np.searchsorted(self.at, numbers, "right") - 1]
