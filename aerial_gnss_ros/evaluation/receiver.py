# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors without the drone's own GNSS error.

The paper takes truth and estimate from the same receiver, so that its offset cancels (reference:
"accuracy said to surpass GNSS"). Such a figure is relative: it shows the part of the error that the
drone could reduce, since nothing aboard can observe the receiver's offset.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.bags.tables import Track
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors
from aerial_gnss_ros.evaluation.truth import track


def read_fixes(bag: BagReader, topic: str) -> Track:
    """Read the NavSatFix messages of one topic; an absent topic gives an empty track."""
    rows = []
    for recorded in bag.messages({topic}):
        fix = recorded.message()
        rows.append((nanoseconds(fix.header.stamp), fix.latitude, fix.longitude))
    return track(rows)


def relative(robots: list[RobotErrors], measured: Track, true: Track) -> list[RobotErrors]:
    """Return the errors less the receiver's own at the same stamps.

    Args:
        robots: absolute errors. The published covariance is of these, not of the relative ones, so
            NEES and sigma become NaN.
        measured: the drone's fixes.
        true: the drone's true path.
    """
    start = measured.stamps_ns[0]
    knots = (measured.stamps_ns - start) * 1e-9
    latitude, longitude = _at(true, measured.stamps_ns)
    distance, azimuth, _ = geodesic_inverse(
        latitude, longitude, measured.latitude, measured.longitude
    )
    east, north = distance * np.sin(azimuth), distance * np.cos(azimuth)
    moved = []
    for robot in robots:
        seconds = (robot.stamps_ns - start) * 1e-9
        own = np.stack([np.interp(seconds, knots, east), np.interp(seconds, knots, north)], -1)
        left, unknown = robot.east_north - own, np.full(len(own), np.nan)
        moved.append(replace(robot, east_north=left, nees=unknown, sigma=unknown))
    return moved


def _at(path: Track, stamps_ns: np.typing.NDArray[np.int64]) -> tuple[Array, Array]:
    start = path.stamps_ns[0]
    seconds, knots = (stamps_ns - start) * 1e-9, (path.stamps_ns - start) * 1e-9
    return (
        np.interp(seconds, knots, path.latitude),
        np.interp(seconds, knots, np.unwrap(path.longitude)),
    )
