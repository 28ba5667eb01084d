# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inputs become as wrong as the table says, and what is constant is contained."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import unstated_errors
import wrong_inputs

from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)


def changed(case, message, t=0.0):
    """Return a message after the change of a case, on whatever topic."""
    wrong_inputs.CASES[case][1](message, t)
    return message


def test_a_height_is_too_large_and_ever_more_so():
    assert changed("height -2 m", SimpleNamespace(data=30.0), 9.0).data == 28.0
    assert changed("height 0.1 m/s", SimpleNamespace(data=30.0), 20.0).data == pytest.approx(32.0)


@pytest.mark.parametrize(
    ("case", "azimuth_deg", "turned_deg"),
    [
        ("roll 2 deg", 30.0, (2.0, 0.0, 0.0)),
        ("pitch -2 deg", 30.0, (0.0, -2.0, 0.0)),
        ("heading 5 deg", 30.0, (0.0, 0.0, 5.0)),  # counterclockwise
        ("deviation 3 deg", 90.0, (0.0, 0.0, 3.0)),
        ("deviation 3 deg", 0.0, (0.0, 0.0, 0.0)),
        ("deviation 3 deg", -30.0, (0.0, 0.0, -1.5)),
    ],
)
def test_a_camera_is_turned_about_level_axes(case, azimuth_deg, turned_deg):
    yaw, down = math.radians(90.0 - azimuth_deg), math.radians(40.0)
    level, camera = matrix_from_rpy(0.0, 0.0, yaw), matrix_from_rpy(0.0, down, yaw)
    q = SimpleNamespace(**dict(zip("xyzw", quaternion_from_matrix(camera), strict=True)))
    changed(case, SimpleNamespace(quaternion=q))
    found = matrix_from_quaternion((q.x, q.y, q.z, q.w)) @ camera.T
    expected = level @ matrix_from_rpy(*np.radians(turned_deg)) @ level.T
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_fix_is_lost_for_some_time_again_and_again():
    lost = wrong_inputs.CASES["no fix for 4 s in 15"][1]
    assert [bool(lost(None, t)) for t in (0.0, 3.9, 4.1, 14.9, 15.1)] == [1, 1, 0, 0, 1]


def test_a_fix_is_off_to_the_north_at_times():
    def off_m(case, t):
        found = changed(case, SimpleNamespace(latitude=54.0), t)
        return round((found.latitude - 54.0) * wrong_inputs.METRES_A_DEGREE, 3)

    assert [off_m("fix 50 m off once", t) for t in (19.9, 20.0, 20.2)] == [0.0, 50.0, 0.0]
    assert [off_m("fix 5 m off for 2 s in 15", t) for t in (1.9, 2.1, 16.9)] == [5.0, 0.0, 5.0]
    assert [off_m("fix 3 m off from 40 s on", t) for t in (39.9, 60.0)] == [0.0, 3.0]


def test_a_gimbal_repeats_itself_until_it_moves_again():
    stuck = wrong_inputs.stuck(15.0, 5.0)
    found = []
    for k, t in enumerate((14.0, 15.0, 19.9, 20.1)):
        message = SimpleNamespace(quaternion=SimpleNamespace(x=k))
        stuck(message, t)
        found.append(message.quaternion.x)
    assert found == [0, 0, 0, 3]


def test_a_fifth_of_the_boxes_has_a_second_one_beside_it():
    message = image(*[(500.0, 400.0)] * 1000)
    changed("1 in 5 boxes doubled", message)
    more = [box.bbox.center.position for box in message.detections[1000:]]
    assert len(more) == pytest.approx(200, abs=50)
    assert np.std([place.x for place in more]) == pytest.approx(6.0, abs=1.0)
    assert np.mean([place.y for place in more]) == pytest.approx(400.0, abs=2.0)


def test_a_tenth_of_the_boxes_has_another_class():
    stamp = SimpleNamespace(sec=1, nanosec=2)
    boxes = [
        SimpleNamespace(results=[SimpleNamespace(hypothesis=SimpleNamespace(class_id="aqua"))])
        for _ in range(1000)
    ]
    message = SimpleNamespace(header=SimpleNamespace(stamp=stamp), detections=boxes)
    changed("1 in 10 boxes of another class", message)
    names = [box.results[0].hypothesis.class_id for box in boxes]
    assert names.count("aqua") + names.count("boat") == 1000
    assert names.count("boat") == pytest.approx(100, abs=30)


def test_lens_and_boxes():
    lens = SimpleNamespace(k=np.arange(9.0), p=np.arange(12.0))
    changed("focal length +10 %", lens)
    assert lens.k.tolist() == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.4, 5.0, 6.0, 7.0, 8.0])
    assert lens.p[5] == pytest.approx(5.5)
    place = SimpleNamespace(x=100.0, y=25.0)
    box = SimpleNamespace(bbox=SimpleNamespace(center=SimpleNamespace(position=place)))
    changed("boxes on 16 px", SimpleNamespace(detections=[box]))
    assert (place.x, place.y) == (96.0, 32.0)


