# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Depths of robots: recently reported ones, otherwise parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.corrections import DepthConfig
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.refraction import depth_slopes
from aerial_gnss_ros.core.telemetry.series import Series, held_series
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.core.values.samples import Scalar

Array = NDArray[np.float64]

DEEPEST_M = 20.0
"""Greatest depth at which a robot is visible from the air, m."""
HIGHEST_M = 0.5
"""Greatest height above the surface that a depth sensor may read by waves and weather, m."""


def depth_input(class_id: str) -> str:
    """Return the name of the input of a class's depth; an empty class stands for all."""
    return f"depth_{class_id}" if class_id else "depth"


class Depths:
    """Depths by class and time.

    Args:
        config: parameters and topics.
        keep_s: time for which samples are kept, s.

    Attributes:
        used: whether any robot is below the surface, by parameters or reports.
    """

    def __init__(self, config: DepthConfig, keep_s: float = 60.0) -> None:
        self._config = config
        self._max_age_ns = round(config.max_age * 1e9)
        keep_s = max(keep_s, config.max_age)
        self._series: dict[str, Series[Scalar]] = {
            name: held_series(keep_s=keep_s) for name in config.by_topic()
        }
        self.used = bool(config.robots_m or config.classes or self._series)

    def add(self, class_id: str, depth: Scalar) -> str:
        """Store a depth; return why it is unusable, else empty.

        Args:
            class_id: of the robots; empty for all.
            depth: m below the surface; a little above it (negative) counts as at it.
        """
        if not math.isfinite(depth.value):
            return f"its value is {depth.value}"
        if depth.value > DEEPEST_M:
            return f"{depth.value:g} m is deeper than any robot is seen ({DEEPEST_M:g} m)"
        if depth.value < -HIGHEST_M:
            return f"{depth.value:g} m is above the surface; depths are positive downward"
        self._series[class_id].add(replace(depth, value=max(depth.value, 0.0)))
        return ""

    def at(self, class_ids: Sequence[str], stamp_ns: int) -> Array | None:
        """Return the depths (n,) of robots of some classes at a time, m; None: all at the surface.

        Args:
            class_ids: (n,) class names.
            stamp_ns: time of the scene, ns.
        """
        if not self.used:
            return None
        found = self._config.of(class_ids)
        for i, name in enumerate(class_ids):
            series = self._series.get(name) or self._series.get("")
            sent = None if series is None else series.latest(stamp_ns)
            if sent is not None and stamp_ns - sent.stamp_ns <= self._max_age_ns:
                found[i] = sent.value
        return found

    def clear(self) -> None:
        """Discard all reported depths."""
        for series in self._series.values():
            series.clear()


def inflate_by_depth(
    estimates: tuple[RobotEstimate, ...], pose: CameraPose, local: LocalMap, sigma_m: float
) -> tuple[RobotEstimate, ...]:
    """Return robots with the share of an uncertain depth in their covariances.

    The depth error is constant for minutes, so averaging over images does not reduce it: it is
    added to published covariances, not in the filter.

    Args:
        estimates: of the robots.
        pose: of the camera.
        local: the frame `map`.
        sigma_m: one sigma of the depth, m.
    """
    if not sigma_m or not estimates:
        return estimates
    camera = local.positions([pose.latitude], [pose.longitude])[0]
    rays = np.array([[*(one.position - camera), -pose.height] for one in estimates])
    slope = sigma_m * depth_slopes(rays / np.linalg.norm(rays, axis=1)[:, None])
    found = []
    for estimate, (east, north) in zip(estimates, slope, strict=True):
        covariance = estimate.covariance.copy()
        covariance[:2, :2] += [[east * east, east * north], [east * north, north * north]]
        found.append(replace(estimate, covariance=covariance))
    return tuple(found)
