# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""True positions of a table or a bag, at the stamps of the images that show them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.evaluation.truth import read_truth, read_truth_csv

SECOND = 1_000_000_000
FIX, HEAD = "sensor_msgs/msg/NavSatFix", "stamp_ns,robot_id,latitude_deg,longitude_deg"


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_is_moved_by_the_latency_and_ordered(tmp_path, separator):
    path = tmp_path / "truth.csv"
    rows = [f"{HEAD},note", "20,b,13.2,-59.6,x", "30,a,45,-90,x", "10,a,44,-91,x"]
    path.write_text("\n".join(row.replace(",", separator) for row in rows))
    truth = read_truth_csv(path, 0.5)
    assert list(truth.robots) == ["a", "b"]
    assert truth.latency_s == 0.5
    assert truth.robots["a"].stamps_ns.tolist() == [500_000_010, 500_000_030]
    assert np.degrees(truth.robots["a"].latitude) == pytest.approx([44.0, 45.0])
    assert np.degrees(truth.robots["a"].longitude) == pytest.approx([-91.0, -90.0])


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1.5,a,1,2", "line 3: stamp_ns must be a whole number of nanoseconds, not '1.5'"),
        (f"{1 << 63},a,1,2", "line 3: stamp_ns must be a whole number"),
        ("1,a,north,2", "line 3: latitude_deg must be a number of degrees, not 'north'"),
        ("1,a,90.1,2", "line 3: 90.1, 2.0 is not"),
        ("1,a,1,nan", "line 3: 1.0, nan is not"),
    ],
)
def test_a_row_that_is_no_position_is_named(tmp_path, row, words):
    path = tmp_path / "truth.csv"
    path.write_text(f"{HEAD}\n{(1 << 63) - 1},a,1,2\n{row}\n")
    with pytest.raises(InputError, match=words):
        read_truth_csv(path)


def test_missing_tables_and_columns_are_named(tmp_path):
    with pytest.raises(InputError, match="does not exist; give a bag, or a CSV"):
        read_truth_csv(tmp_path / "truth.csv")
    (tmp_path / "truth.csv").write_text("stamp_ns,name\n1,a\n")
    with pytest.raises(InputError, match="lacks the columns robot_id, latitude_deg, longitude_deg"):
        read_truth_csv(tmp_path / "truth.csv")


def fix(t, latitude):
    header = header_fields(round(t * SECOND), "earth")
    return {"header": header, "latitude": latitude, "longitude": 5.0}


def bag(tmp_path, *, scenario=None, images=(), drone="d1/truth/fix"):
    """Write a bag in which a robot is known once a second for ten seconds."""
    with BagWriter(tmp_path / "bag") as writer:
        for t in range(10):
            writer.write("d1/truth/robots/a/fix", FIX, t * SECOND, fix(t, 1.0 + 0.1 * t))
            writer.write("d1/truth/robots/b/fix", FIX, t * SECOND, fix(t, math.nan))
            writer.write(drone, FIX, t * SECOND, fix(t, 2.0))
        for t in images:
            writer.write(
                "d1/truth/detections", "vision_msgs/msg/Detection2DArray", round(t * SECOND),
                {"header": header_fields(round(t * SECOND), "camera"), "detections": [{"id": "a"}]},
            )  # fmt: skip
        if scenario is not None:
            writer.write("d1/truth/scenario", "std_msgs/msg/String", 1, {"data": scenario})
    return tmp_path / "bag"


@pytest.mark.parametrize(
    ("scenario", "asked", "late_s"),
    [
        (None, None, 0.0),
        (json.dumps({"camera": {"latency_s": 0.5}}), None, 0.5),
        (json.dumps({"camera": {"latency_s": 0.5}}), 0.2, 0.2),
        ("{", None, 0.0),
        ('{"camera": 3}', None, 0.0),
    ],
)
def test_truth_of_a_bag_is_moved_by_the_latency_that_its_scenario_states(
    tmp_path, scenario, asked, late_s
):
    with open_bag([bag(tmp_path, scenario=scenario)]) as one:
        truth = read_truth(one, asked)
    assert list(truth.robots) == ["a"]  # nothing is known of b
    assert truth.latency_s == late_s
    assert truth.robots["a"].stamps_ns[0] == round(late_s * SECOND)
    assert np.degrees(truth.robots["a"].latitude[-1]) == pytest.approx(1.9)
    assert np.degrees(truth.drone.latitude[0]) == pytest.approx(2.0)


def test_positions_may_be_read_at_intervals(tmp_path):
    """One a second is recorded; of each topic the next counts that comes 1.5 s later."""
    with open_bag([bag(tmp_path)]) as one:
        whole, few = read_truth(one), read_truth(one, interval_s=1.5)
    stamps = whole.robots["a"].stamps_ns
    assert few.robots["a"].stamps_ns.tolist() == stamps[::2].tolist()
    assert few.in_view.keys() == whole.in_view.keys()


def test_only_truth_around_the_images_counts(tmp_path):
    with open_bag([bag(tmp_path, images=(3.5, 5.5))]) as one:
        truth = read_truth(one)
    assert (truth.robots["a"].stamps_ns // SECOND).tolist() == [3, 4, 5, 6]
    assert truth.in_view["a"].tolist() == [3_500_000_000, 5_500_000_000]


def test_the_drones_measured_path_stands_for_its_true_one(tmp_path):
    with open_bag([bag(tmp_path, drone="d1/fix")]) as one:
        assert np.degrees(read_truth(one).drone.latitude[0]) == pytest.approx(2.0)
