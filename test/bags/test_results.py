# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables and maps: formats, order and names that need quoting."""

from __future__ import annotations

import csv
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.interfaces import QosDurability

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.results import ResultFolder, position_row, rejection_row
from aerial_gnss_ros.bags.tables import read_positions, read_rejections
from aerial_gnss_ros.core.config.processing import UpdatesConfig
from aerial_gnss_ros.core.estimation.position_updates import PositionUpdates
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.core.values.rejection import Reason, Rejection

sys.path.insert(0, str(Path(__file__).parent))

from estimates import ESTIMATE


def test_a_row_of_positions():
    assert ",".join(position_row(ESTIMATE)) == (
        "1735689600123456789,aqua_1,aqua,13.1939387033,-59.6415065636,nan,4,1e-07,0.333333333,"
        "0.250000,-1.000000,coasting"
    )


def test_a_row_of_rejections():
    row = rejection_row(Rejection(5, Reason.ABOVE_HORIZON, 1.25, -3.0))
    assert row == ["5", "above_horizon", "1.250", "-3.000"]


def pose(stamp_ns):
    return CameraPose(stamp_ns, 0.25, -1.0, 20.0, math.nan, np.eye(3))


def test_samples_for_other_filters_are_in_the_bag_and_not_latched(tmp_path):
    seen = replace(ESTIMATE, state=State.CONFIRMED)
    updates = PositionUpdates(UpdatesConfig(settle_s=0.0), 300.0)
    with ResultFolder(tmp_path, "drone1", updates=updates) as folder:
        for late_ns in (0, 10):  # the second one is not due
            later = replace(seen, stamp_ns=seen.stamp_ns + late_ns)
            folder.add(FrameResult(later.stamp_ns, "camera", (later,), (), None, pose(9)))
    with open_bag(tmp_path / "bag") as bag:
        topic = bag.topics["/drone1/robots/aqua_1/position_update"]
        assert topic.count == 1
        assert topic.qos[0].durability is QosDurability.VOLATILE


def test_a_folder_is_in_order_and_its_tables_read_back(tmp_path):
    later = replace(ESTIMATE, stamp_ns=ESTIMATE.stamp_ns + 10, class_id='robot, "blue"')
    second = replace(ESTIMATE, robot_id="aqua_2")
    refused = Rejection(3, Reason.GATED, 1.0, 2.0)
    with ResultFolder(tmp_path) as folder:
        # A clock that went backward: the later stamps come first.
        folder.add(FrameResult(later.stamp_ns, "camera", (later,), (refused,), None, pose(9)))
        both = (ESTIMATE, second)
        folder.add(FrameResult(ESTIMATE.stamp_ns, "camera", both, (), None, pose(4)))
    with (tmp_path / "positions.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [(row["robot_id"], row["class_id"]) for row in table] == [
        ("aqua_1", "aqua"), ("aqua_2", "aqua"), ("aqua_1", 'robot, "blue"'),
    ]  # fmt: skip
    tracks = read_positions(tmp_path / "positions.csv")
    assert {name: len(track) for name, track in tracks.items()} == {"aqua_1": 2, "aqua_2": 1}
    assert tracks["aqua_1"].latitude[0] == pytest.approx(ESTIMATE.latitude, abs=1e-12)
    assert read_rejections(tmp_path / "rejected.csv") == {"gated": 1}
    assert folder.drone.stamps_ns.tolist() == [4, 9]


def test_a_failure_writes_no_tables(tmp_path):
    def fail():
        with ResultFolder(tmp_path):
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_parts_of_the_covariance_are_in_the_bag_where_the_estimator_gives_them(tmp_path):
    seen = replace(ESTIMATE, state=State.CONFIRMED, white=0.01 * np.eye(2))
    with ResultFolder(tmp_path) as folder:
        folder.add(FrameResult(seen.stamp_ns, "camera", (seen,), (), None, pose(9)))
    with open_bag(tmp_path / "bag") as bag:
        for name in ("covariance_shared", "covariance_white"):
            assert bag.topics[f"/robots/aqua_1/{name}"].qos[0].durability is QosDurability.VOLATILE
