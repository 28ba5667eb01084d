# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The feed listens to what the configuration names and stamps as it says."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.samples import Scalar


class Recorder:
    """Stands for the estimator: keeps what it is given."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *values: self.calls.append((name, *values))


def feed(values=None, warn=None):
    recorder = Recorder()
    made = Feed(estimator_config(values or {}), recorder, warn)
    return {s.name: s for s in made.subscriptions}, recorder


HEADER = {"stamp": {"sec": 1, "nanosec": 5}}
STAMP, ARRIVAL = 1_000_000_005, 7_000_000_000


def test_the_defaults_are_the_canonical_topics():
    subscriptions, _ = feed()
    assert {s.name: (s.topic, s.msgtype, s.required) for s in subscriptions.values()} == {
        "detections": ("detections", "vision_msgs/msg/Detection2DArray", True),
        "camera_info": ("camera/camera_info", "sensor_msgs/msg/CameraInfo", True),
        "fix": ("fix", "sensor_msgs/msg/NavSatFix", True),
        "attitude": ("attitude", "sensor_msgs/msg/Imu", False),
        "gimbal": ("gimbal", "geometry_msgs/msg/QuaternionStamped", True),
        "height": ("height", "std_msgs/msg/Float64", True),
        "water_level": ("water_level", "std_msgs/msg/Float64", False),
    }


def test_depths_come_on_the_topics_of_their_classes():
    found, recorder = feed({"depth.topics": ["depth", "red=red/depth"]})
    assert [(found[n].topic, found[n].required) for n in ("depth", "depth_red")] == [
        ("depth", False), ("red/depth", False),
    ]  # fmt: skip
    found["depth_red"].handle(make("std_msgs/msg/Float64", {"data": 0.6}), ARRIVAL)
    assert recorder.calls == [("add_depth", "red", Scalar(ARRIVAL, 0.6))]


def test_references_that_move_send_fixes():
    pier = {"class": "beacon", "position": [13.0, -59.0], "sigma_m": 0.1}
    boat = {"class": "boat", "topic": "boat/fix", "sigma_m": 0.1}
    found, recorder = feed({"references": {"pier": pier, "boat": boat}})
    assert "reference_pier" not in found
    one = found["reference_boat"]
    assert (one.topic, one.msgtype, one.required) == (
        "boat/fix", "sensor_msgs/msg/NavSatFix", False,
    )  # fmt: skip
    one.handle(make("sensor_msgs/msg/NavSatFix", {"header": HEADER, "latitude": 90.0}), ARRIVAL)
    [(called, name, fix)] = recorder.calls
    assert (called, name, fix.stamp_ns) == ("add_reference", "boat", STAMP)
    assert fix.latitude == pytest.approx(math.pi / 2.0)


@pytest.mark.parametrize(
    ("values", "absent"),
    [
        ({"gimbal.reference": "fixed"}, "gimbal"),
        ({"gimbal.source": "constant"}, "gimbal"),
        ({"attitude.source": "constant"}, "attitude"),
        ({"height.source": "constant", "height.value_m": 9.0}, "height"),
        (
            {
                "height.source": "none",
                "surface.altitude": 0.0,
                "fix.altitude_datum": "amsl",
            },
            "height",
        ),
        (
            {"fix.source": "constant", "fix.latitude_deg": 1.0, "fix.longitude_deg": 2.0},
            "fix",
        ),
        (
            {
                "camera.source": "parameters",
                "camera.focal_length_mm": 4.0,
                "camera.sensor_width_mm": 6.0,
                "camera.image_width_px": 640,
                "camera.image_height_px": 480,
            },
            "camera_info",
        ),
    ],
)
def test_a_constant_needs_no_topic(values, absent):
    assert set(feed()[0]) - set(feed(values)[0]) == {absent}


@pytest.mark.parametrize("values", [{"gimbal.reference": "body"}, {"camera.offset_m": [0, 0, -1]}])
def test_attitude_is_required_where_it_is_used(values):
    assert feed(values)[0]["attitude"].required


@pytest.mark.parametrize(
    ("name", "method", "msgtype"),
    [
        ("fix", "add_fix", "sensor_msgs/msg/NavSatFix"),
        ("attitude", "add_attitude", "sensor_msgs/msg/Imu"),
        ("gimbal", "add_gimbal", "geometry_msgs/msg/QuaternionStamped"),
    ],
)
@pytest.mark.parametrize(("clock", "expected"), [("header", STAMP), ("arrival", ARRIVAL)])
def test_the_stamp_is_the_header_s_or_the_arrival(name, method, msgtype, clock, expected):
    subscriptions, recorder = feed({f"{name}.stamp": clock})
    subscriptions[name].handle(make(msgtype, {"header": HEADER}), ARRIVAL)
    [(called, value)] = recorder.calls
    assert (called, value.stamp_ns) == (method, expected)


def test_types_follow_the_configuration():
    subscriptions, recorder = feed(
        {
            "attitude.type": "quaternion",
            "gimbal.type": "vector3",
            "height.type": "range",
            "height.stamp": "header",
        }
    )
    assert subscriptions["attitude"].msgtype == "geometry_msgs/msg/QuaternionStamped"
    assert subscriptions["gimbal"].msgtype == "geometry_msgs/msg/Vector3Stamped"
    height = subscriptions["height"]
    height.handle(make(height.msgtype, {"header": HEADER, "range": 7.0}), ARRIVAL)
    [(_, value)] = recorder.calls
    assert (value.stamp_ns, value.value) == (STAMP, 7.0)


def test_numbers_without_a_header_are_stamped_on_arrival():
    subscriptions, recorder = feed()
    for name in ("height", "water_level"):
        subscriptions[name].handle(make("std_msgs/msg/Float64", {"data": 3.0}), ARRIVAL)
    assert [(call, value.stamp_ns, value.value) for call, value in recorder.calls] == [
        ("add_height", ARRIVAL, 3.0),
        ("add_water_level", ARRIVAL, 3.0),
    ]


def test_a_bad_camera_is_passed_on_as_none_and_reported_once():
    reported = []
    subscriptions, recorder = feed(warn=reported.append)
    info = {
        "header": HEADER,
        "width": 640,
        "height": 480,
        "distortion_model": "plumb_bob",
        "k": [500.0, 0, 320, 0, 500, 240, 0, 0, 1],
        "d": [0.0] * 5,
    }
    for fields in (info, info, {"header": HEADER}, {"header": HEADER}, info):
        subscriptions["camera_info"].handle(make("sensor_msgs/msg/CameraInfo", fields), ARRIVAL)
    stamps = [stamp for _, stamp, _ in recorder.calls]
    cameras = [camera for _, _, camera in recorder.calls]
    assert stamps == [STAMP] * 5
    assert cameras[0] is cameras[1]  # not made again for each image
    assert cameras[2:4] == [None, None]
    assert cameras[4].width == 640
    assert len(reported) == 1
    assert reported[0].startswith("camera/camera_info: ")


def test_an_altitude_becomes_a_height_once_home_s_is_known():
    subscriptions, recorder = feed(
        {"height.type": "float32", "height.topic": "altitude", "height.home_topic": "home"}
    )
    assert subscriptions["home"].msgtype == "std_msgs/msg/Float32"
    for name, value in (("height", 40.0), ("home", 12.5), ("height", 40.0), ("home", math.nan)):
        subscriptions[name].handle(make("std_msgs/msg/Float32", {"data": value}), ARRIVAL)
    subscriptions["height"].handle(make("std_msgs/msg/Float32", {"data": 41.0}), ARRIVAL)
    assert [value.value for _, value in recorder.calls] == [27.5, 28.5]


def test_a_camera_info_of_another_clock_is_stamped_on_arrival():
    subscriptions, recorder = feed({"camera.stamp": "arrival"}, warn=lambda _sentence: None)
    subscriptions["camera_info"].handle(
        make("sensor_msgs/msg/CameraInfo", {"header": HEADER}), ARRIVAL
    )
    assert recorder.calls == [("add_camera", ARRIVAL, None)]


WRONG = {
    "fix": ("sensor_msgs/msg/NavSatFix", "latitude", "north"),
    "height": ("std_msgs/msg/Float64", "data", None),
    "gimbal": ("geometry_msgs/msg/QuaternionStamped", "quaternion", 3),
    "detections": ("vision_msgs/msg/Detection2DArray", "detections", [None]),
    "camera_info": ("sensor_msgs/msg/CameraInfo", "k", ["wide"] * 9),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_message_that_cannot_be_read_is_refused_by_its_input(name):
    msgtype, field, value = WRONG[name]
    found, recorder = feed()
    message = make(msgtype, {"header": HEADER} if hasattr(make(msgtype, {}), "header") else {})
    broken = SimpleNamespace(**{**vars(message), field: value})
    found[name].handle(broken, ARRIVAL)
    ((call, refused, why),) = recorder.calls
    assert (call, refused) == ("refuse", name)
    assert "cannot be read" in why


def test_a_message_that_cannot_be_read_is_counted_by_the_estimator():
    config = estimator_config({})
    engine = Estimator(config)
    handle = {s.name: s.handle for s in Feed(config, engine).subscriptions}
    handle["height"](SimpleNamespace(data="high"), ARRIVAL)
    assert (engine.inputs["height"].count, engine.inputs["height"].bad) == (1, 1)
    assert "height is of no use: it cannot be read (ValueError" in engine.take_events()[-1]


def test_a_camera_whose_model_cannot_be_made_is_reported_and_none(monkeypatch):
    reported = []
    found, recorder = feed(warn=reported.append)

    def failing(*_args):
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(canonical, "camera", failing)
    found["camera_info"].handle(make("sensor_msgs/msg/CameraInfo", {"header": HEADER}), ARRIVAL)
    assert recorder.calls == [("add_camera", STAMP, None)]
    assert reported == ["camera/camera_info: this CameraInfo is unusable (LinAlgError: singular)."]
