# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drone with a name publishes its sightings to whoever listens, and again what was lost."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
from rclpy.parameter import Parameter

from aerial_gnss_ros.adapters.fleet_messages import (
    PARAMETERS,
    REQUEST,
    Request,
    drone_parameters,
    request_text,
)
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS, sent_sighting
from aerial_gnss_ros.nodes import qos, sightings
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode
from aerial_gnss_ros.nodes.ros_messages import message, message_class
from aerial_gnss_ros.nodes.supervised import Given


@pytest.fixture
def named(ros, tmp_path):
    """Return an estimator of a drone with a name."""
    path = tmp_path / "p.yaml"
    path.write_text(
        "estimator: {ros__parameters: {sightings: {drone: north}, noise: {set: rtk}}}",
        encoding="utf-8",
    )
    return ros.add(EstimatorNode(Given(files=[path])))


def heard(ros, topic, profile):
    got = []
    kind = message_class(topic[1])
    ros.node("fleet").create_subscription(kind, topic[0], lambda m: got.append(m.data), profile)
    return got


def test_sightings_are_made_for_whoever_listens_and_sent_again(ros, named, hovering, monkeypatch):
    made = []
    text = sightings.sighting_text
    monkeypatch.setattr(sightings, "sighting_text", lambda s: made.append(s) or text(s))
    drone = hovering()
    drone.fly()
    ros.spin_until(lambda: named._images == 6)
    assert not made
    got = heard(ros, SIGHTINGS, qos.sightings())
    ros.connect(*(one for one in named.publishers if one.topic_name == "/sightings"))
    last_ns = drone.fly(3)
    ros.spin_until(lambda: len(got) == 3)
    sent = [sent_sighting(one) for one in got]
    first = sent[0].sequence  # an image before the origin of map is known has no sighting
    assert first >= 4
    assert [one.sequence for one in sent] == [first, first + 1, first + 2]
    assert {(one.drone, one.oldest) for one in sent} == {("north", 0)}
    assert sent[-1].sighting.stamp_ns == last_ns
    assert sent[-1].sighting.labels == ("aqua_1",)
    assert sent[-1].sighting.pixels.tolist() == [[320.0, 180.0]]

    asking = ros.node("asking").create_publisher(
        message_class(REQUEST[1]), REQUEST[0], qos.sent_once()
    )
    ros.spin_until(asking.get_subscription_count)
    for name in ("south", "north"):  # the first is not meant
        wanted = Request(name, sent[0].session, ((0, 1), (4, 99)))
        asking.publish(message(REQUEST[1], {"data": request_text(wanted)}))
    asking.publish(message(REQUEST[1], {"data": "{}"}))
    ros.spin_until(lambda: len(got) == first + 4)
    ros.spin(0.3)
    again = [sent_sighting(one) for one in got[3:]]
    assert [one.sequence for one in again] == [0, 1, *range(4, first + 3)]


def test_the_parameters_in_use_are_told(ros, named, hovering):
    hovering().fly()
    got = heard(ros, PARAMETERS, qos.latched())
    ros.spin_until(lambda: got and drone_parameters(got[-1]).datum is not None)
    told = drone_parameters(got[-1])
    assert told.drone == "north"
    assert told.config.noise.set == "rtk"
    assert told.datum.latitude == pytest.approx(0.2268928, abs=1e-6)
    named.set_parameters([Parameter("camera.latency_s", value=0.125)])
    ros.spin_until(lambda: drone_parameters(got[-1]).config.camera.latency_s == 0.125)


def test_without_a_name_nothing_is_said(ros):
    node = ros.add(EstimatorNode())
    ours = node.get_publisher_names_and_types_by_node("estimator", "/")
    assert not [name for name, _ in ours if "sightings" in name]
    assert node._sightings is None
