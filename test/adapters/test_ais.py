# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports for AIS, by ITU-R M.1371."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.ais import position_report, static_report

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import SEEN


def test_a_position_report_is_of_class_b_and_knows_no_speed_and_no_course():
    report = position_report(SEEN, 211_234_567)
    assert (report["type"], report["mmsi"], report["second"]) == (18, 211_234_567, 20)
    assert [report["lat"], report["lon"]] == pytest.approx([13.19394, -59.64151])
    assert (report["speed"], report["course"], report["heading"]) == (102.3, 360.0, 511)


@pytest.mark.parametrize(("sigma", "accurate"), [(3.53, 1), (3.54, 0), (math.inf, 0)])
def test_a_position_is_accurate_where_95_percent_are_within_10_m(sigma, accurate):
    """Twice the root of 2 sigmas: 10 m at 3.536 m."""
    assert position_report(replace(SEEN, sigma=sigma), 1)["accuracy"] == accurate


def test_a_robot_that_is_not_seen_is_estimated():
    assert position_report(replace(SEEN, measured=False), 1)["second"] == 62


@pytest.mark.parametrize(
    ("namespace", "robot", "name"),
    [
        ("d1", "aqua_1", "D1/AQUA_1"),
        ("", "aqua_1", "AQUA_1"),
        ("drone1", "a_very_long_name_of_a_robot", "DRONE1/A_VERY_LONG_N"),
        ("", "boje.é", "BOJE  "),
    ],
)
def test_a_name_has_at_most_twenty_letters_of_ais(namespace, robot, name):
    report = static_report(replace(SEEN, namespace=namespace, robot_id=robot), 7)
    assert (report["type"], report["partno"], report["shipname"]) == (24, 0, name)
