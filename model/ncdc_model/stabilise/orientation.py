"""Orientation of a camera from the samples of a gyroscope."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ncdc_model.stabilise.quaternions import mean, multiply, of_vectors, running_product
from ncdc_spec.errors import InputError

__all__ = ["Gyroscope"]

_REACH = 3              # standard deviations of the smoothing that are averaged


@dataclass(frozen=True)
class Gyroscope:
    """Samples of a gyroscope.

    Between two samples the rates change linearly. Orientations are quaternions from the camera's
    axes at a time to those at the first sample.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Seconds, rising.
    rates : ndarray, shape (n, 3)
        Radians per second about the camera's axes x (right), y (down), z (forward).
    """
    times: np.ndarray
    rates: np.ndarray

    @cached_property
    def orientations(self):
        """Quaternions (n, 4) at the times of the samples."""
        step = np.diff(self.times)[:, None]
        turns = of_vectors((self.rates[1:] + self.rates[:-1]) / 2 * step)
        return running_product(np.concatenate([[[1.0, 0, 0, 0]], turns]))

    def at(self, times):
        """Quaternions (..., 4) at ``times`` in seconds.

        Raises
        ------
        InputError
            If a time is before the first sample or after the last one.
        """
        times = np.asarray(times, np.float64)
        first, last = self.times[[0, -1]]
        for worst in (times.min(), times.max()):
            if not first <= worst <= last:
                raise InputError(f"a picture was taken at {worst:.6g} s, the gyroscope's samples "
                                 f"are from {first:.6g} s to {last:.6g} s")
        k = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, len(self.times) - 2)
        after, step = (times - self.times[k])[..., None], np.diff(self.times)[k][..., None]
        change = (self.rates[k + 1] - self.rates[k]) / step
        return multiply(self.orientations[k], of_vectors(after * (self.rates[k]
                                                                  + after / 2 * change)))

    def smooth(self, time, sigma):
        """The mean orientation (4,) around ``time``, weighted by a Gaussian of ``sigma`` seconds.

        ``sigma`` 0 gives the orientation at the time itself.
        """
        if not sigma:
            return self.at(time)
        near = slice(*np.searchsorted(self.times, time + _REACH * sigma * np.array([-1, 1])))
        times = self.times[near]
        if len(times) < 2:
            return self.at(time)
        weights = np.exp(-((times - time) / sigma)**2 / 2) * np.gradient(times)
        return mean(self.orientations[near], weights)
