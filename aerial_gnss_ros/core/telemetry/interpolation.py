# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values between two telemetry samples."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.geometry.frames import slerp, wrap_angle
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar


def _linear(before: float, after: float, fraction: float) -> float:
    return before + fraction * (after - before)


def interpolate_scalars(before: Scalar, after: Scalar, fraction: float, stamp_ns: int) -> Scalar:
    """Return the value at `fraction` of the way."""
    return Scalar(stamp_ns, _linear(before.value, after.value, fraction))


def interpolate_orientations(
    before: Orientation, after: Orientation, fraction: float, stamp_ns: int
) -> Orientation:
    """Return the orientation at `fraction` of the shortest rotation.

    Between samples relative to different frames there is none: NaN.
    """
    if before.reference != after.reference:
        return Orientation(stamp_ns, np.full(4, np.nan))
    turned = slerp(before.quaternion, after.quaternion, fraction)
    return Orientation(stamp_ns, turned, before.reference)


def interpolate_fixes(before: Fix, after: Fix, fraction: float, stamp_ns: int) -> Fix:
    """Return the position at `fraction` of the way; it is valid only where both samples are.

    Longitude goes the shorter way, across 180 deg if necessary. Over the metres between two fixes,
    linear interpolation of latitude and longitude is exact to 0.1 mm.
    """
    longitude = before.longitude + fraction * wrap_angle(after.longitude - before.longitude)
    return Fix(
        stamp_ns,
        _linear(before.latitude, after.latitude, fraction),
        float(wrap_angle(longitude)),
        _linear(before.altitude, after.altitude, fraction),
        _covariance(before.covariance, after.covariance, fraction),
        before.valid and after.valid,
    )


def _covariance(before: Array | None, after: Array | None, fraction: float) -> Array | None:
    if before is None or after is None:
        return after if before is None else before
    mixed: Array = before + fraction * (after - before)
    return mixed
