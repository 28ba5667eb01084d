# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One physical scene in every vehicle's messages gives one answer: profile, adapter, feed, core."""

from __future__ import annotations

import functools
import importlib.util
import math
import sys
from dataclasses import make_dataclass
from pathlib import Path

import numpy as np
import pymap3d
import pytest

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.bags import typestore as shipped
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.geometry.magnetic import declination
from aerial_gnss_ros.core.values.estimates import State


def load(name):
    """Return a module that lies beside this file; test folders are no packages."""
    spec = importlib.util.spec_from_file_location(
        f"aerial_gnss_tests_{name}", Path(__file__).with_name(f"{name}.py")
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


types, scenes, messages_of = load("vehicle_types"), load("scenes"), load("vehicle_messages")
VEHICLES = messages_of.VEHICLES
SCENES = dict(scenes.scenes())

START_NS = 1_700_000_000 * 10**9
IMAGE_NS = START_NS + 50_000_000
TIMES_NS = (START_NS, START_NS + 100_000_000)
SLOW_CLOCK_NS = 40_000_000_000  # what an unused header says: hours off
INFO = {
    "width": scenes.WIDTH,
    "height": scenes.HEIGHT,
    "distortion_model": "plumb_bob",
    "k": [scenes.FOCAL, 0, scenes.WIDTH / 2, 0, scenes.FOCAL, scenes.HEIGHT / 2, 0, 0, 1],
}
ONCE = {"tracks.confirm_hits": 1, "method": "single"}

Surveyed = make_dataclass("Surveyed", ["scene", "undulation_m", "declination_deg"])
Surveyed.__getattr__ = lambda self, name: getattr(self.scene, name)


def surveyed(scene):
    """Return a scene that also knows its undulation and its declination."""
    place = math.radians(scene.latitude_deg), math.radians(scene.longitude_deg)
    east = declination(*place, IMAGE_NS, scene.altitude_m)
    return Surveyed(scene, undulation(*place), math.degrees(east))


def by_rosbags(msgtype, fields):
    store = types.extended()
    return store.deserialize_cdr(
        bytes(store.serialize_cdr(shipped.make(msgtype, fields, store), msgtype)), msgtype
    )


def by_rclpy(msgtype, fields):
    messages = pytest.importorskip(
        "aerial_gnss_ros.nodes.ros_messages", reason="ROS 2 is not installed"
    )
    return messages.message(msgtype, fields)


@functools.cache
def profile(name):
    return read([vehicle_file(name)], {"estimator": EstimatorConfig})["estimator"]


def config_of(vehicle, scene):
    own = vehicle.values(scene) if callable(vehicle.values) else vehicle.values
    return estimator_config(profile(vehicle.profile) | own | ONCE)


def boxes(scene, message):
    u, v = scene.robot()[2]
    box = {"center": {"position": {"x": u, "y": v}}, "size_x": 8.0, "size_y": 8.0}
    best = {"hypothesis": {"class_id": "aqua", "score": 0.9}}
    fields = {
        "header": messages_of.header(IMAGE_NS),
        "detections": [{"bbox": box, "results": [best]}],
    }
    return message("vision_msgs/msg/Detection2DArray", fields)


def located(vehicle, scene, message=by_rosbags):
    """Send a scene's messages through feed and estimator; return the one robot found."""
    config = config_of(vehicle, scene)
    estimator = Estimator(config)
    feed = {s.name: s for s in Feed(config, estimator).subscriptions}
    wanted = {name for name, s in feed.items() if s.required}
    assert wanted - {"detections", "camera_info"} <= set(vehicle.messages)
    info = INFO | {"header": messages_of.header(START_NS)}
    feed["camera_info"].handle(message("sensor_msgs/msg/CameraInfo", info), START_NS)
    for time_ns in TIMES_NS:
        for name, (msgtype, encode) in vehicle.messages.items():
            if name not in feed:
                continue
            assert feed[name].msgtype == msgtype.replace("px4_old_msgs", "px4_msgs")
            group = getattr(config, {"home": "height", "tf_static": "gimbal"}.get(name, name))
            stamp_ns = SLOW_CLOCK_NS if group.stamp == "arrival" else time_ns
            feed[name].handle(message(msgtype, encode(scene, stamp_ns)), time_ns)
    feed["detections"].handle(boxes(scene, message), TIMES_NS[1])
    (result,) = estimator.advance(TIMES_NS[1])
    assert not result.rejections, result.rejections
    (robot,) = result.estimates
    assert robot.state is State.CONFIRMED
    return robot


def distance_m(robot, scene):
    latitude, longitude, _ = scene.robot()
    east, north, _ = pymap3d.geodetic2enu(
        math.degrees(robot.latitude), math.degrees(robot.longitude), scene.water_m,
        latitude, longitude, scene.water_m,
    )  # fmt: skip
    return math.hypot(east, north)


@pytest.mark.filterwarnings("ignore:Gimbal lock")  # of scipy, for a mount that looks straight down
@pytest.mark.parametrize("scene", [pytest.param(surveyed(s), id=n) for n, s in SCENES.items()])
def test_every_vehicle_finds_the_robot_where_it_is(scene):
    errors, altitudes = {}, {}
    for name, vehicle in VEHICLES.items():
        robot = located(vehicle, scene)
        errors[name] = distance_m(robot, scene)
        assert math.isnan(robot.altitude) is not vehicle.altitude, name
        if vehicle.altitude:
            altitudes[name] = robot.altitude - scene.water_m
    assert {name: e for name, e in errors.items() if e > 0.01} == {}
    assert {name: a for name, a in altitudes.items() if abs(a) > 0.01} == {}


STANDARD = {
    name: vehicle
    for name, vehicle in VEHICLES.items()
    if not any(kind.startswith(("mavros_", "px4_")) for kind, _ in vehicle.messages.values())
}


@pytest.mark.parametrize("name", STANDARD)
def test_rclpys_messages_are_read_like_those_of_rosbags(name):
    pytest.importorskip("sensor_msgs", reason="ROS 2 is not installed")
    for key in ("nose33_down45", "-16.5,180_down45"):
        scene = surveyed(SCENES[key])
        assert distance_m(located(STANDARD[name], scene, by_rclpy), scene) < 0.01


def test_the_scenes_are_those_that_go_wrong_elsewhere():
    headings = {s.heading_deg // 90 for s in SCENES.values()}
    assert headings == {0, 1, 2, 3}
    assert {s.down_deg for s in SCENES.values()} == {0.0, 45.0, 85.0, 90.0}
    aside = {abs(s.camera_heading_deg - s.heading_deg) for s in SCENES.values()}
    assert aside == {40.0}
    tilted = [math.degrees(math.acos(s.ned_body[2, 2])) for s in SCENES.values()]
    assert max(tilted) > 14.9
    assert {v.profile for v in VEHICLES.values()} == set(vehicle_names())
    # one scene in which the robot lies beyond the antimeridian
    assert any(
        s.longitude_deg * s.robot()[1] < 0.0 for s in SCENES.values() if abs(s.longitude_deg) > 90
    )


@pytest.mark.parametrize(
    ("name", "values", "least_m"),
    [
        # what goes wrong when a profile's key is wrong: the test above would see it
        ("mavros_px4, flags heading", {"gimbal.reference": "earth"}, 5.0),
        ("mavros_px4, servo mount", {"gimbal.reference": "mavlink_flags"}, 5.0),
        ("anafi", {"gimbal.world": "enu"}, 5.0),
        ("dji_psdk", {"gimbal.type": "vector3"}, 0.015),  # 0.012 deg of yaw
        ("generic, magnetic gimbal", {"gimbal.north": "true"}, 5.0),
        ("generic, TF below the body", {"gimbal.reference": "heading"}, 5.0),
        ("generic, TF in the world", {"gimbal.reference": "heading"}, 5.0),
        ("generic, range finder on the body", {"height.along": "vertical"}, 0.5),
    ],
)
def test_a_wrong_key_is_a_wrong_position(name, values, least_m):
    scene = surveyed(SCENES["nose231_down0"])
    vehicle = VEHICLES[name]
    own = vehicle.values if isinstance(vehicle.values, dict) else vehicle.values(scene)
    changed = messages_of.Vehicle(vehicle.profile, vehicle.messages, own | values)
    assert distance_m(located(changed, scene), scene) > least_m


def test_a_mistake_of_a_degree_is_seen():
    scene = surveyed(SCENES["nose33_down45"])
    vehicle = VEHICLES["generic"]
    turned = messages_of.quaternion(
        lambda s: messages_of.enu(scenes._ned(s.camera_heading_deg + 1.0, -s.down_deg, 0.0))
    )
    wrong = messages_of.Vehicle("generic", vehicle.messages | {"gimbal": turned}, vehicle.values)
    assert distance_m(located(wrong, scene), scene) == pytest.approx(
        np.radians(1.0) * 18.0, rel=0.5
    )


def table():
    """Return a line for each vehicle with its largest error over all scenes, mm."""
    surveyed_scenes = [surveyed(scene) for scene in SCENES.values()]
    lines = []
    for name, vehicle in VEHICLES.items():
        errors = [1e3 * distance_m(located(vehicle, s), s) for s in surveyed_scenes]
        lines.append(f"{name:<40} {len(errors)} scenes, largest error {max(errors):.3f} mm")
    return lines


if __name__ == "__main__":  # python test/adapters/test_cross_vehicle.py
    shipped.typestore = types.extended
    sys.stdout.write("\n".join([*table(), ""]))
