# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every line of /diagnostics has its place in config/diagnostics.yaml, for the aggregator."""

from __future__ import annotations

import pytest
import yaml

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from diagnostic_msgs.msg import DiagnosticArray

from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode


def analyzers(node):
    """Yield the path and the wanted parts of names of each generic analyzer."""
    for name, one in node.items():
        if isinstance(one, dict) and "contains" in one:
            yield one["path"], one["contains"]
        elif isinstance(one, dict):
            yield from analyzers(one)
        assert name != "contains"


def test_each_line_of_the_estimator_has_one_place(ros, repository):
    text = (repository / "config/diagnostics.yaml").read_text()
    places = list(analyzers({"all": yaml.safe_load(text)["/**"]["ros__parameters"]}))
    node, got = ros.add(EstimatorNode()), []
    ros.node().create_subscription(DiagnosticArray, "/diagnostics", got.append, qos.diagnostics())
    ros.spin_until(lambda: got)
    names = [status.name for status in got[-1].status]
    assert len(names) > 5
    for name in [*names, "drone1/estimator: robot aqua_1"]:
        found = [path for path, parts in places if any(part in name for part in parts)]
        assert len(found) == 1, f"{name}: {found}"
    assert node.get_name() == "estimator"
