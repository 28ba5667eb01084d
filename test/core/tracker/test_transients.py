# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Foam is no robot, and no robot waits where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.tracker.transients import TUNING, Transients
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

SECOND = 1_000_000_000


def test_some_are_expected_before_any_has_ended():
    assert Transients(0.25).expected(SECOND, 0.0, 0.0, 0.25) == TUNING.unseen


def test_longer_and_higher_scores_are_less_expected():
    seen = Transients(0.25)
    for _ in range(4):
        seen.note(SECOND, 0.5)
    every = TUNING.unseen + 3.0
    assert seen.expected(SECOND, 1.0, 0.0, 0.25) == pytest.approx(every)
    assert seen.expected(SECOND, 1.0, 0.0, 0.1) == pytest.approx(every)
    later = seen.expected(SECOND, 1.0, TUNING.lifetime_s, 0.25)
    surer = seen.expected(SECOND, 1.0, 0.0, 0.25 + TUNING.score_scale)
    assert (later, surer) == pytest.approx((every / math.e, every / math.e))


def test_they_are_forgotten():
    seen = Transients(0.25)
    seen.note(SECOND, 1.0)
    memory_ns = round(TUNING.memory_s * 1e9)
    assert seen.expected(SECOND + memory_ns - 1, 0.0, 0.0, 0.25) == TUNING.unseen + 1.0
    assert seen.expected(SECOND + memory_ns + 1, 0.0, 0.0, 0.25) == TUNING.unseen
    seen.note(SECOND, 1.0)
    seen.reset()
    assert seen.expected(SECOND, 0.0, 0.0, 0.25) == TUNING.unseen


class Foam:
    """Three patches of foam a second, each of which stays for 0.6 s; then a robot surfaces."""

    BEGIN_S, PLACE = 10.0, (-3.0, 20.0)

    def __init__(self, sea, score, seed=4):
        rng = np.random.default_rng(seed)
        self.boxes, self.score = sea.boxes, score
        self.world = sea.World(robots={"a": lambda _t: self.PLACE})
        self.world.hidden = lambda _name, t: t < self.BEGIN_S
        self.patches = [
            (t, rng.uniform((100, 100), (1180, 620))) for t in np.arange(0.0, 40.0, 1.0 / 3.0)
        ]

    def __getattr__(self, name):
        return getattr(self.world, name)

    def frame(self, t):
        """Return the boxes of an image: the robot, and foam of low score."""
        robots = self.world.frame(t)
        foam = [place for begin, place in self.patches if begin <= t < begin + 0.6]
        both = self.boxes(t, [*robots.centers, *foam], score=0.4)
        both.scores[: len(robots)] = self.score
        return both


def confirmed(sea, score):
    """Return when images have shown foam, and the robot, that were taken for robots, s."""
    results = sea.play(sea.estimator(), Foam(sea, score), 17.0)
    foam, robot = [], []
    for result in results:
        t = (result.stamp_ns - results[0].stamp_ns) * 1e-9
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                near = np.hypot(*(one.position - Foam.PLACE)) < 0.5
                (robot if near else foam).append(t)
    return foam, robot


def test_foam_is_no_robot_and_a_sure_one_hardly_waits(sea):
    foam, robot = confirmed(sea, 0.85)
    assert not foam
    assert Foam.BEGIN_S < min(robot) < Foam.BEGIN_S + 1.3


def test_one_of_low_score_is_confirmed_once_it_has_outlasted_foam(sea):
    _, robot = confirmed(sea, 0.4)
    assert Foam.BEGIN_S + 3.0 < min(robot) < Foam.BEGIN_S + 7.0


class Glint(Foam):
    """Flashes of glint round one place, six an image in the mean; nothing else."""

    def __init__(self, sea, seed):
        super().__init__(sea, 0.4)
        self.rng = np.random.default_rng(seed)

    def frame(self, t):
        """Return the boxes of an image."""
        places = self.rng.normal((640, 360), 100.0, (self.rng.poisson(6.0), 2))
        return self.boxes(t, places, score=0.4)


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_flash_after_flash_at_one_place_is_no_robot(sea, seed):
    """A track of several flashes lasts, but most images do not show it."""
    results = sea.play(sea.estimator(), Glint(sea, seed), 30.0, images=5)
    assert not any(result.estimates for result in results)
