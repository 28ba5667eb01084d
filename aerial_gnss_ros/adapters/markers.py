# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Markers for RViz and Foxglove: a 95 % error ellipse and the label of each robot."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State
from aerial_gnss_ros.core.values.samples import Array

CYLINDER, TEXT, ADD, DELETE_ALL = 3, 9, 0, 3  # visualization_msgs/Marker
ELLIPSE_95 = math.sqrt(5.991)  # chi-square, two degrees of freedom
THICKNESS_M = 0.05
TEXT_HEIGHT_M = 0.6
LEAST_DIAMETER_M = 0.02  # viewers warn about a scale of zero

_COLORS = {
    State.CONFIRMED: {"r": 0.10, "g": 0.75, "b": 0.35, "a": 0.45},
    State.COASTING: {"r": 0.95, "g": 0.60, "b": 0.10, "a": 0.35},
}
_WHITE = {"r": 1.0, "g": 1.0, "b": 1.0, "a": 1.0}


def marker_array(result: FrameResult, frames: Frames) -> dict[str, Any]:
    """Return a visualization_msgs/MarkerArray of all robots.

    It begins with DELETEALL: a lost robot disappears, and a late viewer needs only the latched last
    array. A robot's markers have its id as namespace and stable numbers.
    """
    header = header_fields(result.stamp_ns, frames.map)
    markers: list[dict[str, Any]] = [
        {"header": header, "action": DELETE_ALL, "pose": _pose(0.0, 0.0, 0.0, 0.0)}
    ]
    for estimate in result.estimates:
        up, _ = frames.up(estimate, result.datum)
        markers += [_ellipse(estimate, header, up), _name(estimate, header, up)]
    return {"markers": markers}


def ellipse_axes(covariance: Array) -> tuple[float, float, float]:
    """Return one sigma along the long axis and the short one, m, and the long axis's yaw, rad.

    Args:
        covariance: (2, 2) East, North in m².
    """
    variances, axes = np.linalg.eigh(covariance)
    short, long = np.sqrt(np.maximum(variances, 0.0))
    return float(long), float(short), math.atan2(axes[1, 1], axes[0, 1])


def _ellipse(estimate: RobotEstimate, header: dict[str, Any], up: float) -> dict[str, Any]:
    long, short, yaw = ellipse_axes(estimate.covariance[:2, :2])
    east, north = estimate.position
    return {
        "header": header,
        "ns": estimate.robot_id,
        "id": 0,
        "type": CYLINDER,
        "action": ADD,
        "pose": _pose(float(east), float(north), up, yaw),
        "scale": {
            "x": max(2.0 * ELLIPSE_95 * long, LEAST_DIAMETER_M),
            "y": max(2.0 * ELLIPSE_95 * short, LEAST_DIAMETER_M),
            "z": THICKNESS_M,
        },
        "color": _COLORS[estimate.state],
    }


def _name(estimate: RobotEstimate, header: dict[str, Any], up: float) -> dict[str, Any]:
    east, north = estimate.position
    coasting = " (not seen)" if estimate.state is State.COASTING else ""
    return {
        "header": header,
        "ns": estimate.robot_id,
        "id": 1,
        "type": TEXT,
        "action": ADD,
        "pose": _pose(float(east), float(north), up + TEXT_HEIGHT_M, 0.0),
        "scale": {"x": TEXT_HEIGHT_M, "y": TEXT_HEIGHT_M, "z": TEXT_HEIGHT_M},
        "color": _WHITE,
        "text": estimate.robot_id + coasting,
    }


def _pose(x: float, y: float, z: float, yaw: float) -> dict[str, Any]:
    return {
        "position": {"x": x, "y": y, "z": z},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2.0), "w": math.cos(yaw / 2.0)},
    }
