# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with one drone of a fleet is said, and the others go on."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
from aerial_gnss_ros.adapters.fleet_messages import drone_parameters
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.diagnostics import WARN
from aerial_gnss_ros.nodes.fleet_node import FleetNode
from aerial_gnss_ros.nodes.ros_messages import message
from aerial_gnss_ros.nodes.supervised import Given


def said(node):
    return {status.name: status for status in node.statuses()}


def test_what_is_wrong_with_a_drone_is_said_and_the_other_goes_on(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("fleet: {ros__parameters: {drones: [a, b]}}", encoding="utf-8")
    node = ros.add(FleetNode(Given(files=[path])))
    warned = []
    node.warn_seldom = warned.append
    assert said(node)["positions"].message == "no drone has told its parameters yet"
    parameters = {"version": 1, "drone": "a", "parameters": {}, "datum": None}
    string = "std_msgs/msg/String"
    node._describe("a", message(string, {"data": json.dumps(parameters)}))
    node._describe("b", message(string, {"data": json.dumps(parameters)}))
    assert "both call themselves drone a" in warned[-1]
    node._take("b", message(string, {"data": "{}"}))
    assert warned[-1].startswith("b: a sighting is of version")
    assert drone_parameters(json.dumps(parameters)).drone == "a"
    assert said(node)["drone a"].message == "no image yet"
    link = node._shore.links["a"]
    link.delay_s = 4.0
    assert said(node)["drone a"].level == WARN
    assert "4.0 s late" in said(node)["drone a"].message


@pytest.mark.usefixtures("ros")
def test_a_fleet_without_drones_is_refused():
    with pytest.raises(ConfigError, match="drones is empty"):
        FleetNode()
