# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Positions by methods that use each image by itself: `single` and `paper`.

The tracker gives labels and velocities with all methods; a robot in view has the position of its
own box, with the full covariance of a single point.
"""

from __future__ import annotations

from dataclasses import replace

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints, locate
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.values.estimates import RobotEstimate


def exact_points(frame: PosedFrame, points: WaterPoints, config: EstimatorConfig) -> WaterPoints:
    """Return the exact points for tracking while the paper's are published.

    Args:
        frame: the image.
        points: by the paper's equations, including their refusals.
        config: all parameters.
    """
    centers = frame.detections.centers
    exact = locate(frame.pose, frame.camera, centers, config.noise, config)
    both = zip(points.reasons, exact.reasons, strict=True)
    return replace(exact, reasons=tuple(one or other for one, other in both))


def at_own_points(
    update: TrackUpdate, points: WaterPoints, local: LocalMap
) -> tuple[RobotEstimate, ...]:
    """Return an update's robots, with measured ones at the points of their boxes."""
    return tuple(
        _at_point(estimate, points, update.measured[estimate.robot_id], local)
        if estimate.robot_id in update.measured
        else estimate
        for estimate in update.estimates
    )


def _at_point(
    estimate: RobotEstimate, points: WaterPoints, row: int, local: LocalMap
) -> RobotEstimate:
    latitude, longitude = float(points.latitude[row]), float(points.longitude[row])
    covariance = estimate.covariance.copy()
    covariance[:2, 2:] = covariance[2:, :2] = 0.0
    covariance[:2, :2] = points.covariance[row]
    return replace(
        estimate,
        latitude=latitude,
        longitude=longitude,
        position=local.positions([latitude], [longitude])[0],
        covariance=covariance,
        white=None if estimate.white is None else points.covariance_white[row],
    )
