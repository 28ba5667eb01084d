# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots are confirmed where images come seldom, and false boxes are not."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.processing import TracksConfig
from aerial_gnss_ros.core.tracker.confirmation_rule import ConfirmationRule

pytestmark = pytest.mark.flights

SECOND = 1_000_000_000


def paced(*gaps_s):
    pace, stamp_ns = ConfirmationRule(TracksConfig()), 0
    pace.note(0)
    for gap_s in gaps_s:
        stamp_ns += round(gap_s * SECOND)
        pace.note(stamp_ns)
    return pace.hits, pace.window_ns / SECOND


@pytest.mark.parametrize(
    ("gaps_s", "hits", "window_s"),
    [
        ((), 3, 2.0),
        ((0.1,) * 9, 3, 2.0),
        ((1.0,) * 9, 3, 2.0),  # three images come within two seconds
        ((1.01,) * 9, 4, 4.04),
        ((1.25,) * 9, 4, 5.0),
        ((1.5,) * 9, 4, 6.0),
        ((3.4,) * 9, 4, 13.6),
        ((3.51,) * 9, 3, 2.0),  # rarer than is made up for
        ((0.1, 0.1, 0.1, 1.3), 3, 2.0),  # one pause is none
        ((0.1, 1.3), 3, 2.0),
        ((1.25,) * 9 + (0.1,) * 3, 3, 2.0),
    ],
)
def test_the_window_is_stretched_to_images_that_come_seldom(gaps_s, hits, window_s):
    assert paced(*gaps_s) == (hits, pytest.approx(window_s))


def test_a_reset_forgets_how_often_images_came():
    pace = ConfirmationRule(TracksConfig())
    for i in range(5):
        pace.note(round(1.25 * SECOND) * i)
    assert pace.hits == 4
    pace.reset()
    assert (pace.hits, pace.window_ns) == (3, 2 * SECOND)


def test_images_of_one_moment_count_once():
    rule = ConfirmationRule(TracksConfig())
    for interval_s, enough in ((1.0 / 60.0, 7), (1.0 / 30.0, 5), (0.1, 3), (1.0, 3)):
        stamps = [round(k * interval_s * SECOND) for k in range(enough)]
        assert rule.enough(stamps)
        assert not rule.enough(stamps[:-1])


def robots_found(sea, clutter, seed, images=0.8, telemetry=5):
    world = sea.World(
        robots={
            "a": lambda t: (-3.0 + 0.3 * math.sin(t / 5.0), 18.0),
            "b": lambda t: (4.0, 20.0 + 0.3 * math.sin(t / 4.0)),
        },
        pixel_sigma=2.0,
        missed=0.1,
        clutter=clutter,
        seed=seed,
    )
    engine = sea.estimator()
    sea.play(engine, world, max(24.0 / images, 8.0), images=images, telemetry=telemetry)
    assert engine.boxes == engine.used + engine.counts.total()
    return len(engine.robots)


@pytest.mark.parametrize("clutter", [0.0, 1.0, 5.0])
def test_robots_are_confirmed_by_0_8_images_a_second_and_foam_is_not(sea, clutter):
    assert [robots_found(sea, clutter, seed) for seed in (1, 2)] == [2, 2]


@pytest.mark.parametrize("images", [0.3, 5.0, 60.0])
def test_robots_are_confirmed_at_any_rate_with_telemetry_once_a_second(sea, images):
    assert robots_found(sea, 0.3, 1, images, 1) == 2


def test_images_are_kept_within_the_window():
    pace = ConfirmationRule(TracksConfig())
    for tenth in range(50):
        pace.note(tenth * SECOND // 10)
    assert list(pace.images) == [tenth * SECOND // 10 for tenth in range(29, 50)]
    assert pace.first_ns == 0
