# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Topics of a bag as profiles are compared with: types, rates, and what cannot be read."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.survey import survey
from aerial_gnss_ros.bags.writer import BagWriter


def test_rates_are_of_the_whole_bag(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        for i in range(21):
            bag.write("a/height", "std_msgs/msg/Float64", i * 100_000_000, {"data": 1.0})
        bag.write("once", "std_msgs/msg/String", 1, {"data": "x"})
    with open_bag([tmp_path / "bag"]) as bag:
        found = {one.name: one for one in survey(bag)}
    height, once = found["/a/height"], found["/once"]
    assert (height.msgtype, height.count, height.trouble) == ("std_msgs/msg/Float64", 21, "")
    assert height.rate_hz == pytest.approx(10.0)
    assert once.rate_hz == 0.0


def test_a_bag_of_one_message_has_no_rate(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.write("once", "std_msgs/msg/String", 1, {"data": "x"})
    with open_bag([tmp_path / "bag"]) as bag:
        assert [one.rate_hz for one in survey(bag)] == [0.0]
