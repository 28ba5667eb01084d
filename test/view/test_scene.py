# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Paths, robots that are lost, and whose box is whose."""

from __future__ import annotations

import math
import runpy
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.view.scene import (
    MARGIN_PX,
    MOST_POINTS,
    SHOWN_LOST_S,
    STEP_S,
    Box,
    Paths,
    boxes_of,
    named_boxes,
)

MADE = runpy.run_path(str(Path(__file__).with_name("overviews.py")))
BEGIN, SECOND, overview, robot = (MADE[name] for name in ("BEGIN", "SECOND", "overview", "robot"))


def paths_of(*overviews):
    paths = Paths(BEGIN)
    for one in overviews:
        paths.add(one)
    return paths


def test_a_path_has_points_at_least_a_step_apart_measured_or_predicted():
    tenths = [0.1 * i for i in range(21)]
    states = ["confirmed" if t < 1.0 else "coasting" for t in tenths]
    paths = paths_of(
        *(overview(t, robot("a", t, state)) for t, state in zip(tenths, states, strict=True))
    )
    points = paths.robots()["a"]
    assert all(later[0] - one[0] >= STEP_S for one, later in pairwise(points))
    assert [point[3] for point in points] == [1, 1, 0, 0, 0]
    assert points[1][1] == pytest.approx(13.0 + 1e-6 * points[1][0], abs=1e-9)
    assert len(paths.drone()) == 5


def test_a_very_long_path_is_thinned_and_goes_on_to_its_end():
    count = 3 * MOST_POINTS
    paths = paths_of(*(overview(t, robot("a", t)) for t in range(count)))
    points = paths.robots()["a"]
    assert len(points) <= MOST_POINTS
    assert points[0][0] == 0.0
    assert points[-1][0] >= count - 5


def test_each_drone_of_a_fleet_has_a_path_of_its_own():
    def drones(t):
        return [{"name": name, "place": [13.0 + k, 0.1 * t]} for k, name in enumerate("ab")]

    paths = paths_of(*(overview(t, drone=None, drones=drones(t)) for t in (0.0, 1.0)))
    assert paths.drone() == []
    assert paths.drones() == {"a": [[0.0, 13.0, 0.0, 1], [1.0, 13.0, 0.1, 1]],
                              "b": [[0.0, 14.0, 0.0, 1], [1.0, 14.0, 0.1, 1]]}  # fmt: skip


def test_a_robot_that_is_no_longer_published_is_lost_where_it_was_measured_last():
    paths = paths_of(
        overview(0.0, robot("a", 0.0), robot("b", 0.0)),
        overview(1.0, robot("a", 1.0), robot("b", 1.0)),
        overview(2.0, robot("a", 2.0), robot("b", 2.0, "coasting")),
        last := overview(3.0, robot("a", 3.0)),
    )
    (lost,) = paths.lost(last, last["stamp_ns"])
    assert (lost["id"], lost["state"], lost["covariance_m2"]) == ("b", "lost", None)
    assert lost["place"] == [pytest.approx(13.0 + 1e-6), -59.0]
    assert lost["last_seen_ns"] == BEGIN + SECOND


def test_a_robot_is_not_lost_before_it_was_known_nor_for_ever():
    first = overview(0.0, robot("a", 0.0))
    paths = paths_of(first, overview(5.0, robot("b", 5.0)))
    assert paths.lost(first, BEGIN) == []
    much_later = BEGIN + round((SHOWN_LOST_S + 6.0) * SECOND)
    assert paths.lost(overview(SHOWN_LOST_S + 6.0), much_later) == []


def box(x, y, width=20.0):
    return Box(x, y, width, 10.0, 0.9, "aqua")


def test_each_robot_names_the_nearest_box_once():
    robots = [robot("a", 0.0, pixel=(101.0, 50.0)), robot("b", 0.0, pixel=(108.0, 50.0))]
    found = named_boxes([box(109.0, 50.0), box(100.0, 50.0), box(300.0, 50.0)], robots)
    assert [one["name"] for one in found] == ["b", "a", None]


@pytest.mark.parametrize(
    ("pixel", "state", "name"),
    [
        ((110.0 + MARGIN_PX - 0.1, 50.0), "confirmed", "a"),
        ((110.0 + MARGIN_PX + 0.1, 50.0), "confirmed", None),
        ((100.0, 55.0 + MARGIN_PX + 0.1), "confirmed", None),
        ((100.0, 50.0), "coasting", None),
        (None, "confirmed", None),
    ],
)
def test_a_box_far_from_all_measured_robots_has_no_name(pixel, state, name):
    (found,) = named_boxes([box(100.0, 50.0)], [robot("a", 0.0, state, pixel)])
    assert found["name"] == name


def detection(x=5.0, results=1):
    hypothesis = SimpleNamespace(class_id="aqua", score=0.8)
    centre = SimpleNamespace(position=SimpleNamespace(x=x, y=6.0))
    return SimpleNamespace(
        results=[SimpleNamespace(hypothesis=hypothesis)] * results,
        bbox=SimpleNamespace(center=centre, size_x=3.0, size_y=4.0),
    )


def test_boxes_are_read_from_messages_without_what_is_none():
    message = SimpleNamespace(detections=[detection(), detection(math.nan), detection(results=0)])
    assert boxes_of(message) == [Box(5.0, 6.0, 3.0, 4.0, 0.8, "aqua")]
