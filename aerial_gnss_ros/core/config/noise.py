# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Standard deviations of every sensor: two named sets, each value a parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key

_FROM_SET = "NaN: from the set."
_NAN = math.nan


def _sigma(doc: str, unit: str, high: float, low: float = 0.0) -> float:
    value: float = key(_NAN, f"{doc} {_FROM_SET}", unit=unit, low=low, high=high, optional=True)
    return value


@dataclass(frozen=True)
class Noise:
    """One-sigma sensor errors; slow ones drift with correlation_time_s and do not average out."""

    set: str = key(
        "consumer",
        "consumer: a hobby or inspection drone; rtk: GNSS at centimetres, better attitude. Too "
        "small values cause overconfident positions.",
        choices=("consumer", "rtk"),
    )
    gnss_offset_m: float = _sigma(
        "Slow GNSS offset, each horizontal axis, if the fix has no covariance.", "m", 100.0
    )
    gnss_white_m: float = _sigma("White GNSS noise, each horizontal axis.", "m", 100.0)
    heading_deg: float = _sigma("Slow error of heading (compass).", "deg", 180.0)
    gimbal_pitch_deg: float = _sigma("Slow error of the camera's pitch.", "deg", 45.0)
    gimbal_roll_deg: float = _sigma("Slow error of the camera's roll.", "deg", 45.0)
    height_m: float = _sigma("Slow error of the height above water.", "m", 100.0)
    latency_s: float = _sigma(
        "Error of camera.latency_s; above 0 it is estimated in flight, up to three times as much.",
        "s",
        3.0,
    )
    correlation_time_s: float = _sigma("Correlation time of the slow errors.", "s", 1e6)
    attitude_white_deg: float = _sigma("White noise of the attitude, each axis.", "deg", 45.0)
    gimbal_white_deg: float = _sigma("White noise of the gimbal, each axis.", "deg", 45.0)
    height_white_m: float = _sigma("White noise of the height.", "m", 100.0)
    box_center_px: float = _sigma("White noise of a box's centre, each axis.", "px", 500.0, 0.01)
    robot_acceleration: float = _sigma(
        "Process noise of a robot's velocity (random walk): larger follows turns faster, smooths "
        "less.",
        "m/s^1.5",
        100.0,
    )

    @property
    def exact(self) -> tuple[str, ...]:
        """Slow errors that are stated to be 0: no published covariance contains them."""
        slow = ("gnss_offset_m", "heading_deg", "gimbal_pitch_deg", "gimbal_roll_deg", "height_m")
        return tuple(name for name in slow if self.value(name) == 0.0)

    def __hash__(self) -> int:
        """Return an equal number for equal ones; that of all values takes longer than its use."""
        return hash(self.set)

    def value(self, name: str) -> float:
        """Return a standard deviation: the parameter, or the set's value if it is NaN."""
        given = float(getattr(self, name))
        return SETS[self.set][name] if math.isnan(given) else given


_CONSUMER = {
    "gnss_offset_m": 1.2,
    "gnss_white_m": 0.03,
    "heading_deg": 1.5,
    "gimbal_pitch_deg": 0.4,
    "gimbal_roll_deg": 0.4,
    "height_m": 0.3,
    "latency_s": 0.0,
    "correlation_time_s": 300.0,
    "attitude_white_deg": 0.1,
    "gimbal_white_deg": 0.03,
    "height_white_m": 0.03,
    "box_center_px": 2.0,
    "robot_acceleration": 0.05,
}
SETS = {
    "consumer": _CONSUMER,
    "rtk": _CONSUMER
    | {
        "gnss_offset_m": 0.02,
        "heading_deg": 0.3,
        "gimbal_pitch_deg": 0.15,
        "gimbal_roll_deg": 0.15,
        "height_m": 0.05,
    },
}
