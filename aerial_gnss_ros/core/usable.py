# SPDX-License-Identifier: Apache-2.0
"""Which samples of telemetry are of use, and in words why others are not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.values import Fix, Orientation, Scalar

UNIT_TOLERANCE = 0.01
"""A quaternion whose length differs from 1 by more is no rotation: zeros, or something else."""

_NO_ORIENTATION = (
    "it gives no orientation: its quaternion is not a number, its driver marks it as not measured "
    "(orientation_covariance[0] is -1), or its flags contradict one another"
)


def usable(value: Fix | Orientation | Scalar) -> tuple[str, Fix | Orientation | Scalar]:
    """Return why a sample is no use (empty: it is), and the sample, marked as such where it is not.

    A fix keeps its flag; the others become NaN, which no interpolation loses.
    """
    if isinstance(value, Fix):
        trouble = _fix_trouble(value)
        return trouble, replace(value, valid=False) if trouble else value
    if isinstance(value, Scalar):
        if math.isfinite(value.value):
            return "", value
        return f"its value is {value.value}", Scalar(value.stamp_ns, math.nan)
    length = math.hypot(*value.quaternion.tolist())
    if abs(length - 1.0) <= UNIT_TOLERANCE:  # false for NaN
        return "", value
    if math.isnan(length):
        return _NO_ORIENTATION, value
    trouble = f"its quaternion has length {length:.3g} instead of 1, so it is no rotation"
    return trouble, replace(value, quaternion=np.full(4, np.nan))


def _fix_trouble(fix: Fix) -> str:
    latitude, longitude = math.degrees(fix.latitude), math.degrees(fix.longitude)
    if not fix.valid:
        return "the receiver reports no fix"
    if math.isfinite(latitude) and math.isfinite(longitude) and abs(latitude) <= 90.0:
        return ""
    return f"{latitude:g}, {longitude:g} is no place on Earth"
