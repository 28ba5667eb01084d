# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lens distortion on the normalised image plane, and its inverse where it exists.

Formulas are OpenCV's: Brown-Conrady with an optional rational denominator (`plumb_bob`,
`rational_polynomial`), and Kannala-Brandt (`equidistant`). A polynomial lens model is monotonic
only up to some radius: beyond it the image folds over, and a pixel there has no ray, or a wrong
one.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.small_arrays import Rows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_STEPS = 15
_FEW = 12
"""Greatest number of points computed one by one: an array operation costs as much as ten on
numbers."""

_TOLERANCE = 1e-11
_ACCEPT = 1e-9
_KNOTS = 512
_WIDEST = math.radians(89.0)


def _first_positive_root(coefficients: Array) -> float:
    """Return the smallest positive real root of a polynomial (lowest power first), or inf."""
    # Smaller coefficients have no effect on any image, but their roots overflow.
    kept = np.where(np.abs(coefficients) < 1e-15, 0.0, coefficients)
    roots = np.polynomial.polynomial.polyroots(np.trim_zeros(kept, "b"))
    real = roots.real[(np.abs(roots.imag) < 1e-9 * (1.0 + np.abs(roots.real))) & (roots.real > 0)]
    return float(real.min()) if real.size else math.inf


class BrownConrady:
    """`plumb_bob` and `rational_polynomial`.

    Args:
        coefficients: (8,) k1 k2 p1 p2 k3 k4 k5 k6; absent ones 0.

    Attributes:
        max_radius: undistorted radius (tangent of the angle off axis) up to which the radial part
            grows; inf where it always does.
    """

    def __init__(self, coefficients: Array) -> None:
        k1, k2, self._p1, self._p2, k3, k4, k5, k6 = (float(c) for c in coefficients)
        self._over = (1.0, k1, k2, k3)  # powers of r²
        self._under = (1.0, k4, k5, k6)
        self._rational = any(self._under[1:])
        self.max_radius = math.sqrt(self._monotonic_square())
        # Short of the edge, which may be a pole.
        widest = min(0.9999 * math.atan(self.max_radius), _WIDEST)
        radius = np.tan(np.linspace(0.0, widest, _KNOTS))
        self._table = radius, self._radial(radius * radius) * radius
        self._listed: tuple[list[float], ...] = tuple(one.tolist() for one in self._table)

    def _monotonic_square(self) -> float:
        poly = np.polynomial.polynomial
        over, under = np.array(self._over), np.array(self._under)
        # d/dr [r N(s)/D(s)] with s = r² has the sign of N D + 2 s (N' D - N D').
        slope = poly.polymulx(
            poly.polysub(
                poly.polymul(poly.polyder(over), under), poly.polymul(over, poly.polyder(under))
            )
        )
        total = poly.polyadd(poly.polymul(over, under), 2.0 * slope)
        return min(_first_positive_root(total), _first_positive_root(under))

    def distort(self, points: Array) -> tuple[Array, Array]:
        """Return distorted points (n, 2) and the Jacobian (n, 2, 2) of undistorted ones (n, 2)."""
        if len(points) <= _FEW:
            rows = self._values(points.tolist())
            table = np.array([(u, v, a, b, b, d) for u, v, a, b, d in rows]).reshape(-1, 6)
            return table[:, :2], table[:, 2:].reshape(-1, 2, 2)
        ((u, v, a, b, d),) = self._values([points.T])
        return _beside(u, v), _symmetric(a, b, d)

    def through(self, points: Rows) -> list[tuple[Any, ...]]:
        """Return the distorted images of points x, y, z and their derivatives, row by row.

        Returns:
            u and v; their derivatives by x, y and z; the squared undistorted radius and the
            determinant of `distort`, which say whether the lens folds over there.
        """
        plane: list[tuple[Any, Any]] = []
        inverses: list[Any] = []
        for x, y, z in points:
            inverse = 1.0 / z
            plane.append((x * inverse, y * inverse))
            inverses.append(inverse)
        found: list[tuple[Any, ...]] = []
        distorted = self._values(plane)
        for (x, y), inverse, (u, v, a, b, d) in zip(plane, inverses, distorted, strict=True):
            along = -(a * x + b * y) * inverse, -(b * x + d * y) * inverse
            found.append((
                u, v, a * inverse, b * inverse, along[0], b * inverse, d * inverse, along[1],
                x * x + y * y, a * d - b * b,
            ))  # fmt: skip
        return found

    def _values(self, plane: Rows) -> list[tuple[Any, Any, Any, Any, Any]]:
        """Return distorted x and y, and the Jacobian's xx, xy = yx and yy, row by row.

        Of points x, y as numbers, or of all as one row of arrays: for a few points numbers are ten
        times as fast.
        """
        p1, p2 = self._p1, self._p2
        n1, n2, n3 = self._over[1:]
        d1, d2, d3 = self._under[1:]
        found: list[tuple[Any, Any, Any, Any, Any]] = []
        for x, y in plane:
            xx, xy, yy = x * x, x * y, y * y
            s = xx + yy
            radial = 1.0 + s * (n1 + s * (n2 + s * n3))
            slope = n1 + s * (2.0 * n2 + s * (3.0 * n3))  # of the radial factor by s
            if self._rational:
                under = 1.0 + s * (d1 + s * (d2 + s * d3))
                radial = radial / under
                slope = (slope - radial * (d1 + s * (2.0 * d2 + s * (3.0 * d3)))) / under
            twice = 2.0 * slope
            found.append(
                (
                    x * radial + 2.0 * p1 * xy + p2 * (s + 2.0 * xx),
                    y * radial + p1 * (s + 2.0 * yy) + 2.0 * p2 * xy,
                    radial + twice * xx + 2.0 * p1 * y + 6.0 * p2 * x,
                    twice * xy + 2.0 * p1 * x + 2.0 * p2 * y,
                    radial + twice * yy + 6.0 * p1 * y + 2.0 * p2 * x,
                )
            )
        return found

    def _radial(self, squares: Array) -> Array:
        """Return the radial factor (n,) at squared radii (n,)."""
        polyval = np.polynomial.polynomial.polyval
        factor: Array = polyval(squares, self._over) / polyval(squares, self._under)
        return factor

    def undistort(self, points: Array) -> tuple[Array, Array, Mask]:
        """Invert by Newton's method, kept inside the monotonic radius.

        Args:
            points: (n, 2) distorted.

        Returns:
            Undistorted points (n, 2), their derivative (n, 2, 2) by the distorted ones (NaN where
            the lens folds over), and whether each lies in the monotonic region (n,).
        """
        if len(points) <= _FEW:
            return self._undistort_few(points)
        wanted_x, wanted_y = points[:, 0], points[:, 1]
        stretch = self._start(np.hypot(wanted_x, wanted_y))
        x, y = wanted_x * stretch, wanted_y * stretch
        for _ in range(_STEPS):
            ((u, v, a, b, d),) = self._values([(x, y)])
            right, down = u - wanted_x, v - wanted_y
            wrong = np.maximum(np.abs(right), np.abs(down))
            if not (wrong >= _TOLERANCE).any():
                break
            determinant = a * d - b * b
            scale = 1.0 / np.where(determinant == 0.0, np.inf, determinant)
            x, y = self._inside(
                x - (d * right - b * down) * scale, y - (a * down - b * right) * scale, x, y
            )
        found, jacobian = _beside(x, y), _symmetric(a, b, d)
        size = 1.0 + np.maximum(np.abs(wanted_x), np.abs(wanted_y))
        valid: Mask = (wrong < _ACCEPT * size) & self.monotonic(found, jacobian)
        determinant = a * d - b * b
        scale = 1.0 / np.where(determinant > 0.0, determinant, np.nan)
        return found, _symmetric(d * scale, -b * scale, a * scale), valid

    def _undistort_few(self, points: Array) -> tuple[Array, Array, Mask]:
        """Return the same, point by point in plain numbers."""
        wanted = points.tolist()
        places = self._starts(wanted)
        shapes = [(math.nan,) * 4] * len(wanted)  # Jacobian, distance from the target
        moving: list[int] = list(range(len(wanted)))
        for _ in range(_STEPS):
            still: list[int] = []
            distorted = self._values(map(places.__getitem__, moving))
            for i, (u, v, a, b, d) in zip(moving, distorted, strict=True):
                right, down = u - wanted[i][0], v - wanted[i][1]
                wrong = max(abs(right), abs(down))
                shapes[i] = a, b, d, wrong
                if wrong < _TOLERANCE:
                    continue
                determinant = a * d - b * b
                scale = 1.0 / determinant if determinant else 0.0
                before = places[i]
                x = before[0] - (d * right - b * down) * scale
                y = before[1] - (a * down - b * right) * scale
                beyond = math.hypot(x, y)
                if beyond >= self.max_radius:
                    halfway = 0.5 * (math.hypot(*before) + self.max_radius)
                    x, y = x * halfway / beyond, y * halfway / beyond
                places[i] = x, y
                still.append(i)
            moving = still
            if not moving:
                break
        rows, valid = [], []
        for (x, y), (a, b, d, wrong), goal in zip(places, shapes, wanted, strict=True):
            determinant = a * d - b * b
            scale = 1.0 / determinant if determinant > 0.0 else math.nan
            rows.append((x, y, d * scale, -b * scale, -b * scale, a * scale))
            valid.append(
                wrong < _ACCEPT * (1.0 + max(abs(goal[0]), abs(goal[1])))
                and math.hypot(x, y) < self.max_radius
                and determinant > 0.0
            )
        table = np.array(rows).reshape(-1, 6)
        return table[:, :2], table[:, 2:].reshape(-1, 2, 2), np.array(valid, dtype=np.bool_)

    def _start(self, distorted: Array) -> Array:
        """Return undistorted over distorted radius (n,) by a table of the radial part alone."""
        found = np.interp(distorted, self._table[1], self._table[0])
        ratio: Array = found / np.where(distorted > 0.0, distorted, 1.0)
        return ratio

    def _starts(self, wanted: Rows) -> list[tuple[float, float]]:
        """Return distorted points x, y stretched by the same, in plain numbers."""
        undistorted, radii = self._listed
        found: list[tuple[float, float]] = []
        for x, y in wanted:
            distorted = math.hypot(x, y)
            if 0.0 < distorted < radii[-1]:
                i = bisect_right(radii, distorted)
                slope = (undistorted[i] - undistorted[i - 1]) / (radii[i] - radii[i - 1])
                stretch = (undistorted[i - 1] + slope * (distorted - radii[i - 1])) / distorted
            else:
                stretch = undistorted[-1] / distorted if distorted else 0.0
            found.append((x * stretch, y * stretch))
        return found

    def monotonic(self, points: Array, jacobian: Array) -> Mask:
        """Return whether undistorted points (n, 2) lie where the lens does not fold, (n,)."""
        determinant = jacobian[:, 0, 0] * jacobian[:, 1, 1] - jacobian[:, 0, 1] * jacobian[:, 1, 0]
        inside: Mask = determinant > 0.0
        if self.max_radius < math.inf:
            inside &= np.hypot(points[:, 0], points[:, 1]) < self.max_radius
        return inside

    def _inside(
        self, x: Array, y: Array, before_x: Array | float, before_y: Array | float
    ) -> tuple[Array, Array]:
        """Return steps that left the monotonic region shortened to half the way to its edge."""
        if math.isinf(self.max_radius):
            return x, y
        radius = np.hypot(x, y)
        outside = radius >= self.max_radius
        if not outside.any():
            return x, y
        halfway = 0.5 * (np.hypot(before_x, before_y) + self.max_radius)
        factor = np.where(outside, halfway / np.where(outside, radius, 1.0), 1.0)
        return x * factor, y * factor


