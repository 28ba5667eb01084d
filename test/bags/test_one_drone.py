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


def test_replay_and_play_say_how_drones_are_given(tmp_path, capsys):
    """Telemetry of both, mixed, gave positions that were off by metres."""
    plan = ["--drones", "2", "--no-images", "--duration", "3"]
    assert main(["simulate", "-o", str(tmp_path / "two"), *plan]) == 0
    bags = [str(tmp_path / "two" / name) for name in "ab"]
    assert main(["replay", *bags, "-o", str(tmp_path / "mixed")]) == 2
    assert "they are of two drones" in capsys.readouterr().err
    assert main(["play", *bags]) == 2
    assert "they are of two drones" in capsys.readouterr().err
    assert not (tmp_path / "mixed").exists()
