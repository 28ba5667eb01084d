# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Adds to a result what a person who watches needs: footprint, pixels, depths, references."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.geometry.refraction import WATER_INDEX
from aerial_gnss_ros.core.georeferencing.footprint import outline
from aerial_gnss_ros.core.georeferencing.localization import bad_pose
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.core.values.overview import Overview
from aerial_gnss_ros.core.values.samples import Array


def overview(
    result: FrameResult, inputs: TelemetryBuffers, config: EstimatorConfig, shift_ns: int = 0
) -> Overview:
    """Return a result with its surroundings; nothing is changed.

    Args:
        result: of one image, soon after it was made: inputs are kept for a minute.
        inputs: the estimator's.
        config: with the greatest range of positions.
        shift_ns: the buffers' time less the stamps, ns.
    """
    time_ns = result.stamp_ns + shift_ns
    names = [one.class_id for one in result.estimates]
    depths = inputs.depths.at(names, time_ns)
    depths = np.zeros(len(names)) if depths is None else depths
    camera = inputs.cameras.at(time_ns)
    pose = None if result.pose is None or bad_pose(result.pose) else result.pose
    footprint, pixels = np.empty((0, 2)), np.full((len(names), 2), np.nan)
    size = None
    if isinstance(camera, CameraModel):
        size = (camera.width, camera.height)
        if pose is not None:
            footprint = outline(pose, camera, config.surface.max_range)
            pixels = robot_pixels(result.estimates, depths, pose, camera)
    return Overview(result, footprint, pixels, depths, inputs.references.at(time_ns), size)


def robot_pixels(
    robots: tuple[RobotEstimate, ...], depths: Array, pose: CameraPose, camera: CameraModel
) -> Array:
    """Return where robots are in the image, (k, 2) u, v in px; NaN outside it.

    A robot below the surface seems to be as deep as its depth over the index of refraction, which
    is exact for a vertical view and enough to tell whose box is whose.

    Args:
        robots: (k,) of this image.
        depths: (k,) m.
        pose: of the camera.
        camera: its intrinsics.
    """
    if not robots:
        return np.empty((0, 2))
    water = 0.0 if math.isnan(pose.altitude) else pose.altitude - pose.height
    points = enu_from_geodetic(
        [one.latitude for one in robots],
        [one.longitude for one in robots],
        water - depths / WATER_INDEX,
        pose.latitude,
        pose.longitude,
        water + pose.height,
    )
    pixels, valid = camera.project(points @ pose.enu_from_camera @ FLU_FROM_OPTICAL)
    pixels[~valid] = np.nan
    return pixels
