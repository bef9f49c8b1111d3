"""Pages that are not flat: bent round a cylinder, or with a bulge."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Bulge", "Cylinder"]


@dataclass(frozen=True)
class Cylinder:
    """A page of ``length`` steps bent round a cylinder, so that its middle is ``sag`` times its
    length farther away than its ends. It bends along the rows, turned by ``turn`` degrees.

    Distances along the paper stay as they are.
    """
    sag: float
    length: float
    turn: float = 0.0

    @property
    def radius(self):
        """Of the cylinder in steps, from the sag of a chord."""
        sag = self.sag * self.length
        return sag / 2 + self.length**2 / (8 * sag)

    @property
    def _turned(self):
        cosine, sine = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        return np.array([[cosine, -sine], [sine, cosine]])

    def bent(self, points):
        """Positions (..., 2) in the plane that the page touches in its middle, and heights (...)
        above it, of ``points`` (..., 2) of the paper, in steps from its middle."""
        along, across = np.moveaxis(points @ self._turned, -1, 0)
        flat = np.stack([self.radius * np.sin(along / self.radius), across], axis=-1)
        return flat @ self._turned.T, -self.radius * (1 - np.cos(along / self.radius))

    def unrolled(self, flat):
        """Points (..., 2) of the paper at positions ``flat`` (..., 2), and their heights (...)."""
        along, across = np.moveaxis(flat @ self._turned, -1, 0)
        along = self.radius * np.arcsin(np.clip(along / self.radius, -1, 1))
        points = np.stack([along, across], axis=-1) @ self._turned.T
        return points, -self.radius * (1 - np.cos(along / self.radius))


@dataclass(frozen=True)
class Bulge:
    """A page with a bulge of ``height`` steps towards the camera round its middle, in the shape of
    a normal distribution of ``sigma`` steps."""
    height: float
    sigma: float

    def bent(self, points):
        """As :meth:`Cylinder.bent`."""
        return points, -self.height * np.exp(-(points**2).sum(axis=-1) / (2 * self.sigma**2))

    def unrolled(self, flat):
        """As :meth:`Cylinder.unrolled`."""
        return self.bent(flat)
