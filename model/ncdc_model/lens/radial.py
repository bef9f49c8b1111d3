"""Radial lens models: ideal radius to distorted radius, without a change of direction."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ncdc_model.lens.inverse import monotone_inverse, monotone_limit

__all__ = ["AsariPolynomial", "KannalaBrandt", "Rational"]


class _Radial:
    """Base of the radial models; each provides ``centre``, ``_forward`` and ``_backward``."""
    centre = (0.0, 0.0)

    def distort(self, x, y):
        """Distorted point of the ideal point (x, y); not-a-number beyond the model's limit."""
        return self._scaled(x, y, self._forward)

    def undistort(self, x, y):
        """Ideal point of the distorted point (x, y); not-a-number outside the model's range."""
        return self._scaled(x, y, self._backward)

    def _scaled(self, x, y, function):
        cx, cy = self.centre
        x, y = np.asarray(x, np.float64) - cx, np.asarray(y, np.float64) - cy
        r = np.hypot(x, y)
        near = r < 1e-12
        ratio = function(np.where(near, 1e-12, r)) / np.where(near, 1e-12, r)
        return cx + x * ratio, cy + y * ratio


@dataclass(frozen=True)
class AsariPolynomial(_Radial):
    """Radial polynomial of Asari, equations (9)-(11) of the paper, as a back-map.

    ``distort`` takes a corrected radius rho to the distorted rho' = sum over n of a[n] rho**n;
    the angle (10) does not change. a[0] must be zero for a map continuous at the centre.

    Parameters
    ----------
    a : tuple of float
        Coefficients from order 0 on, in the units of the points.
    centre : (float, float)
        Centre of distortion.
    limit : float
        Largest corrected radius; limited to where the polynomial stops increasing.
    """
    a: tuple
    centre: tuple = (0.0, 0.0)
    limit: float = 1e4

    @cached_property
    def _end(self):
        return monotone_limit(np.polynomial.Polynomial(self.a).deriv(), self.limit)

    def _forward(self, rho):
        return np.where(rho <= self._end, np.polynomial.Polynomial(self.a)(rho), np.nan)

    def _backward(self, rho):
        polynomial = np.polynomial.Polynomial(self.a)
        return monotone_inverse(polynomial, polynomial.deriv(), rho, self._end)


@dataclass(frozen=True)
class Rational(_Radial):
    """Rational radial model: rd = r (1 + k0 q + k1 q^2 + k2 q^3) / (1 + k3 q + k4 q^2 + k5 q^3).

    q = r^2; missing coefficients are zero, so that up to three give the radial part (13) of
    Brown. Valid up to radius ``limit`` (10: a view of 169 degrees) or where rd stops increasing.
    """
    k: tuple
    limit: float = 10.0

    @cached_property
    def _parts(self):
        k = tuple(self.k) + (0.0,) * (6 - len(self.k))
        spread = [[1.0, *k[:3]], [1.0, *k[3:]]]
        top, bottom = (np.zeros(7) for _ in spread)
        top[::2], bottom[::2] = spread
        top, bottom = np.polynomial.Polynomial(top), np.polynomial.Polynomial(bottom)
        return top * np.polynomial.Polynomial([0, 1]), bottom

    def _value(self, r):
        top, bottom = self._parts
        return top(r) / bottom(r)

    def _slope(self, r):
        top, bottom = self._parts
        return (top.deriv()(r) * bottom(r) - top(r) * bottom.deriv()(r)) / bottom(r)**2

    @cached_property
    def _end(self):
        return monotone_limit(self._slope, self.limit)

    def _forward(self, r):
        return np.where(r <= self._end, self._value(r), np.nan)

    def _backward(self, r):
        return monotone_inverse(self._value, self._slope, r, self._end)


@dataclass(frozen=True)
class KannalaBrandt(_Radial):
    """Equidistant model with odd polynomial: rd = t (1 + k0 t^2 + k1 t^4 + ...), t = atan(r).

    ``k`` empty is the plain equidistant lens. Points of the ideal plane have t < pi/2; a
    distorted radius beyond that has no ideal point.
    """
    k: tuple = ()

    @cached_property
    def _polynomial(self):
        coefficients = np.zeros(2 * len(self.k) + 2)
        coefficients[1::2] = [1.0, *self.k]
        return np.polynomial.Polynomial(coefficients)

    @cached_property
    def _end(self):
        return monotone_limit(self._polynomial.deriv(), np.pi / 2 - 1e-4)

    def _forward(self, r):
        t = np.arctan(r)
        return np.where(t <= self._end, self._polynomial(t), np.nan)

    def _backward(self, r):
        return np.tan(monotone_inverse(self._polynomial, self._polynomial.deriv(), r, self._end))
