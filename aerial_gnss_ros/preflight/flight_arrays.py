# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A monitored flight as arrays over time, and the changes of its angles and lengths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import heading_from_yaw, yaw_of
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.preflight.flight_state import STEP_NS, FlightState
from aerial_gnss_ros.preflight.pointing import view_heading

Array = NDArray[np.float64]

STEP_S = STEP_NS * 1e-9
LAG = round(2.0 / STEP_S)
"""Changes are taken over two seconds."""
HALF = round(1.0 / STEP_S)
FAST = 1.5
"""Least speed at which a course is meaningful, m/s."""


@dataclass(frozen=True)
class FlightArrays:
    """States as arrays (n,), NaN where unknown; angles in rad."""

    east_north: Array
    altitude: Array
    height: Array
    nose: Array
    up: Array
    view: Array
    below: Array
    velocity: Array


def flight_arrays(states: Sequence[FlightState]) -> FlightArrays:
    """Return states in order of time, `STEP_NS` apart, as arrays."""
    count = len(states)
    places = np.full((count, 3), np.nan)
    up = np.full((count, 3), np.nan)
    height, nose, view, below = (np.full(count, np.nan) for _ in range(4))
    for i, state in enumerate(states):
        if state.fix is not None:
            places[i] = state.fix.latitude, state.fix.longitude, state.fix.altitude
        if state.body is not None:
            up[i] = state.body[:, 2]
            nose[i] = heading_from_yaw(yaw_of(state.body))
        if state.height is not None:
            height[i] = state.height
        if state.pose is not None:
            camera = state.pose.enu_from_camera
            view[i] = view_heading(camera)
            below[i] = -math.asin(max(-1.0, min(1.0, float(camera[2, 0]))))
    return FlightArrays(
        east_north := _east_north(places), places[:, 2], height, nose, up, view, below,
        _velocity(east_north),
    )  # fmt: skip


def _east_north(places: Array) -> Array:
    known = np.isfinite(places[:, 0])
    if not known.any():
        return np.full((len(places), 2), np.nan)
    first = places[known][0]
    enu = enu_from_geodetic(places[:, 0], places[:, 1], 0.0, first[0], first[1], 0.0)
    return enu[:, :2]


def _velocity(east_north: Array) -> Array:
    velocity = np.full_like(east_north, np.nan)
    if len(east_north) > 2 * HALF:
        ahead, back = east_north[2 * HALF :], east_north[: -2 * HALF]
        velocity[HALF:-HALF] = (ahead - back) / (2.0 * HALF * STEP_S)
    return velocity


def courses(flight: FlightArrays) -> Array:
    """Return compass courses (n,) in rad; NaN below `FAST`."""
    east, north = flight.velocity.T
    fast = np.hypot(east, north) > FAST
    return np.where(fast, np.arctan2(east, north), np.nan)


def differences(values: Array) -> Array:
    """Return how values change over two seconds."""
    if len(values) <= LAG:
        return np.full(0, np.nan)
    return np.asarray(values[LAG:] - values[:-LAG])


def changes(angles: Array) -> Array:
    """Return how angles change over two seconds, each step the shorter way, rad."""
    if len(angles) <= LAG:
        return np.full(0, np.nan)
    steps = np.diff(angles)
    steps = (steps + math.pi) % (2.0 * math.pi) - math.pi
    return np.asarray(np.convolve(steps, np.ones(LAG), mode="valid"))


def correlation(a: Array, b: Array) -> float:
    """Return the uncentred correlation of two arrays (n,)."""
    norm = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / norm if norm > 0.0 else 0.0
