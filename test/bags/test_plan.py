# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which recorded topics a replay reads, and what it says where some lack."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.bags.plan import make_plan, recorded_name, resolve
from aerial_gnss_ros.bags.reader import Topic
from aerial_gnss_ros.core.values.errors import InputError

FIX, POSE = "sensor_msgs/msg/NavSatFix", "geographic_msgs/msg/GeoPoseStamped"
BOXES, IMAGE = "vision_msgs/msg/Detection2DArray", "sensor_msgs/msg/Image"


def bag(**topics):
    found = {"/" + name.replace("__", "/"): kind for name, kind in topics.items()}
    return SimpleNamespace(
        paths=["flight"], topics={name: Topic(name, kind, 3) for name, kind in found.items()}
    )


def subscription(name, topic, msgtype, got=None, **more):
    handle = (lambda _m, ns: got.append((name, ns))) if got is not None else (lambda *_: None)
    return Subscription(name, topic, msgtype, 1, handle, **more)


INPUTS = [
    subscription("fix", "fix", FIX),
    subscription("height", "height", "std_msgs/msg/Float64", required=False),
    subscription("detections", "detections", BOXES),
]


@pytest.mark.parametrize(
    ("topic", "namespace", "found"),
    [
        ("fix", "", "/fix"),
        ("fix", "/d1/", "/d1/fix"),
        ("/fix", "d1", "/fix"),
        ("a/b", "c", "/c/a/b"),
    ],
)
def test_a_topic_is_resolved_as_ros_does(topic, namespace, found):
    assert resolve(topic, namespace) == found


def test_recorded_boxes_are_used_unless_the_detector_is_asked_for():
    recorded = bag(d1__fix=FIX, d1__detections=BOXES, d1__camera__image=IMAGE)
    plan = make_plan(recorded, INPUTS, "camera/image", namespace="d1")
    assert plan.topics == {"/d1/fix", "/d1/detections"}
    assert plan.image_topic is None
    plan = make_plan(recorded, INPUTS, "camera/image", namespace="d1", detect=True)
    assert plan.topics == {"/d1/fix", "/d1/camera/image"}
    assert "/d1/detections" not in plan.routes


def test_one_topic_may_serve_two_inputs():
    got = []
    both = [subscription("fix", "pose", POSE, got), subscription("attitude", "pose", POSE, got)]
    plan = make_plan(bag(pose=POSE, detections=BOXES), [*both, INPUTS[2]], "image")
    assert plan.routes["/pose"].name == "fix and attitude"
    plan.routes["/pose"].handle(None, 7)
    assert got == [("fix", 7), ("attitude", 7)]


def test_the_newest_version_of_a_topic_is_read():
    versioned = subscription("fix", "fix", FIX, versioned=True)
    recorded = bag(fix_v2=FIX, fix_v10=FIX)
    assert recorded_name(recorded, versioned, "") == "/fix_v10"
    assert recorded_name(recorded, INPUTS[0], "") == "/fix"


@pytest.mark.parametrize(
    ("topics", "words"),
    [
        ({"detections": BOXES}, r"lacks /fix \(fix, sensor_msgs/msg/NavSatFix\)"),
        ({"detections": BOXES, "d2__fix": FIX}, r"try --namespace d2\."),
        ({"detections": BOXES, "d2__truth__fix": FIX}, "lacks /fix"),
        ({"detections": BOXES, "fix": POSE}, "fix.type or fix.topic"),
        ({"fix": FIX}, "flight"),
    ],
)
def test_what_cannot_be_replayed_is_said_with_what_to_do(topics, words):
    with pytest.raises(InputError, match=words):
        make_plan(bag(**topics), INPUTS, "image")