def image(*places, sec=1_760_000_000):
    """Return an image with boxes at these places, px."""
    stamp = SimpleNamespace(sec=sec, nanosec=5)
    boxes = [SimpleNamespace(bbox=_box(SimpleNamespace(x=x, y=y))) for x, y in places]
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp), detections=boxes)


def _box(place):
    return SimpleNamespace(center=SimpleNamespace(position=place))


def places_of(message):
    """Return where the boxes of an image are (n, 2), px."""
    places = [box.bbox.center.position for box in message.detections]
    return np.array([(place.x, place.y) for place in places]).reshape(-1, 2)


def test_boxes_are_missed_moved_and_added():
    """The 1100 px of the focal length are one radian or so: 1 - 0.1 of where they are."""
    every = [(960.0 + 1100.0, 540.0)] * 4000
    np.testing.assert_allclose(
        places_of(changed("distortion -0.1", image(*every[:1]))), [[960.0 + 990.0, 540.0]]
    )
    assert len(places_of(changed("half the boxes missed", image(*every)))) == pytest.approx(
        2000, abs=150
    )
    assert len(places_of(changed("7 of 10 boxes missed", image(*every)))) == pytest.approx(
        1200, abs=150
    )
    off = places_of(changed("boxes noisy by 8 px", image(*every))) - every[0]
    np.testing.assert_allclose(off.std(axis=0), 8.0, atol=0.5)
    again = places_of(changed("boxes noisy by 8 px", image(*every))) - every[0]
    np.testing.assert_array_equal(again, off)
    seen = [len(changed("no boxes for 5 s in 15", image(*every[:1]), t).detections) for t in (
        0.0, 4.9, 5.0, 14.9, 15.1)]  # fmt: skip
    assert seen == [0, 0, 1, 1, 0]
    shown = places_of(changed("a spot on the lens", image((3.0, 4.0))))
    assert shown.tolist() == [[3.0, 4.0], [400.0, 700.0]]


def test_stamps_and_places_of_telemetry():
    stamp = SimpleNamespace(sec=9, nanosec=900_000_000)
    changed("gimbal 0.3 s late", SimpleNamespace(header=SimpleNamespace(stamp=stamp)))
    assert (stamp.sec, stamp.nanosec) == (10, 200_000_000)
    fix = changed("fix 1 m in 40 s", SimpleNamespace(latitude=60.0, longitude=5.0), 10.0)
    assert fix.latitude == pytest.approx(60.0 + 1.0 / 111_200.0, abs=1e-9)
    assert fix.longitude == pytest.approx(5.0, abs=1e-9)
    assert changed("height in whole m", SimpleNamespace(data=30.6)).data == 31.0
    assert changed("height 0.5 m in 6 s", SimpleNamespace(data=30.0), 1.5).data == 30.5
    camera = matrix_from_rpy(*np.radians([0.4, 39.7, -20.2]))
    q = SimpleNamespace(**dict(zip("xyzw", quaternion_from_matrix(camera), strict=True)))
    changed("angles in whole deg", SimpleNamespace(quaternion=q))
    found = matrix_from_quaternion((q.x, q.y, q.z, q.w))
    np.testing.assert_allclose(found, matrix_from_rpy(*np.radians([0.0, 40.0, -20.0])), atol=1e-9)


@pytest.mark.flights
@pytest.mark.parametrize(
    ("case", "flight"),
    [
        ("height 2 m", "orbit40_moving_quiet"),
        ("heading 5 deg", "orbit40_moving_quiet"),
        ("deviation 5 deg", "orbit30_still"),
    ],
)
def test_a_constant_error_is_contained(case, flight, independent_flights):
    found = unstated_errors.fly(case, independent_flights / flight)
    assert found.positions > 0.95
    assert found.wrong < 0.01
    assert found.names == 3


@pytest.mark.flights
@pytest.mark.parametrize(
    ("case", "flight", "error_m"),
    [
        ("half the boxes missed", "orbit30_still", 0.12),
        ("half the boxes missed", "orbit60_coloured", 0.5),
        ("7 of 10 boxes missed", "transit30_still", 0.3),
        ("no boxes for 5 s in 15", "orbit30_still", 0.12),
        ("no boxes for 5 s in 15", "orbit60_coloured", 0.5),
    ],
)
def test_robots_that_stay_are_known_where_boxes_are_missed(
    case, flight, error_m, independent_flights
):
    found = unstated_errors.fly(case, independent_flights / flight)
    assert found.positions > (0.4 if case == "half the boxes missed" else 0.25)
    assert found.error_m < error_m
    assert found.names == 3
