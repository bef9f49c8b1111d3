"""How far each look-up is read behind its number: a staircase that only rises."""

from bisect import bisect_right
from collections import deque

import numpy as np

__all__ = ["Lags"]


class Lags:
    """Window i is read at clock i + lag(i); windows are read in order, so lags never fall.

    Steps are known up to the look-up that waits for memory now; a full writer adds steps further
    on, which count from there.
    """

    def __init__(self, start):
        self.at, self.lag = [-1], [start]
        self.later = deque()                # (look-up, lag) of :meth:`hold`, not yet a step

    def step(self, i, lag):
        """Look-up i has at least this lag; i ascends from call to call."""
        self.settle(i)
        if lag > self.lag[-1]:
            self.at.append(i)
            self.lag.append(lag)

    def hold(self, i, clock):
        """Look-up i is not read before ``clock``; i ascends from call to call."""
        self.later.append((i, clock - i))

    def settle(self, i):
        """Turn what is held up to look-up i into steps."""
        while self.later and self.later[0][0] <= i:
            at, lag = self.later.popleft()
            if lag > self.lag[-1]:
                self.at.append(max(at, self.at[-1]))
                self.lag.append(lag)

    def clock(self, i):
        """When look-up i is read, as far as the steps tell."""
        return i + self.lag[bisect_right(self.at, i) - 1]

    def clocks(self, numbers):
        """:meth:`clock` of each of an array of look-ups."""
        return numbers + np.array(self.lag)[np.searchsorted(self.at, numbers, "right") - 1]
