# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which profile fits the topics that there are, and in which namespace."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.adapters.matching import SeenTopic, candidates, fits, other_drones

FIX, HEIGHT = "sensor_msgs/msg/NavSatFix", "std_msgs/msg/Float64"
POSE = "geometry_msgs/msg/PoseStamped"


def inputs(*described):
    """Return a feed's subscriptions: name, topic, type, and whether it is required."""
    return [
        Subscription(name, topic, msgtype, 1, lambda *_: None, required, versioned=versioned)
        for name, topic, msgtype, required, versioned in described
    ]


PROFILES = {
    "boat": inputs(
        ("fix", "gps/fix", FIX, True, False), ("height", "gps/height", HEIGHT, False, False),
        ("detections", "detections", "vision_msgs/msg/Detection2DArray", True, False),
    ),
    "plane": inputs(
        ("fix", "/fmu/fix", FIX, True, True), ("height", "gps/height", HEIGHT, True, False)
    ),
}  # fmt: skip


def seen(**topics):
    return [SeenTopic("/" + name.replace("__", "/"), msgtype) for name, msgtype in topics.items()]


@pytest.mark.parametrize(
    ("topics", "profile", "namespace", "matched", "missing"),
    [
        ({"gps__fix": FIX}, "boat", "", {"fix"}, []),
        ({"d1__gps__fix": FIX, "d1__gps__height": HEIGHT}, "boat", "d1", {"fix", "height"}, []),
        ({"a__b__gps__fix": FIX}, "boat", "a/b", {"fix"}, []),
        ({"gps__fix": HEIGHT, "gps__height": HEIGHT}, "plane", "", {"height"}, ["fix"]),
        ({"fmu__fix_v2": FIX, "d2__gps__height": HEIGHT}, "plane", "d2", {"fix", "height"}, []),
        ({}, "boat", "", set(), ["fix"]),
    ],
)
def test_the_profile_with_most_topics_and_least_missing_is_first(
    topics, profile, namespace, matched, missing
):
    best = fits(PROFILES, seen(**topics))[0]
    assert (best.profile, best.namespace, set(best.matched)) == (profile, namespace, matched)
    assert [one.name for one in best.missing] == missing


def test_a_topic_of_another_type_is_reported_and_counts_against_a_profile():
    right, wrong = (
        fits({"boat": PROFILES["boat"]}, seen(gps__fix=FIX, gps__height=msgtype))[0]
        for msgtype in (HEIGHT, POSE)
    )
    assert wrong.wrong_type["height"].msgtype == POSE
    assert right.score == 4
    assert wrong.score == 2 - 1


def test_the_newest_version_of_a_topic_is_taken():
    topics = seen(fmu__fix_v2=FIX, fmu__fix_v10=FIX, gps__height=HEIGHT)
    best = next(fit for fit in fits(PROFILES, topics) if fit.profile == "plane")
    assert best.matched["fix"] == "/fmu/fix_v10"


def test_what_was_published_or_is_a_simulations_truth_is_no_input():
    topics = seen(robots__aqua_1__gps__fix=FIX, truth__aqua_1__gps__fix=FIX, x__robots__a__fix=FIX)
    assert candidates("fix", topics) == []
    assert fits(PROFILES, topics)[0].matched == {}


def test_topics_that_could_serve_come_with_each_type_that_reads_them():
    topics = seen(p=POSE, f=FIX, c="sensor_msgs/msg/CameraInfo")
    assert [(t.name, kind) for t, kind in candidates("height", topics)] == [("/p", "pose")]
    assert [kind for _, kind in candidates("fix", topics)] == ["navsatfix", "anafi_fix"]
    assert [(t.name, kind) for t, kind in candidates("camera_info", topics)] == [("/c", "")]
    assert candidates("water_level", topics) == []


def test_other_drones_have_a_position_and_lack_nothing():
    topics = seen(
        d1__gps__fix=FIX, d2__gps__fix=FIX, d2__gps__height=HEIGHT, d3__gps__height=HEIGHT
    )
    found = next(fit for fit in fits(PROFILES, topics) if fit.namespace == "d2")
    others = other_drones(PROFILES, topics, found)
    assert [(fit.profile, fit.namespace) for fit in others] == [("boat", "d1")]
