# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References of a gimbal's angles, and the axes of its errors."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_of

Array = NDArray[np.float64]


class Reference(str, Enum):
    """The frame in which a gimbal reports the camera's orientation.

    EARTH: ENU. HEADING: level, x along the vehicle's nose (roll and pitch from the horizon, yaw
    from the nose). BODY: the airframe with its tilt. FIXED: no gimbal, a constant mount in the
    body. MAVLINK_FLAGS: each message states one of these.
    """

    EARTH = "earth"
    HEADING = "heading"
    BODY = "body"
    FIXED = "fixed"
    MAVLINK_FLAGS = "mavlink_flags"

    def __str__(self) -> str:
        return self.value

    @property
    def needs_attitude(self) -> bool:
        """Whether the body's orientation is required."""
        return self is not Reference.EARTH

    @property
    def needs_gimbal(self) -> bool:
        """Whether a gimbal reading is required."""
        return self is not Reference.FIXED


_KINDS: dict[str, Reference] = {one.value: one for one in Reference}


def mount_matrix(rpy_deg: ArrayLike) -> Array:
    """Return the fixed camera FLU in the body FLU (3, 3) of roll, pitch, yaw in degrees."""
    roll, pitch, yaw = np.radians(np.asarray(rpy_deg, dtype=np.float64))
    return matrix_from_rpy(roll, pitch, yaw)


def enu_from_camera(
    reference: Reference | str,
    gimbal: Array | None,
    enu_from_flu: Array | None,
    mount: Array | None = None,
) -> Array:
    """Return the camera FLU in ENU, (3, 3), at one instant.

    Args:
        reference: of the gimbal's angles.
        gimbal: (3, 3) camera FLU in that frame; not used with `fixed`.
        enu_from_flu: (3, 3) body FLU in ENU at the same instant; not used with `earth`.
        mount: (3, 3) camera FLU in the body FLU; only with `fixed`.

    Raises:
        ValueError: an argument that the reference needs is absent, or an unknown reference.
    """
    kind = _KINDS.get(reference) or Reference(reference)
    if kind is Reference.MAVLINK_FLAGS:
        raise ValueError("a reading must state whether it is relative to earth, heading or body")
    if enu_from_flu is None and kind is not Reference.EARTH:
        raise ValueError(f"gimbal reference {kind} needs the body's orientation")
    inner = mount if kind is Reference.FIXED else gimbal
    if inner is None:
        what = "reading" if kind.needs_gimbal else "mount"
        raise ValueError(f"gimbal reference {kind} needs a {what}")
    if kind is Reference.EARTH or enu_from_flu is None:
        return inner
    outer = enu_from_flu
    if kind is Reference.HEADING:
        outer = matrix_from_rpy(0.0, 0.0, yaw_of(enu_from_flu))
    turned: Array = outer @ inner
    return turned


def error_axes(enu_from_camera_: Array) -> Array:
    """Return the axes of a camera's slow errors in ENU: roll, pitch, heading.

    A stabilised camera is levelled by gravity and turned by a compass: its errors are two tilts
    about level axes and a turn about the vertical. The roll axis is the level direction in which
    the top of the view lies (where the camera looks, unless it looks straight down), the pitch axis
    is level to the left, the heading axis is up.

    Args:
        enu_from_camera_: (3, 3) camera FLU in ENU.

    Returns:
        (3, 3), columns are unit axes; small corrections c (3,) give the true orientation
        exp(skew(axes @ c)) @ enu_from_camera.
    """
    east, north = float(enu_from_camera_[0, 1]), float(enu_from_camera_[1, 1])
    length = math.hypot(east, north)
    if length < 1e-6:  # rolled by 90 deg: left is vertical, so take the direction of view
        east, north = -float(enu_from_camera_[1, 0]), float(enu_from_camera_[0, 0])
        length = math.hypot(east, north)
    east, north = east / length, north / length
    return np.array([[north, east, 0.0], [-east, north, 0.0], [0.0, 0.0, 1.0]])
