# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot 20 m north and 30 m east of the origin of `map`, on a northward course."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate, State

LATITUDE, LONGITUDE = math.radians(13.0), math.radians(-59.0)
STAMP = 5_000_000_007
# Every variance is another number, so that a wrong order shows.
COVARIANCE = np.array(
    [
        [4.0, 0.5, 0.0, 0.0],
        [0.5, 9.0, 0.0, 0.0],
        [0.0, 0.0, 0.01, 0.0],
        [0.0, 0.0, 0.0, 0.04],
    ]
)
ROBOT = RobotEstimate(
    stamp_ns=STAMP,
    robot_id="aqua_1",
    class_id="aqua",
    state=State.CONFIRMED,
    latitude=LATITUDE,
    longitude=LONGITUDE,
    altitude=-42.0,
    position=np.array([30.0, 20.0]),
    velocity=np.array([0.0, 2.0]),
    covariance=COVARIANCE,
    last_seen_ns=STAMP,
)
DATUM = MapDatum(LATITUDE, LONGITUDE, -20.0)  # of the drone's first fix
POSE = CameraPose(1, LATITUDE, LONGITUDE, 22.0, -20.0, np.eye(3))
RESULT = FrameResult(STAMP, "camera", (ROBOT,), (), DATUM, POSE)
SEEN = Sighting(
    "aqua_1", 1_700_000_000_120_000_000, math.radians(13.19394), math.radians(-59.64151),
    math.nan, 1.0, True, "d1",
)  # fmt: skip
"""A position as `aerial-gnss stream` receives it; 2023-11-14 22:13:20.12 UTC, a Tuesday."""
