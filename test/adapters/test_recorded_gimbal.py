# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recorded metadata of a real gimballed sensor through profile keys, feed, telemetry and posing.

The recording gives platform and sensor angles and, independently of them, where the middle of the
image lay: the direction to it must come out. A wrong order or sign gives 3.7 deg or more.
"""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import numpy as np
import pymap3d
import pytest

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import SceneTelemetry
from aerial_gnss_ros.core.values.rejection import Input

KEYS = {  # MISB ST 0601 in the words of a profile
    "fix.altitude_datum": "amsl",
    "attitude.type": "vector3",
    "attitude.unit": "deg",
    "attitude.world": "ned",
    "attitude.body": "frd",
    "gimbal.type": "vector3",
    "gimbal.unit": "deg",
    "gimbal.body": "frd",
    "gimbal.reference": "body",
    "height.source": "none",
    "surface.altitude": 0.0,
}
PLATFORM = ("platform_roll_deg", "platform_pitch_deg", "platform_heading_deg")
SENSOR = ("sensor_rel_roll_deg", "sensor_rel_elevation_deg", "sensor_rel_azimuth_deg")


class Telemetry:
    """Takes the feed's values as the estimator does, and gives poses."""

    def __init__(self, config):
        self.inputs, self.posing = TelemetryBuffers(config), PoseBuilder(config)

    def __getattr__(self, name):
        source = Input(name.removeprefix("add_"))
        return lambda value: self.inputs.add(source, value)

    def pose(self, stamp_ns):
        samples = self.inputs.at(stamp_ns)
        return self.posing.pose(samples) if isinstance(samples, SceneTelemetry) else None


def errors_deg(rows, platform_later_s, **changed):
    """Return the angle between the camera's axis and the recorded middle of the image, deg."""
    config = estimator_config(KEYS | changed)
    telemetry = Telemetry(config)
    handle = {s.name: s.handle for s in Feed(config, telemetry).subscriptions}
    found = []
    for index, row in enumerate(rows):
        stamp_ns = round(row["unix_time_s"] * 1e9)
        fix = {
            "latitude": row["sensor_lat_deg"],
            "longitude": row["sensor_lon_deg"],
            "altitude": row["sensor_alt_msl_m"],
        }
        _send(handle["fix"], "sensor_msgs/msg/NavSatFix", stamp_ns, fix)
        vector = "geometry_msgs/msg/Vector3Stamped"
        before_ns = stamp_ns - round(platform_later_s * 1e9)
        _send(handle["attitude"], vector, before_ns, {"vector": _angles(row, PLATFORM)})
        _send(handle["gimbal"], vector, stamp_ns, {"vector": _angles(row, SENSOR)})
        earlier = rows[max(index - 1, 0)]  # its later platform angles have come
        pose = telemetry.pose(round(earlier["unix_time_s"] * 1e9))
        if index == 0 or pose is None:
            continue
        found.append(_error_deg(pose, earlier))
    return found


def _error_deg(pose, row):
    to_middle = pymap3d.geodetic2enu(
        row["frame_center_lat_deg"], row["frame_center_lon_deg"],
        row["frame_center_elev_msl_m"], row["sensor_lat_deg"], row["sensor_lon_deg"],
        row["sensor_alt_msl_m"],
    )  # fmt: skip
    cosine = pose.enu_from_camera[:, 0] @ to_middle / np.linalg.norm(to_middle)
    return math.degrees(math.acos(min(1.0, cosine)))


def _send(handle, msgtype, stamp_ns, fields):
    sec, nanosec = divmod(stamp_ns, 10**9)
    header = {"stamp": {"sec": sec, "nanosec": nanosec}}
    handle(make(msgtype, fields | {"header": header}), stamp_ns)


def _angles(row, names):
    return {axis: row[name] for axis, name in zip("xyz", names, strict=True)}


@pytest.fixture(scope="module")
def rows(shared_data):
    with (shared_data / "klv_cheyenne.csv").open(newline="") as file:
        return [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(file)]


@pytest.mark.parametrize(
    ("platform_later_s", "median_deg", "most_deg"), [(0.0, 0.11, 0.40), (0.05, 0.06, 0.18)]
)
def test_the_recorded_direction_is_found(rows, platform_later_s, median_deg, most_deg):
    errors = errors_deg(rows, platform_later_s)
    assert len(errors) >= len(rows) - 1
    assert np.median(errors) < median_deg
    assert np.percentile(errors, 95) < most_deg


@pytest.mark.parametrize(
    "changed",
    [
        {"gimbal.reference": "heading"},
        {"gimbal.body": "flu"},
        {"attitude.body": "flu"},
        {"attitude.world": "enu"},
    ],
)
def test_any_wrong_key_is_seen(rows, changed):
    assert np.median(errors_deg(rows[::10], 0.0, **changed)) > 3.0


if __name__ == "__main__":  # python test/adapters/test_recorded_gimbal.py ../shared/data
    with (Path(sys.argv[1]) / "klv_cheyenne.csv").open(newline="") as recording:
        table = [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(recording)]
    for later_s in (0.0, 0.05):
        errors = errors_deg(table, later_s)
        sys.stdout.write(
            f"platform's angles {later_s:.2f} s later: median {np.median(errors):.3f} deg, "
            f"95 % {np.percentile(errors, 95):.3f} deg, {len(errors)} images\n"
        )
