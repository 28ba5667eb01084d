# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values between two telemetry samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.geometry.frames import slerp, wrap_angle
from aerial_gnss_ros.core.geometry.geodesy import metres_per_radian
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar


def _linear(before: float, after: float, fraction: float) -> float:
    return before + fraction * (after - before)


def interpolate_scalars(before: Scalar, after: Scalar, fraction: float, stamp_ns: int) -> Scalar:
    """Return the value at `fraction` of the way; across a jump, what it would be without it."""
    value = after.value
    if before.jumped != after.jumped:
        value -= sum(after.jumped) - sum(before.jumped)
    return Scalar(stamp_ns, _linear(before.value, value, fraction), before.jumped)


def interpolate_orientations(
    before: Orientation, after: Orientation, fraction: float, stamp_ns: int
) -> Orientation:
    """Return the orientation at `fraction` of the shortest rotation.

    Between samples relative to different frames, and across a jump of the sensor, there is none:
    NaN.
    """
    if before.reference != after.reference or before.jumped != after.jumped:
        return Orientation(stamp_ns, np.full(4, np.nan))
    turned = slerp(before.quaternion, after.quaternion, fraction)
    return Orientation(stamp_ns, turned, before.reference, before.jumped)


def interpolate_fixes(before: Fix, after: Fix, fraction: float, stamp_ns: int) -> Fix:
    """Return the position at `fraction` of the way.

    It is valid only where both samples are. Across a jump, it is what it would be without it.
    Longitude goes the shorter way, across 180 deg if necessary. Over the metres between two fixes,
    linear interpolation of latitude and longitude is exact to 0.1 mm.
    """
    if before.jumped != after.jumped:
        after = _before_jump(after, before.jumped)
    longitude = before.longitude + fraction * wrap_angle(after.longitude - before.longitude)
    return Fix(
        stamp_ns,
        _linear(before.latitude, after.latitude, fraction),
        float(wrap_angle(longitude)),
        _linear(before.altitude, after.altitude, fraction),
        _covariance(before.covariance, after.covariance, fraction),
        before.valid and after.valid,
        before.jumped,
    )


def _before_jump(fix: Fix, jumped: tuple[float, ...]) -> Fix:
    """Return where a receiver would be that had jumped by less: `jumped`, East and North, m."""
    (east, north), (e, n) = fix.jumped or (0.0, 0.0), jumped or (0.0, 0.0)
    across, along = metres_per_radian(fix.latitude)
    return replace(
        fix,
        latitude=fix.latitude - (north - n) / along,
        longitude=fix.longitude - (east - e) / across,
    )


def _covariance(before: Array | None, after: Array | None, fraction: float) -> Array | None:
    if before is None or after is None:
        return after if before is None else before
    mixed: Array = before + fraction * (after - before)
    return mixed
