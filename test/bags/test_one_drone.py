# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of two drones are not read as parts of one."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.bags.one_drone import refuse_two_drones
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import SENSOR, BagWriter
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.values.errors import InputError

SECOND_NS = 1_000_000_000


def recorded(path, values, begin_s=0.0, topic="fix"):
    """Write ten values a second."""
    with BagWriter(path) as bag:
        for k, value in enumerate(values):
            at_ns = round((begin_s + 0.1 * k) * SECOND_NS)
            bag.write(topic, "std_msgs/msg/Float64", at_ns, {"data": float(value)}, SENSOR)
    return path


def check(*paths):
    with open_bag(paths) as bag:
        refuse_two_drones(bag, ["/fix"])


def test_two_drones_at_one_time_are_refused(tmp_path):
    first = recorded(tmp_path / "a", range(50))
    second = recorded(tmp_path / "b", range(100, 150), begin_s=0.03)
    with pytest.raises(InputError, match=r"a and .*b have different messages on /fix .*--drone"):
        check(first, second)


@pytest.mark.parametrize(
    ("values", "begin_s", "topic"),
    [
        (range(20, 70), 2.0, "fix"),  # a second recorder, which began later
        (range(25, 75), 0.5, "fix"),  # likewise, with another clock
        (range(100, 150), 5.0, "fix"),  # the next part of a recording
        (range(100, 150), 4.5, "fix"),  # of which some messages came late
        (range(100, 150), 0.0, "height"),  # what another recorder kept
    ],
)
def test_recordings_of_one_drone_belong_together(tmp_path, values, begin_s, topic):
    first = recorded(tmp_path / "a", range(50))
    check(first, recorded(tmp_path / "b", values, begin_s, topic))


def test_a_replay_says_how_drones_are_given(tmp_path, capsys):
    """Telemetry of both, mixed, gave positions that were off by metres."""
    plan = ["--drones", "2", "--no-images", "--duration", "3"]
    assert main(["simulate", "-o", str(tmp_path / "two"), *plan]) == 0
    bags = [str(tmp_path / "two" / name) for name in "ab"]
    assert main(["replay", *bags, "-o", str(tmp_path / "mixed")]) == 2
    assert "they are of two drones" in capsys.readouterr().err
    assert not (tmp_path / "mixed").exists()


def test_so_does_play(tmp_path, capsys):
    pytest.importorskip("rclpy")
    fix = {"latitude": 13.0, "longitude": -59.0, "altitude": 0.0}
    for name, off in (("a", 0.0), ("b", 0.5)):
        with BagWriter(tmp_path / name) as bag:
            for k in range(50):
                at_ns = (k + 1) * SECOND_NS // 10
                values = {**fix, "altitude": off + k}
                bag.write("fix", "sensor_msgs/msg/NavSatFix", at_ns, values, SENSOR)
    assert main(["play", str(tmp_path / "a"), str(tmp_path / "b")]) == 2
    assert "they are of two drones" in capsys.readouterr().err
