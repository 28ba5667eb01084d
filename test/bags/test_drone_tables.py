# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is written of each drone is read again, and a table of another kind is refused."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.bags.drone_tables import DroneTables, read_drones
from aerial_gnss_ros.core.fleet.agreement import DroneReport
from aerial_gnss_ros.core.values.errors import InputError

STEP_NS = 100_000_000


def fed(count=11):
    """Return tables of two drones of which b sees its second robot only in the first half."""
    tables, pair = DroneTables(), np.array([0.5, -0.25])
    for k in range(count):
        for name in "ab":
            report = DroneReport(name, k * STEP_NS, 1.0, 1, pair, pair, False, "")
            names = {"aqua_1": "aqua_1"} | ({"aqua_2": "aqua_3"} if name == "b" else {})
            labels = ("aqua_1", "") if name == "a" or k > 5 else ("aqua_2", "aqua_1")
            pose = SimpleNamespace(latitude=0.23 + k * 1e-8, longitude=-1.04)
            tables.add(
                SimpleNamespace(report=report, names=names),
                SimpleNamespace(pose=pose, labels=labels),
            )
    return tables


def test_paths_and_what_was_seen_are_read_again(tmp_path):
    fed().write(tmp_path)
    drones = read_drones(tmp_path / "drones.csv")
    assert [*drones] == ["a", "b"]
    path = drones["a"].path
    assert path.stamps_ns.tolist() == [0, 5 * STEP_NS, 10 * STEP_NS]  # each half second
    assert np.allclose(path.latitude, 0.23 + np.array([0, 5, 10]) * 1e-8, rtol=0.0, atol=2e-11)
    assert np.allclose(path.longitude, -1.04, rtol=0.0, atol=2e-11)
    assert {name: of.tolist() for name, of in drones["a"].seen.items()} == {
        "aqua_1": [0, 5 * STEP_NS, 10 * STEP_NS]
    }
    # By the fleet's name, not the drone's own.
    assert drones["b"].seen["aqua_3"].tolist() == [0, 5 * STEP_NS]
    named = (tmp_path / "names.csv").read_text().splitlines()
    assert f"aqua_3,b,aqua_2,0,{10 * STEP_NS},11" in named


def test_a_result_of_one_drone_or_of_an_older_release_has_no_paths(tmp_path):
    assert read_drones(tmp_path / "drones.csv") == {}
    (tmp_path / "drones.csv").write_text("stamp_ns,drone,agreement\n0,a,1.0\n")
    assert read_drones(tmp_path / "drones.csv") == {}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("drone,", "", "lacks the columns drone"),
        (f"{math.degrees(-1.04):.9f}", "x", "invalid row"),
        (f"{math.degrees(0.23):.9f}", "91", "a drone is not on Earth"),
        (f"{math.degrees(0.23):.9f}", "nan", "a drone is not on Earth"),
    ],
)
def test_another_table_is_refused(tmp_path, old, new, words):
    fed().write(tmp_path)
    path = tmp_path / "drones.csv"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=words):
        read_drones(path)
