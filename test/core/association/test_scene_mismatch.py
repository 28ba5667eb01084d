# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images that contradict most robots, and when they are believed again."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.association.clutter import Clutter
from aerial_gnss_ros.core.association.scene_mismatch import RobotsSeen, SceneMismatch

PASSED_S = 0.2


@pytest.mark.parametrize(
    ("seen", "known", "contradicts"),
    [
        (RobotsSeen(0, 0, 5), 0, False),
        (RobotsSeen(1, 0, 1), 1, False),  # one alone cannot outvote telemetry
        (RobotsSeen(4, 0, 1), 1, False),  # and no more than one box tells of where it is
        (RobotsSeen(2, 0, 2), 2, True),
        (RobotsSeen(2, 1, 1), 2, False),
        (RobotsSeen(5, 1, 2), 3, True),
        (RobotsSeen(5, 2, 2), 4, False),
    ],
)
def test_an_image_tells_of_as_many_robots_as_it_has_boxes(seen, known, contradicts):
    assert (seen.known, seen.contradicts) == (known, contradicts)


def often_wrong(robots=2):
    """Return rates of a detector that misses two robots in five beside a false box an image."""
    rates = Clutter()
    for k in range(400):
        rates.update(k, robots, (k % 5 < 2) + (k % 5 > 2), 1)
    return rates


def images_until_displaced(mismatch, rates):
    """Return how many images without a robot, but with three boxes, it takes."""
    count = 1
    while not mismatch.update(rates, RobotsSeen(2, 0, 3), PASSED_S):
        count += 1
    return count


def test_a_second_mismatch_needs_as_much_evidence_as_the_first():
    rates, mismatch = often_wrong(), SceneMismatch()
    first = images_until_displaced(mismatch, rates)
    assert first > 1
    assert mismatch.active
    mismatch.end()
    assert not mismatch.active
    assert images_until_displaced(mismatch, rates) == first


def test_what_telemetry_tells_lasts_until_robots_are_found_again():
    rates, mismatch = Clutter(), SceneMismatch()
    mismatch.expect()
    assert not mismatch.update(rates, RobotsSeen(0, 0, 0), PASSED_S)
    assert mismatch.active
    assert not mismatch.update(rates, RobotsSeen(3, 2, 0), PASSED_S)  # two of two boxes
    assert mismatch.active
    assert not mismatch.update(rates, RobotsSeen(3, 2, 1), PASSED_S)  # two of three
    assert not mismatch.active


def test_the_sentence_has_the_numbers_and_comes_once():
    rates, mismatch, said = Clutter(), SceneMismatch(), []
    for seen in [RobotsSeen(5, 1, 3), *[RobotsSeen(5, 1, 2)] * 3]:
        mismatch.update(rates, seen, PASSED_S)
        said.append(mismatch.sentence[:28])
    assert said == ["", "2 of 3 boxes are not where r", "", ""]
