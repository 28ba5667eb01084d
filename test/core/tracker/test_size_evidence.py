# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is too short or too long in the mean is no robot, and where many specks last, some are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.size_fit import SizeSums
from aerial_gnss_ros.core.tracker.size_evidence import TUNING, chance_of_size, expected_specks
from aerial_gnss_ros.core.values.rejection import Cause, Reason

pytestmark = pytest.mark.flights

SECOND = 1_000_000_000


def sums(shortfall, count=1, white=0.0, excess=-1.0):
    return SizeSums(count, count * shortfall, count * excess, count * 0.04, count * white)


def track(shortfall, lasted_s=5.0, score=0.3, **more):
    return Track(
        "aqua", 0, round(lasted_s * SECOND), sizes=sums(shortfall, 9), score_sum=9 * score,
        score_count=9, **more,
    )  # fmt: skip


def expected(one, others, seen_s=5.0):
    return expected_specks(one, [one, *others], seen_s, 0.3, 0.1)


@pytest.mark.parametrize("longer", [False, True])
def test_two_sigmas_off_has_the_chance_of_a_normal_law(longer):
    sizes = sums(-1.0, excess=0.4) if longer else sums(0.4)
    assert chance_of_size(sizes, 0.0) == pytest.approx(0.0455, abs=1e-4)


def test_nothing_is_held_against_the_right_size_or_none():
    assert chance_of_size(SizeSums(), 0.0) == 1.0
    assert chance_of_size(sums(-0.1), 0.0) == 1.0
    assert chance_of_size(sums(-math.inf, excess=-math.inf), 0.0) == 1.0


def test_edges_average_out_over_time_and_what_boxes_share_does_not():
    at_once, later = (chance_of_size(sums(0.3, 50, white=0.5), s) for s in (0.0, 30.0))
    assert chance_of_size(sums(0.3, white=0.5), 0.0) == pytest.approx(at_once)
    assert later < 0.3 < at_once
    assert later > chance_of_size(sums(0.3), 0.0)


def test_specks_tell_of_longer_ones():
    speck = track(1.0)
    assert expected(track(0.0), []) == 0.0
    one = expected(track(1.0 - TUNING.speck_scale), [speck])
    assert one == pytest.approx(math.exp(-1.0), rel=1e-3)
    assert expected(track(1.0 - TUNING.speck_scale), [speck] * 3) == pytest.approx(3.0 * one)
    assert expected(track(1.0 - 2.0 * TUNING.speck_scale), [speck]) == pytest.approx(one / math.e)
    assert expected(track(1.5), [speck]) == pytest.approx(1.0, rel=1e-3)


def test_robots_and_specks_of_a_shorter_life_tell_nothing():
    assert expected(track(0.0), [track(-0.1)]) == 0.0
    assert expected(track(0.0), [track(1.0, robot_id="aqua_1")]) == 0.0
    assert expected(track(0.0), [track(1.0, lasted_s=4.9)]) == 0.0
    assert expected(track(-math.inf), [track(1.0)]) == 0.0


def test_the_score_counts_against_those_of_specks():
    low, high = track(1.0, score=0.3), track(1.0, score=0.7)
    sure = track(1.0, score=0.7)
    assert expected(sure, [low]) == pytest.approx(math.exp(-4.0), rel=1e-3)
    assert expected(sure, [high]) == pytest.approx(math.exp(-1.0), rel=1e-3)


def test_what_moves_unlike_specks_is_less_likely_one_of_them():
    drift = np.array([0.5, -0.3])
    specks = [track(1.0, velocity=drift) for _ in range(4)]
    with_them = expected(track(0.5, velocity=drift), specks)
    assert with_them == pytest.approx(expected(track(0.5), [track(1.0)] * 4))
    swims = expected(track(0.5, velocity=drift + 1.0), specks)
    assert swims == pytest.approx(TUNING.mistaken_share * with_them, rel=1e-3)
    unknown = {"velocity": drift + 1.0, "velocity_spread": 100.0 * np.eye(2)}
    assert expected(track(0.5, **unknown), specks) > 0.9 * with_them
    apart = [track(1.0, velocity=drift + way) for way in ((2, 0), (-2, 0), (0, 2), (0, -2))]
    assert expected(track(0.5, velocity=drift + 1.0), apart) > 0.5 * with_them


class Glitter:
    """A robot of 0.6 m from first to last, and specks a third as long that stay as well."""

    ROBOT = (3.0, 22.0)

    def __init__(self, sea, seed):
        self.rng = np.random.default_rng(seed)
        places = self.rng.uniform((-8.0, 12.0), (8.0, 26.0), (12, 2))
        places = places[np.hypot(*(places - self.ROBOT).T) > 2.5]
        self.world = sea.World(robots={"robot": lambda _t: self.ROBOT})
        self.specks = sea.World(
            robots={f"{i}": lambda _t, at=tuple(at): at for i, at in enumerate(places)}
        )
        self.boxes = sea.boxes

    def __getattr__(self, name):
        return getattr(self.world, name)

    def frame(self, t):
        """Return the boxes of an image, with edges uncertain by 0.7 px."""
        robot, specks = self.world.frame(t), self.specks.frame(t)
        found = self.boxes(t, [*robot.centers, *specks.centers], score=0.5)
        away = np.hypot(30.0, np.hypot(*self.ROBOT))
        length = np.full(len(found), 0.2 * self.world.camera.K[0, 0] / away)
        length[: len(robot)] *= 3.0
        found.scores[: len(robot)] = 0.8
        found.sizes[:] = np.column_stack([length, 0.6 * length])
        found.sizes[:] += self.rng.normal(0.0, 0.7, found.sizes.shape)
        return found


@pytest.mark.parametrize("seed", [1, 2])
def test_lasting_specks_are_not_confirmed_and_the_robot_among_them_is(sea, seed):
    stated = {"classes.aqua.length_m": [0.4, 0.9]}
    engine = sea.estimator(stated)
    results = sea.play(engine, Glitter(sea, seed), 20.0, images=5)
    assert {one.robot_id for result in results for one in result.estimates} == {"aqua_1"}
    last = results[-1].estimates[0]
    assert np.hypot(*(last.position - np.array(Glitter.ROBOT))) < 1.0
    assert engine.causes[Cause.WRONG_SIZE] > 100
    refused = [one.reason for result in results for one in result.rejections]
    assert refused.count(Reason.WRONG_SIZE) < 100
    unstated = sea.play(sea.estimator(), Glitter(sea, seed), 5.0)
    assert len(unstated[-1].estimates) > 6
