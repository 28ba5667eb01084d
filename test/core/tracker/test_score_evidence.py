# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What scores lower in the mean than robots do is no robot, however long it lasts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.tracker.score_evidence import (
    TUNING,
    chance_of_score,
    log_odds,
    scores_as_robots,
)
from aerial_gnss_ros.core.values.rejection import Cause

LEAST = 0.7


def test_log_odds_are_finite_and_even():
    assert log_odds(0.5) == 0.0
    assert log_odds(0.9) == pytest.approx(math.log(9.0))
    assert log_odds(0.0) == pytest.approx(-log_odds(1.0))
    assert math.isfinite(log_odds(0.0))


def test_the_mean_must_exceed_the_least_by_its_uncertainty():
    limit = log_odds(LEAST)
    one, many = limit + TUNING.spread, limit + TUNING.spread / 10.0
    assert scores_as_robots(one + 1e-9, 1, 0.0, LEAST)
    assert not scores_as_robots(one - 1e-9, 1, 0.0, LEAST)
    assert scores_as_robots(100 * many + 1e-6, 100, 1000.0, LEAST)
    assert not scores_as_robots(100 * many - 1e-6, 100, 1000.0, LEAST)


def test_boxes_of_one_moment_are_no_independent_looks():
    odds = log_odds(LEAST) + 0.6 * TUNING.spread
    assert scores_as_robots(30 * odds, 30, 30.0, LEAST)
    assert not scores_as_robots(30 * odds, 30, 0.5, LEAST)


def test_without_a_least_score_or_boxes_nothing_is_held_against_a_track():
    assert scores_as_robots(-100.0, 10, 5.0, 0.0)
    assert scores_as_robots(0.0, 0, 0.0, LEAST)


def test_merged_tracks_have_the_boxes_of_both():
    one = Track("aqua", 0, 0, score_sum=0.5, odds_sum=1.0, score_count=1)
    one.absorb(Track("aqua", 0, 0, score_sum=0.25, odds_sum=-3.0, score_count=2))
    assert (one.score_sum, one.odds_sum, one.score_count) == (0.75, -2.0, 3)


class Bathers:
    """A robot and two swimmers in view from first to last; each has scores of its own."""

    ODDS = (0.3, -0.2, 2.0)  # log odds in the mean, from left to right

    def __init__(self, sea, seed):
        self.world = sea.World(
            robots={
                "robot": lambda _t: (3.0, 22.0),
                "swimmer": lambda _t: (-3.0, 20.0),
                "other": lambda _t: (0.0, 16.0),
            }
        )
        self.rng = np.random.default_rng(seed)

    def __getattr__(self, name):
        return getattr(self.world, name)

    def frame(self, t):
        """Return the boxes of an image."""
        found = self.world.frame(t)
        odds = self.rng.normal(self.ODDS, 0.7)
        found.scores[np.argsort(found.centers[:, 0])] = 1.0 / (1.0 + np.exp(-odds))
        return found


@pytest.mark.parametrize("seed", [1, 2])
def test_swimmers_last_but_are_not_confirmed(sea, seed):
    stated = {"tracks.confirm_score": LEAST, "detections.min_score": 0.0}
    engine = sea.estimator(stated)
    results = sea.play(engine, Bathers(sea, seed), 20.0, images=5)
    names = {one.robot_id for result in results for one in result.estimates}
    assert names == {"aqua_1"}
    last = results[-1].estimates[0]
    assert np.hypot(*(last.position - np.array([3.0, 22.0]))) < 1.0
    assert engine.causes[Cause.UNSURE] > 150
    engine.reconfigure(estimator_config({**sea.origin, "detections.min_score": 0.0}))
    later = sea.play(engine, Bathers(sea, seed), 2.0, begin=20.2, images=5)
    assert len(later[-1].estimates) == 3
    unstated = sea.play(sea.estimator({"detections.min_score": 0.0}), Bathers(sea, seed), 5.0)
    assert len(unstated[-1].estimates) == 3


def scored(score, boxes=20, lasted_s=4.0, class_id="aqua"):
    """Return a track whose boxes all have one score."""
    odds = log_odds(score)
    return Track(
        class_id, 0, round(lasted_s * 1e9),
        score_sum=boxes * score, odds_sum=boxes * odds, score_count=boxes,
    )  # fmt: skip


def test_the_chance_of_a_robot_that_scores_lower_than_the_others():
    """By hand: two known robots at 2.0, a track at 1.0 that lasted 3 s, six independent looks."""
    high, low = 1.0 / (1.0 + math.exp(-2.0)), 1.0 / (1.0 + math.exp(-1.0))
    known = [scored(high), scored(high)]
    sigma = math.sqrt(0.8**2 / 6.0 + 0.5**2 + (0.8**2 + 0.5**2) / 2.0)
    expected = math.erfc(1.0 / sigma / math.sqrt(2.0))
    assert chance_of_score(scored(low, 60, 3.0), known) == pytest.approx(expected)
    assert chance_of_score(scored(0.3), known) == 0.05  # however low
    assert chance_of_score(scored(high), known) == 1.0
    assert chance_of_score(scored(0.99), known) == 1.0  # a high score is nothing against it


def test_without_robots_of_its_class_nothing_is_held_against_a_low_score():
    assert chance_of_score(scored(0.4), []) == 1.0
    assert chance_of_score(scored(0.4), [scored(0.9, class_id="boat")]) == 1.0
    assert chance_of_score(Track("aqua", 0, 0), [scored(0.9)]) == 1.0


@pytest.mark.parametrize("known", [True, False])
def test_what_scores_lower_than_the_robots_must_last_longer(sea, known):
    """For 2.5 s something is seen whose scores, 0.62 each, are a little low for the robot's."""
    robots = {"foam": lambda _t: (-3.0, 20.0)}
    if known:
        robots["robot"] = lambda _t: (3.0, 22.0)
    world = sea.World(robots=robots, pixel_sigma=1.0)
    world.hidden = lambda name, t: name == "foam" and not 10.0 < t < 12.5
    shown = world.frame

    def frame(t):
        found = shown(t)
        found.scores[found.centers[:, 0] < 640.0] = 0.62
        return found

    world.frame = frame
    results = sea.play(sea.estimator(), world, 15.0, images=5)
    names = {one.robot_id for result in results for one in result.estimates}
    assert names == {"aqua_1"}
    first = min(result.stamp_ns for result in results if result.estimates)
    assert (first < sea.stamp(2.0)) is known
