# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of several drones are one, in the order of time, each below its drone's name."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes.fleet_bag import FleetBag

STRING = "std_msgs/msg/String"


def bag(path, *messages):
    with BagWriter(path) as out:
        for topic, log_ns in messages:
            out.write(topic, STRING, log_ns, {"data": f"{path.name} {log_ns}"})
    return path


def test_messages_of_all_drones_come_in_order_below_their_names(tmp_path):
    first = bag(tmp_path / "a", ("/fix", 10), ("/fix", 30), ("/tf", 20))
    second = bag(tmp_path / "b", ("/fix", 20), ("/b/gimbal", 40))
    with open_bag([first]) as a, open_bag([second]) as b:
        both = FleetBag({"a": a, "b": b})
        assert {*both.topics} == {"/a/fix", "/b/fix", "/b/gimbal"}
        assert both.topics["/b/fix"].name == "/b/fix"
        assert (both.start_ns, both.end_ns) == (10, max(a.end_ns, b.end_ns))
        found = [(one.topic, one.log_ns, one.message().data) for one in both.messages()]
        assert found == [
            ("/a/fix", 10, "a 10"), ("/b/fix", 20, "b 20"), ("/a/fix", 30, "a 30"),
            ("/b/gimbal", 40, "b 40"),
        ]  # fmt: skip
        assert [one.log_ns for one in both.messages({"/b/fix"})] == [20]


def test_recordings_of_two_days_are_refused(tmp_path):
    first, second = bag(tmp_path / "a", ("/fix", 10)), bag(tmp_path / "b", ("/fix", 10**15))
    with (
        open_bag([first]) as a,
        open_bag([second]) as b,
        pytest.raises(InputError, match="no moment in common"),
    ):
        FleetBag({"a": a, "b": b})
