# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a soak makes of its minutes, and the faults that it puts in."""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from soak_judge import Minute, Usage, minute_of, verdict


def minutes(
    count=30, growth_mb=0.0, segments_mb=0.0, threads=0.0, work=0.0, delay=0.0, noise=(0.0,), **last
):
    """Return minutes in which something grows from the first to the last by so much."""
    made, work_s = [], 0.0
    for i in range(count):
        share = i / (count - 1)
        work_s += 60.0 * (0.5 + work * share)
        used = Usage(
            1,
            memory_mb=150.0 + growth_mb * share,
            descriptors=20,
            threads=14 + round(threads * share),
            shared_mb=30.0 * share,  # of what is mapped
            segments_mb=34.0 + segments_mb * share,
            processor_s=work_s,
        )
        middle = 30.0 + delay * share + noise[i % len(noise)]
        made.append(Minute("none", {"estimator": used}, (middle, 2.0 * middle), (1.0, 2.0), 90.0))
    made[-1] = dataclasses.replace(made[-1], **last)
    return made


def failed(made):
    return [finding.what for finding in verdict(made) if not finding.passed]


def test_nothing_is_found_where_nothing_grows():
    assert failed(minutes()) == []
    assert failed(minutes(growth_mb=6.0)) == []  # 3.8 MB between the thirds
    assert failed(minutes(noise=(0.0, 500.0, 70.0, 40.0))) == []  # a machine that others share


@pytest.mark.parametrize(
    ("grown", "found"),
    [
        ({"growth_mb": 10.0}, "estimator: memory"),
        ({"segments_mb": 10.0}, "estimator: shared memory that it maps"),
        ({"threads": 3.0}, "estimator: threads"),
        ({"work": 0.3}, "estimator: processor time a position"),
        ({"delay": 30.0}, "delay, the best quarter of the minutes"),
        ({"delay": 30.0, "noise": (0.0, 40.0, 5.0)}, "delay, the best quarter of the minutes"),
        ({"ended": 2, "provoked": 1}, "restarts not provoked"),
        ({"wrong": 163}, "wrong positions"),
    ],
)
def test_what_grows_is_found(grown, found):
    assert failed(minutes(**grown)) == [found]


def test_restarts_that_were_provoked_are_none():
    assert failed(minutes(ended=2, provoked=2)) == []
    assert failed(minutes(wrong=162)) == []  # 0.1 % of 90 a second for half an hour


def test_the_warm_up_does_not_count():
    made = minutes(20)
    made[0].usage["estimator"].memory_mb = made[1].usage["estimator"].memory_mb = 50.0
    assert failed(made) == []


def test_a_minute_outlives_its_file():
    (made, *_) = minutes()
    assert minute_of(json.loads(json.dumps(dataclasses.asdict(made)))) == dataclasses.replace(
        made, load=pytest.approx(math.nan, nan_ok=True)
    )


SHOWN = {
    "fix is NaN": ("/fix", lambda fix: math.isnan(fix.latitude)),
    "fix is 0, 0": ("/fix", lambda fix: (fix.latitude, fix.longitude) == (0.0, 0.0)),
    "one stamp a day ahead": ("/fix", lambda fix: fix.header.stamp.sec == 86_407),
    "height jumps by 5 m": ("/height", lambda height: height.data == 25.0),
}


@pytest.mark.parametrize("kind", [*SHOWN, "telemetry silent", "boxes are noise"])
def test_a_disturbance_is_put_in_and_ends(kind, monkeypatch):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from rclpy.serialization import deserialize_message, serialize_message

    from aerial_gnss_ros.benchmarking import disturbing
    from aerial_gnss_ros.nodes.ros_messages import message, message_class

    class Node:
        def __init__(self):
            self.published, self.destroyed = [], 0

        def create_publisher(self, *_):
            return self

        def publish(self, array):
            self.published.append(array)

        def destroy_publisher(self, _):
            self.destroyed += 1

    now = [100.0]
    monkeypatch.setattr(disturbing.time, "monotonic", lambda: now[0])
    types = {
        "/fix": "sensor_msgs/msg/NavSatFix",
        "/height": "std_msgs/msg/Float64",
        "/truth/robots/aqua_1/fix": "sensor_msgs/msg/NavSatFix",
        "/camera/image_raw": "sensor_msgs/msg/Image",
    }
    fields = {
        "/fix": {"latitude": 13.0, "longitude": -59.0, "header": {"stamp": {"sec": 7}}},
        "/height": {"data": 20.0},
        "/camera/image_raw": {"width": 64, "height": 36, "header": {"stamp": {"sec": 7}}},
    }
    fields["/truth/robots/aqua_1/fix"] = fields["/fix"]
    raw = {t: bytes(serialize_message(message(types[t], fields[t]))) for t in types}
    node = Node()
    disturber = disturbing.Disturber(node, types, "/camera/image_raw")
    assert {t: disturber.altered(t, raw[t]) for t in types} == raw
    disturber.begin(kind)
    changed = {t: disturber.altered(t, raw[t]) for t in types}
    assert changed["/truth/robots/aqua_1/fix"] == raw["/fix"]
    assert changed["/camera/image_raw"] == raw["/camera/image_raw"]
    if kind in SHOWN:
        topic, is_shown = SHOWN[kind]
        assert is_shown(deserialize_message(changed[topic], message_class(types[topic])))
    elif kind == "telemetry silent":
        assert changed["/fix"] is changed["/height"] is None
    else:
        (array,) = node.published
        assert len(array.detections) == 12
        assert array.header.stamp.sec == 7
    now[0] += 5.0
    assert {t: disturber.altered(t, raw[t]) for t in types} == raw
    assert node.destroyed == len(node.published)
