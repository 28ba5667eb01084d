# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests each telemetry sample by itself, with reasons in words."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

import numpy as np

from aerial_gnss_ros.core.config.limits import LimitsConfig
from aerial_gnss_ros.core.geometry.geodesy import SEMI_MAJOR_M
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar

UNIT_TOLERANCE = 0.01
"""Greatest deviation of a quaternion's length from 1."""

SYMMETRY = 0.01
"""Greatest asymmetry of a covariance, as a share of the standard deviations."""

ALTITUDES_M = (-1000.0, 100_000.0)
"""Plausible altitudes of a drone above any datum, m."""

_NO_ORIENTATION = (
    "it has no orientation: its quaternion is not a number, an angle is beyond 1,000 turns, its "
    "driver marks it as not measured (orientation_covariance[0] is -1), or its flags contradict "
    "one another"
)
_DEFAULTS = LimitsConfig()


Sample = TypeVar("Sample", bound=Fix | Orientation | Scalar)


def validate(
    value: Fix | Orientation | Scalar, limits: LimitsConfig = _DEFAULTS
) -> tuple[str, Fix | Orientation | Scalar]:
    """Return why a sample is unusable (empty: usable), and the sample, marked if it is unusable."""
    if isinstance(value, Fix):
        trouble = _fix_trouble(value, limits)
    elif isinstance(value, Scalar):
        trouble = _scalar_trouble(value.value, limits.height_max_m)
    else:
        trouble = _orientation_trouble(math.hypot(*value.quaternion.tolist()))
    return trouble, unusable(value) if trouble else value


def _orientation_trouble(length: float) -> str:
    if abs(length - 1.0) <= UNIT_TOLERANCE:  # false for NaN
        return ""
    if math.isnan(length):
        return _NO_ORIENTATION
    return f"its quaternion has length {length:.3g} instead of 1, so it is not a rotation"


def unusable(value: Sample) -> Sample:
    """Return a sample marked as unusable: a fix that is not valid, a value that is NaN.

    Interpolation preserves both.
    """
    nothing: dict[str, object] = {"quaternion": np.full(4, np.nan)}
    if isinstance(value, Fix):
        nothing = {"valid": False}
    elif isinstance(value, Scalar):
        nothing = {"value": math.nan}
    return replace(value, **nothing)  # type: ignore[arg-type]


def _scalar_trouble(value: float, most: float) -> str:
    if not math.isfinite(value):
        return f"its value is {value}: nothing was measured, or a range finder is at its stop"
    if abs(value) > most:
        return f"{value:g} m is more than limits.height_max_m ({most:g} m)"
    return ""


def _fix_trouble(fix: Fix, limits: LimitsConfig) -> str:
    latitude, longitude = math.degrees(fix.latitude), math.degrees(fix.longitude)
    if not fix.valid:
        return "the receiver reports no fix"
    if not (abs(fix.latitude) <= 0.5 * math.pi and abs(fix.longitude) <= math.pi):  # true for NaN
        return f"{latitude:g}, {longitude:g} is not on Earth"
    if SEMI_MAJOR_M * math.hypot(fix.latitude, fix.longitude) < limits.null_island_m:
        return f"{latitude:g}, {longitude:g} is what a receiver without a fix sends"
    if math.isinf(fix.altitude) or not _within(fix.altitude, ALTITUDES_M):
        return f"its altitude is {fix.altitude:g} m, where no drone can be"
    return "" if fix.covariance is None else _covariance_trouble(fix.covariance, limits)


def _within(value: float, bounds: tuple[float, float]) -> bool:
    """Return whether a value lies within bounds, or is NaN: not given."""
    return math.isnan(value) or bounds[0] <= value <= bounds[1]


def _covariance_trouble(covariance: Array, limits: LimitsConfig) -> str:
    """Return why the horizontal part of a covariance is invalid; the vertical one is not used."""
    (east, one), (other, north) = np.asarray(covariance, dtype=np.float64)[:2, :2].tolist()
    if not math.isfinite(east + north + one + other):
        return f"its covariance is not a number: variances {east:g}, {north:g} m²"
    product = east * north
    symmetric = abs(one - other) <= SYMMETRY * math.sqrt(max(product, 0.0))
    if not (east > 0.0 and north > 0.0 and one * other < product and symmetric):
        return (
            f"it is not a covariance: variances {east:g}, {north:g} m², covariances {one:g}, "
            f"{other:g} m²; a driver without one must set its type to 0, unknown"
        )
    sigma = math.sqrt(max(east, north))
    if sigma > limits.fix_sigma_m:
        return f"it states {sigma:g} m of uncertainty, too much for a fix (limits.fix_sigma_m)"
    return ""
