# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Markers are made while somebody looks at them."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("visualization_msgs")

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.results import markers
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.nodes.on_demand import OnDemandTopic
from aerial_gnss_ros.nodes.ros_messages import message


def result(stamp_ns):
    return FrameResult(stamp_ns, "camera", (), (), MapDatum(0.2, -1.0, 0.0))


def test_nothing_is_made_without_a_subscriber_and_the_newest_for_one_that_joins():
    sent, viewers = [], [0]
    publisher = SimpleNamespace(
        publish=lambda msg: sent.append(msg.markers[0].header.stamp.sec),
        get_subscription_count=lambda: viewers[0],
    )

    def make(one):
        made = markers(one, Frames())
        return message(made.msgtype, made.fields)

    picture = OnDemandTopic(publisher, make)
    picture.look()
    for second in (1, 2):
        picture.show(result(second * 10**9))
    assert sent == []
    viewers[0] = 1
    picture.look()
    picture.look()  # once
    assert sent == [2]
    picture.show(result(3 * 10**9))
    assert sent == [2, 3]
