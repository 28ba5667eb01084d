# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots whose estimates are of no use beside their boxes begin anew at these.

An update is linear in the robot's position. Where that is uncertain by more than the distance from
the camera to the box, the update overshoots: a thing seen near the horizon by a wrong pose, later
80 m before the camera, came to lie 1.7 km behind it, where no box can correct it. So little is
known of such a robot that nothing is lost with it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import on_water, state_jacobian
from aerial_gnss_ros.core.models.platform_model import COUNT

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def reinitialize_lost(
    joint: JointState, slots: Indices, pixels: Array, seen: Mask, sight: CameraView
) -> bool:
    """Put robots where their boxes are if the boxes could not correct them; return whether any.

    Args:
        joint: changed in place; relinearised at this image.
        slots: (m,) indices in `rows`.
        pixels: (m, 2) of their boxes.
        seen: (m,) whether the camera sees the estimated places.
        sight: the camera.
    """
    variances = joint.covariance.diagonal()[COUNT:].reshape(-1, 4)[slots]
    variance = variances[:, 0] + variances[:, 1]
    if seen.all() and not (variance > sight.measured.position[2] ** 2).any():
        return False
    pose = sight.pose(joint.mean[:COUNT])
    rays, valid = sight.camera.rays(pixels)
    places = on_water(pose, rays @ (pose.rotation @ FLU_FROM_OPTICAL).T)
    offsets = on_water_surface(places) - pose.position
    met = valid & np.isfinite(offsets).all(axis=1)
    lost = met & (~seen | (variance > np.square(offsets).sum(axis=1)))
    if not lost.any():
        return False
    speeds = np.sqrt(0.5 * (variances[lost, 2] + variances[lost, 3]))
    joint.forget_robots(slots[lost], speeds)
    joint.robots[slots[lost], :2] = places[lost]
    states = np.concatenate([offsets[lost], np.zeros((int(lost.sum()), 2))], axis=1)
    joint.by_pose[slots[lost]] = state_jacobian(states)
    return True
