"""A simulated camera that shakes: its gyroscope, and frames of a rolling shutter."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.example import example_camera
from ncdc_model.example.render import SUBSAMPLES, expose
from ncdc_model.lens import Camera
from ncdc_model.stabilise.orientation import Gyroscope
from ncdc_model.stabilise.quaternions import matrices, multiply, of_vectors

__all__ = ["ShakingCamera", "Shake", "small_camera"]

_TONES = 40             # sinusoids about each axis
_INSTANT = 5e-5         # s: half of the step by which rates are measured


def small_camera():
    """The example's camera at half its size, 320x240."""
    table = example_camera().to_dict()
    table |= {"width": table["width"] // 2, "height": table["height"] // 2,
              "centre": [(value - .5) / 2 for value in table["centre"]],
              "f_distorted": table["f_distorted"] / 2}
    table["residual"] = {**table["residual"], "scale": table["residual"]["scale"] / 2}
    return Camera.from_dict({name: value for name, value in table.items()
                             if name not in ("f_corrected", "corrected_size",
                                             "corrected_centre")})


class Shake:
    """Rotations of many sinusoids, of random frequency and phase, about each axis.

    Parameters
    ----------
    degrees : float
        Root mean square of the angle about each of the three axes.
    hertz : (float, float)
        Lowest and highest frequency.
    seed : int
    """
    def __init__(self, degrees=3.0, hertz=(2.0, 15.0), seed=1):
        rng = np.random.default_rng(seed)
        self._rate = 2 * np.pi * rng.uniform(*hertz, (3, _TONES))
        self._phase = rng.uniform(0, 2 * np.pi, (3, _TONES))
        self._scale = np.radians(degrees) * np.sqrt(2 / _TONES)

    def orientation(self, times):
        """Quaternions (..., 4) from the camera's axes to the world's."""
        angles = np.sin(np.asarray(times)[..., None, None] * self._rate + self._phase)
        return of_vectors(self._scale * angles.sum(axis=-1))

    def rates(self, times):
        """Radians per second (..., 3) about the camera's axes."""
        before, after = (self.orientation(np.asarray(times) + sign * _INSTANT) for sign in (-1, 1))
        # Of so small a turn the vector part of the quaternion is half the angle.
        return multiply(before * (1, -1, -1, -1), after)[..., 1:] / _INSTANT

    def gyroscope(self, begin, end, hertz=500.0, noise=0.002, seed=2):
        """The :class:`Gyroscope` of samples with Gaussian ``noise``, in rad/s rms."""
        times = np.arange(begin, end, 1 / hertz)
        random = np.random.default_rng(seed).standard_normal((len(times), 3))
        return Gyroscope(times, self.rates(times) + noise * random)


@dataclass(frozen=True)
class ShakingCamera:
    """A camera with a rolling shutter that turns; its exposure is short.

    Parameters
    ----------
    camera : ncdc_model.lens.Camera
    shake : Shake
    readout : float
        Seconds from the first row of a frame to the row after its last.
    """
    camera: Camera
    shake: Shake
    readout: float

    def frame(self, seconds, samples, light):
        """Light (height, width, 3) of the frame whose first row is read at ``seconds``.

        Parameters
        ----------
        samples : pair of ndarray
            :func:`ncdc_model.example.render.ideal_samples` of the camera.
        light : callable
            Light (..., 3) of the points (a, b) of the world's plane at distance 1.
        """
        a, b = samples
        height = self.camera.size[1]
        row = (np.arange(len(a)) - (SUBSAMPLES - 1) / 2) / SUBSAMPLES
        turn = matrices(self.shake.orientation(seconds + self.readout * row / height))
        x, y, z = (turn[:, k, 0, None] * a + turn[:, k, 1, None] * b + turn[:, k, 2, None]
                   for k in range(3))
        return expose(light(x / z, y / z))

    def direction(self, rays, seconds):
        """Directions (n, 3) in the camera of the world's ``rays`` when their row is read."""
        row = np.full(len(rays), self.camera.size[1] / 2)
        for _ in range(8):      # the row depends on the orientation, which depends on the row
            moment = seconds + self.readout * row / self.camera.size[1]
            turned = np.einsum("nji,nj->ni", matrices(self.shake.orientation(moment)), rays)
            row = self.camera.project(turned)[1]
        return turned
