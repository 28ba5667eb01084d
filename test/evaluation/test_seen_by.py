# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bars are as long as a drone saw a robot, and end where it no longer did."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.bags.drone_tables import DroneFlight
from aerial_gnss_ros.bags.tables import Track
from aerial_gnss_ros.evaluation.seen_by import seen_by_png, spans

HALF_NS = 500_000_000


def test_runs_end_where_a_robot_is_not_seen():
    stamps = np.array([4, 5, 6, 9, 10]) * HALF_NS
    assert spans(stamps, 2 * HALF_NS) == [(1.0, 1.5), (3.5, 1.0)]
    assert spans(stamps[:0], 0) == []


def test_what_no_drone_saw_has_no_figure():
    stamps = np.arange(4, dtype=np.int64) * HALF_NS
    path = Track(stamps, np.full(4, 0.23), np.full(4, -1.04))
    assert seen_by_png({"a": DroneFlight(path, {})}, {}) is None
    assert seen_by_png({}, {}) is None
    drones = {"a": DroneFlight(path, {"aqua_1": stamps}), "b": DroneFlight(path, {})}
    found = seen_by_png(drones, {"aqua_1": "#0072B2"})
    assert found is not None
    assert found != seen_by_png(drones | {"b": drones["a"]}, {"aqua_1": "#0072B2"})
