# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientations in a message's own axes to FLU in ENU, or in the vehicle's FLU."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.config.telemetry import AttitudeConfig, GimbalConfig
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_rpy,
    quaternion_from_matrix,
    to_enu_flu,
    to_level_flu,
)
from aerial_gnss_ros.core.values.samples import Array, Orientation

MAVLINK_FLAGS = "mavlink_flags"

MOST_RAD = 1000.0 * 2.0 * math.pi
"""Drivers may unwrap angles over many turns, but the sine of a larger number is meaningless, and
any sine and cosine would make a valid rotation."""


def from_angles(roll: float, pitch: float, yaw: float) -> Array:
    """Return the quaternion (4,) x, y, z, w of Rz(yaw) Ry(pitch) Rx(roll).

    Args:
        roll: rad.
        pitch: rad.
        yaw: rad.

    Returns:
        NaN, so that the core refuses it, if an angle is beyond `MOST_RAD` or not finite.
    """
    if not all(abs(angle) <= MOST_RAD for angle in (roll, pitch, yaw)):  # true for NaN
        return np.full(4, np.nan)
    return quaternion_from_matrix(matrix_from_rpy(roll, pitch, yaw))


def body(quaternion: Array, stamp_ns: int, config: AttitudeConfig) -> Orientation:
    """Return the body FLU in ENU.

    Args:
        quaternion: (4,) x, y, z, w of `config.body` axes in `config.world` axes.
        stamp_ns: time of validity, ns.
        config: names the axes.
    """
    return Orientation(stamp_ns, to_enu_flu(quaternion, config.world, config.body))


def camera(
    quaternion: Array, stamp_ns: int, config: GimbalConfig, reference: str = ""
) -> Orientation:
    """Return the camera FLU in ENU, or in the vehicle's FLU if it is relative to the vehicle.

    Args:
        quaternion: (4,) x, y, z, w of `config.body` axes in `config.world` axes, or in the
            vehicle's `config.body` axes.
        stamp_ns: time of validity, ns.
        config: names the axes and their reference.
        reference: the message's own reference; used only if the configuration leaves it to the
            message.
    """
    own = reference if config.reference == MAVLINK_FLAGS else ""
    if (own or config.reference) == "earth":
        turned = to_enu_flu(quaternion, config.world, config.body)
    else:
        turned = to_level_flu(quaternion, config.body)
    return Orientation(stamp_ns, turned, own)
