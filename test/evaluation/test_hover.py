# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hovers over robots, and the truth that they give."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum, State
from aerial_gnss_ros.evaluation.hover import (
    Hover,
    away_from,
    during,
    find_hovers,
    hover_truth,
    seen_from_above,
)

SECOND = 1_000_000_000
MAP = LocalMap(MapDatum(0.2, -1.0, 0.0))
HEIGHT_M = 10.0


def image(t, east, state=State.CONFIRMED, name="aqua_1"):
    """Return what an image 10 m above the origin gives of a robot so far east."""
    latitude, longitude = MAP.places(np.array([[east, 0.0]]))
    robot = SimpleNamespace(
        robot_id=name, state=state, latitude=float(latitude[0]), longitude=float(longitude[0])
    )
    stamp_ns = round(t * SECOND)
    pose = SimpleNamespace(
        latitude=0.2, longitude=-1.0, height=HEIGHT_M, stamp_ns=stamp_ns - SECOND // 10
    )
    return SimpleNamespace(stamp_ns=stamp_ns, pose=pose, estimates=(robot,))


def stay(begin, end, east=0.0, **more):
    return [image(t, east, **more) for t in np.arange(begin, end + 0.01, 0.5)]


WITHIN = math.atan2(0.5, HEIGHT_M)


def test_a_stay_is_a_second_at_least_and_ends_with_a_gap_of_two():
    flight = [
        *stay(0.0, 3.0), *stay(4.5, 6.0), *stay(8.5, 9.0), *stay(20.0, 21.0),
        *stay(30.0, 35.0, 0.6),
    ]  # fmt: skip
    found = find_hovers(flight, WITHIN)
    assert [(one.start_ns / SECOND, one.end_ns / SECOND) for one in found] == [(0.0, 6.0), (20, 21)]
    assert found[0].count == 11


def test_its_place_is_the_mean_and_its_spread_that_of_the_single_positions():
    flight = [image(0.5 * i, 0.4 * (-1) ** i) for i in range(8)]
    (one,) = find_hovers(flight, WITHIN)
    place = MAP.positions([one.latitude], [one.longitude])[0]
    assert place == pytest.approx([0.0, 0.0], abs=1e-6)
    assert one.spread_m == pytest.approx(0.4, abs=1e-6)


@pytest.mark.parametrize(
    ("flight", "words"),
    [
        ([], "no truth from hovers"),
        (stay(0.0, 5.0, state=State.COASTING), "no truth from hovers"),
        (stay(0.0, 5.0, 10.0), "45.0 deg"),
    ],
)
def test_without_a_hover_there_is_no_truth(flight, words):
    with pytest.raises(InputError, match=words):
        find_hovers(flight, WITHIN)


def hover(start_s, end_s, latitude, robot="aqua_1"):
    return Hover(robot, start_s * SECOND, end_s * SECOND, latitude, -1.0, 0.1, 9)


TWICE = [hover(10, 12, 0.20), hover(20, 22, 0.21)]
STAMPS = np.arange(0, 40, 2) * SECOND


def test_a_robots_place_is_interpolated_between_hovers_which_do_not_count():
    (track,) = hover_truth(TWICE, STAMPS, None).values()
    assert track.stamps_ns.tolist() == [s for s in STAMPS if s // SECOND not in (10, 12, 20, 22)]
    by_time = dict(zip((track.stamps_ns // SECOND).tolist(), track.latitude, strict=True))
    assert (by_time[0], by_time[38]) == (0.20, 0.21)
    assert by_time[16] == pytest.approx(0.205)
    assert by_time[14] == pytest.approx(0.2025)


def test_a_place_holds_for_so_long_before_and_after_a_hover():
    (track,) = hover_truth(TWICE, STAMPS, 2.0).values()
    assert (track.stamps_ns // SECOND).tolist() == [8, 14, 18, 24]


def test_positions_during_a_hover_over_any_robot_are_left_out():
    stamps = np.array([9, 10, 12, 13]) * SECOND
    assert during(TWICE, stamps).tolist() == [False, True, True, False]
    assert not during([], stamps).any()
    track = EstimatedTrack(
        stamps, np.arange(4.0), np.arange(4.0), np.zeros((4, 2, 2)), np.ones(4, bool)
    )
    kept = away_from(TWICE, {"a": track})["a"]
    assert kept.latitude.tolist() == [0.0, 3.0]
    inside = EstimatedTrack(
        stamps[1:3], np.arange(2.0), np.arange(2.0), np.zeros((2, 2, 2)), np.ones(2, bool)
    )
    assert list(away_from(TWICE, {"a": track, "b": inside})) == ["a"]
    with pytest.raises(InputError, match="nothing is left to compare"):
        away_from(TWICE, {"b": inside})


def test_a_robot_below_another_drone_is_known_at_the_times_of_its_scenes_only():
    images = [*stay(0, 2), *stay(3, 5, east=0.9), *stay(6, 6.2, name="other")]
    found = seen_from_above(images, WITHIN, 0.3)
    assert [*found] == ["aqua_1"]
    seconds = found["aqua_1"].stamps_ns / SECOND
    np.testing.assert_allclose(seconds, np.array([0.0, 0.5, 1.0, 1.5, 2.0]) + 0.2)
    with pytest.raises(InputError, match=r"from the vertical is 5\.1 deg"):
        seen_from_above(stay(3, 5, east=0.9), WITHIN)
