# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Least angle of a recording's camera from straight down, from telemetry alone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.bags.plan import resolve
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Fix

STEP_NS = 500_000_000
"""Interval of poses, ns: a hover lasts a second."""
_THINNED_NS = 90_000_000  # one in five of 50 Hz suffices, and decoding takes most of the time
_GRID = (33, 19)  # rays of an image in columns and rows: 3 deg apart in a lens of 90 deg


class _Watch:
    """Passes all inputs to an estimator, and requests a pose about every fix."""

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self._last_ns = -STEP_NS
        self.camera: CameraModel | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._estimator, name)

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        self.camera = camera or self.camera
        self._estimator.add_camera(stamp_ns, camera)

    def add_fix(self, fix: Fix) -> None:
        self._estimator.add_fix(fix)
        if fix.stamp_ns - self._last_ns >= STEP_NS:
            self._last_ns = fix.stamp_ns
            nothing = np.zeros((0, 2))
            self._estimator.add_detections(
                DetectionFrame(fix.stamp_ns, "", nothing, nothing, np.zeros(0), ())
            )


def nearest_view(bag: BagReader, config: EstimatorConfig, namespace: str = "") -> float:
    """Return the least angle between straight down and any ray of the images, rad.

    NaN if the recording's telemetry alone gives no pose.

    Args:
        bag: open.
        config: names the telemetry.
        namespace: that relative topics were recorded in.

    Raises:
        InputError: the bag is damaged.
    """
    estimator = Estimator(replace(config, method="single", state_file=""))
    watch = _Watch(estimator)
    routes = {
        resolve(one.topic, namespace): one
        for one in Feed(config, watch).subscriptions
        if one.name != "detections"
    }
    least = math.nan
    read: dict[str, int] = {}
    for recorded in bag.messages(set(routes) & set(bag.topics)):
        if recorded.log_ns - read.get(recorded.topic, -STEP_NS) < _THINNED_NS:
            continue
        read[recorded.topic] = recorded.log_ns
        routes[recorded.topic].handle(recorded.message(), recorded.log_ns)
        for result in estimator.advance(recorded.log_ns):
            if result.pose is not None and watch.camera is not None:
                least = float(np.fmin(least, _off_vertical(result.pose, watch.camera)))
    return least


def _off_vertical(pose: CameraPose, camera: CameraModel) -> float:
    """Return the least angle between straight down and a ray of an image, rad."""
    columns = np.linspace(0.0, camera.width - 1.0, _GRID[0])
    rows = np.linspace(0.0, camera.height - 1.0, _GRID[1])
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    rays, valid = camera.rays(pixels)
    down = -(rays[valid] @ (pose.enu_from_camera @ FLU_FROM_OPTICAL).T)[:, 2]
    return float(np.arccos(np.clip(down.max(initial=-1.0), -1.0, 1.0)))
