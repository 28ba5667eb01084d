# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots without a box: missed among false boxes, or all of them displaced?"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import betabinom, nbinom

from aerial_gnss_ros.core.association.clutter import Clutter
from aerial_gnss_ros.core.association.displaced_robots import DisplacedRobots, displaced_nats


def learnt(missed, false, images=400, robots=2, seed=1):
    """Return rates after images with a share of missed robots and a number of false boxes."""
    rng, rates = np.random.default_rng(seed), Clutter()
    for k in range(images):
        rates.update(k, robots, rng.binomial(robots, missed), rng.poisson(false))
    return rates


@pytest.mark.parametrize(("robots", "matched", "others"), [(2, 0, 2), (3, 1, 2), (5, 0, 1)])
def test_both_hypotheses_by_an_independent_library(robots, matched, others):
    """Fresh rates: a beta of 0.5 and 9.5, a gamma of 0.2 in 10 images."""
    rates = Clutter()

    def chance(missed, false):
        likely = nbinom.logpmf(false, 0.2, 10.0 / 11.0)
        return betabinom.logpmf(missed, robots, 0.5, 9.5) + likely

    boxes = matched + others
    elsewhere = sum(
        math.exp(chance(robots - seen, boxes - seen)) for seen in range(min(robots, boxes) + 1)
    )
    expected = math.log(elsewhere) - chance(robots - matched, others)
    assert displaced_nats(rates, robots, matched, others) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("missed", "false", "images"),
    [(0.02, 0.01, 1), (0.05, 0.1, 1), (0.15, 0.7, 2), (0.4, 1.0, 3)],
)
def test_a_displacement_shows_the_later_the_more_false_boxes_there_are(missed, false, images):
    rates, found = learnt(missed, false), DisplacedRobots()
    at_once = [found.update(rates, 2, 0, 2 + round(false), 1.0 / 15.0) for _ in range(images)]
    assert at_once == [False] * (images - 1) + [True]


def test_missed_robots_among_false_boxes_are_hardly_ever_displaced_ones():
    """A quarter of an hour at 15 Hz; one in a hundred images has two false boxes and no robot."""
    rng, rates, found = np.random.default_rng(3), learnt(0.15, 0.7), DisplacedRobots()
    asked = displaced = 0
    for k in range(13500):
        matched, others = rng.binomial(2, 0.85), rng.poisson(0.7)
        if not matched and others > 1:
            asked += 1
            displaced += found.update(rates, 2, 0, others, 1.0 / 15.0)
        elif matched:
            found.reset()
        rates.update(1000 + k, 2, 2 - matched, others)
    assert asked > 30
    assert displaced <= 1


def test_what_has_been_seen_counts_until_most_robots_are_where_they_should_be():
    rates, found = learnt(0.15, 0.7), DisplacedRobots()
    assert not found.update(rates, 2, 0, 2, 0.2)
    found.reset()
    assert not found.update(rates, 2, 0, 2, 0.2)
    assert found.update(rates, 2, 0, 2, 0.2)