def _beside(x: Array, y: Array) -> Array:
    """Return (n, 2) of two columns."""
    pairs = np.empty((len(x), 2))
    pairs[:, 0], pairs[:, 1] = x, y
    return pairs


def _symmetric(a: Array, b: Array, d: Array) -> Array:
    """Return matrices (n, 2, 2) of their xx, xy and yy."""
    matrices = np.empty((len(a), 2, 2))
    matrices[:, 0, 0], matrices[:, 1, 1] = a, d
    matrices[:, 0, 1] = matrices[:, 1, 0] = b
    return matrices


class Equidistant:
    """`equidistant`: distorted radius = t (1 + k1 t² + k2 t⁴ + k3 t⁶ + k4 t⁸), t = angle off axis.

    Args:
        coefficients: (4,) k1 k2 k3 k4.

    Attributes:
        max_angle: rad off axis up to which the radius grows, at most pi.
    """

    def __init__(self, coefficients: Array) -> None:
        self._k = np.concatenate([[1.0], np.asarray(coefficients, np.float64)])
        square = _first_positive_root(self._k * (2.0 * np.arange(5) + 1.0))
        self.max_angle = min(math.sqrt(square), math.pi)
        angles = np.linspace(0.0, self.max_angle, _KNOTS)
        self._table = angles, self.radius(angles)[0]

    def radius(self, angle: Array) -> tuple[Array, Array]:
        """Return the distorted radius and its derivative at angles off axis (rad)."""
        s = angle * angle
        _, k1, k2, k3, k4 = self._k
        value = angle * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4))))
        slope = 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * (7.0 * k3 + s * 9.0 * k4)))
        return value, slope

    def angle(self, radius: Array) -> tuple[Array, Array, Mask]:
        """Invert `radius` by Newton's method.

        Returns:
            Angles (n,), the derivative of the radius there (n,), and whether each is valid (n,).
        """
        guess = np.interp(radius, self._table[1], self._table[0])
        value, slope = self.radius(guess)
        for _ in range(_STEPS):
            if np.all(np.abs(value - radius) < _TOLERANCE):
                break
            step = guess - (value - radius) / np.where(slope > 1e-12, slope, 1e-12)
            step = np.where(step >= self.max_angle, 0.5 * (guess + self.max_angle), step)
            guess = np.where(step < 0.0, 0.5 * guess, step)
            value, slope = self.radius(guess)
        valid: Mask = (np.abs(value - radius) < _ACCEPT * (1.0 + radius)) & (slope > 0.0)
        return guess, slope, valid & (guess < self.max_angle)
