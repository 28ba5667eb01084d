# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a camera points, and which point on the water its image centre shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, heading_from_yaw, wrap_angle
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]

_STEEP = math.cos(math.radians(80.0))
_SIDES = ("ahead", "ahead to the right", "to the right", "behind to the right", "behind",
          "behind to the left", "to the left", "ahead to the left")  # fmt: skip


@dataclass(frozen=True)
class ViewCenter:
    """Line of sight of the image centre, and its point on the water.

    Attributes:
        heading: compass heading of the view, rad; see `view_heading` for steep ones.
        below_horizon: rad; negative looks at the sky.
        distance: horizontal, from the drone to the point on the water, m; NaN where there is none.
        range_m: from the camera, m; NaN where there is none.
        bearing: compass bearing of the point from the drone, rad; NaN where there is none.
        latitude: of the point, rad; NaN where there is none.
        longitude: rad.
    """

    heading: float
    below_horizon: float
    distance: float
    range_m: float
    bearing: float
    latitude: float
    longitude: float


def view_center(pose: CameraPose, camera: CameraModel | None = None) -> ViewCenter:
    """Return the line of sight of the image centre, without a camera that of the optical axis."""
    direction = pose.enu_from_camera[:, 0]
    if camera is not None:
        middle = np.array([[0.5 * (camera.width - 1), 0.5 * (camera.height - 1)]])
        rays, valid = camera.rays(middle)
        if valid[0]:
            direction = pose.enu_from_camera @ (FLU_FROM_OPTICAL @ rays[0])
    view = SurfaceView(pose)
    distance = float(view.distances(direction[None])[0])
    heading = view_heading(pose.enu_from_camera)
    below = -math.asin(max(-1.0, min(1.0, float(direction[2]))))
    if math.isnan(distance):
        return ViewCenter(heading, below, math.nan, math.nan, math.nan, math.nan, math.nan)
    offset = direction * distance
    latitude, longitude, _ = view.geodetic(offset[None])
    return ViewCenter(
        heading,
        below,
        math.hypot(offset[0], offset[1]),
        distance,
        float(heading_from_yaw(math.atan2(offset[1], offset[0]))),
        float(latitude[0]),
        float(longitude[0]),
    )


def view_heading(enu_from_camera: Array) -> float:
    """Return the compass heading in rad of where a camera (3, 3) looks.

    Within 10 deg of straight down it is that of the image's top, and within 10 deg of straight up
    that of the image's bottom: the view itself has none there, and a camera that is tilted over
    keeps its heading so.
    """
    axis, top = enu_from_camera[:, 0], enu_from_camera[:, 2]
    if math.hypot(axis[0], axis[1]) < _STEEP:
        axis = top if axis[2] < 0.0 else -top
    return float(heading_from_yaw(math.atan2(axis[1], axis[0])))


def relative_direction(bearing: float, nose: float) -> str:
    """Return a compass bearing (rad) in words, seen from the nose's heading (rad)."""
    relative = float(wrap_angle(bearing - nose))
    return _SIDES[round(relative / (math.pi / 4.0)) % 8]
