# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientations of a real gimballed sensor, stamped later than images and fixes.

Attitudes and sensor angles are recorded (MISB ST 0601, 5 Hz); the path is the recorded one scaled
to a drone at 100 m, boxes of three still robots are simulated.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic, geodetic_from_enu
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

RECORDING = Path(__file__).parents[3] / "shared" / "data" / "klv_cheyenne.csv"
START_NS, HEIGHT_M = 10**18, 100.0
ENU_FROM_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_FROM_FLU = np.diag([1.0, -1.0, -1.0])
ROBOTS = np.array([[0.0, 0.0, 0.0], [6.0, 4.0, 0.0], [-7.0, 3.0, 0.0]])


@pytest.fixture(scope="module")
def flight():
    """Times, places (n, 3) and rotations, and the camera."""
    if not RECORDING.exists():
        pytest.skip(f"{RECORDING.name} of the shared data is absent")
    with RECORDING.open() as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    t = np.array([row["unix_time_s"] for row in rows]) - rows[0]["unix_time_s"]
    names = ("heading_deg", "pitch_deg", "roll_deg")
    body = Rotation.from_euler(
        "ZYX", [[row[f"platform_{name}"] for name in names] for row in rows], degrees=True
    )
    sensor = Rotation.from_euler(
        "ZYX",
        [
            [row[f"sensor_rel_{name}_deg"] for name in ("azimuth", "elevation", "roll")]
            for row in rows
        ],
        degrees=True,
    )
    turn = ENU_FROM_NED @ (body * sensor).as_matrix() @ FRD_FROM_FLU
    middle = rows[len(rows) // 2]
    radians = [
        [math.radians(row["sensor_lat_deg"]), math.radians(row["sensor_lon_deg"])] for row in rows
    ]
    place = enu_from_geodetic(
        *np.array(radians).T, 0.0, math.radians(middle["frame_center_lat_deg"]),
        math.radians(middle["frame_center_lon_deg"]), 0.0,
    )  # fmt: skip
    place[:, 2] = [row["sensor_alt_msl_m"] - middle["frame_center_elev_msl_m"] for row in rows]
    place *= HEIGHT_M / np.mean(place[:, 2])
    focal = 640.0 / math.tan(0.5 * math.radians(middle["hfov_deg"]))
    K = np.array([[focal, 0.0, 639.5], [0.0, focal, 359.5], [0.0, 0.0, 1.0]])
    return t, place, Rotation.from_matrix(turn), CameraModel(1280, 720, "plumb_bob", K, np.zeros(5))


def _record(flight, late_s: float) -> Recording:
    t, place, turn, camera = flight
    recording = Recording(estimator_config({"noise": {"set": "rtk"}}))
    recording.add_camera(START_NS - 10**10, camera)
    origin = 0.7, -1.8
    east, north, height = place.T
    lat, lon, _ = geodetic_from_enu(east, north, 0.0, *origin, 0.0)
    for i, now in enumerate(t):
        stamp = START_NS + round(now * 1e9)
        recording.add_fix(Fix(stamp, float(lat[i]), float(lon[i]), 0.0))
        recording.add_height(Scalar(stamp, float(height[i])))
        recording.add_gimbal(Orientation(stamp + round(late_s * 1e9), turn[i].as_quat()))
    rng, between = np.random.default_rng(1), Slerp(t, turn)
    for now in np.arange(4.0, t[-1] - 4.0, 0.31):
        camera_at = np.array([np.interp(now, t, column) for column in place.T])
        optical = between(now).as_matrix() @ FLU_FROM_OPTICAL
        pixels, seen = camera.project((ROBOTS - camera_at) @ optical)
        seen &= camera.inside(pixels)
        boxes = (pixels + rng.normal(0.0, 2.0, pixels.shape))[seen]
        count = len(boxes)
        recording.add_detections(
            DetectionFrame(
                START_NS + round(now * 1e9), "", boxes, np.full((count, 2), 30.0), np.ones(count),
                ("aqua",) * count,
            )
        )  # fmt: skip
    return recording


@pytest.mark.parametrize("late_s", [0.05, 0.0])
def test_a_delay_of_orientations_is_found(flight, late_s) -> None:
    """Images are as much early against orientations as these are late.

    The flight is a piece of an orbit: what fixes lag by is a turn of the whole about its middle,
    which a wrong heading is, too.
    """
    recording = _record(flight, late_s)
    fit = calibrate(recording, recording.config)
    value, sigma = fit.value("latency")
    assert fit.determined("latency")
    assert value == pytest.approx(-late_s, abs=0.02)
    assert sigma < 0.02
