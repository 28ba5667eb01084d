# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Noise larger than stated is found; what is no white noise is not taken for it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binom, chi2

from aerial_gnss_ros.core.faults.noise_level import (
    _CORRELATED,
    NO_INNOVATIONS,
    NoiseLevel,
    _sure_level,
)
from aerial_gnss_ros.core.faults.noise_level import TUNING as NOISE_LEVEL

STEP_NS = 100_000_000
VARIANCES = 0.04, 0.01, 0.09
ROOT = np.linalg.cholesky([[0.04, 0.01], [0.01, 0.09]])


def fed(level: NoiseLevel, offsets: np.ndarray, uneven: bool = False) -> NoiseLevel:
    """Let it see offsets (images, robots, 2) of robots, as the stated noise would scale them."""
    stamps = np.arange(len(offsets)) * STEP_NS
    if uneven:
        stamps = np.cumsum(np.where(np.arange(len(offsets)) % 2, STEP_NS, 3 * STEP_NS))
    last = [NO_INNOVATIONS] * offsets.shape[1]
    for stamp_ns, image in zip(stamps.tolist(), (offsets @ ROOT.T).tolist(), strict=True):
        both = zip(last, image, strict=True)
        last = [(*before[6:], stamp_ns, *offset, *VARIANCES) for before, offset in both]
        level.update(last)
    return level


def white(images: int, robots: int, sigma: float, seed: int = 0) -> np.ndarray:
    """Return white innovations, so many times as large as stated."""
    return sigma * np.random.default_rng(seed).standard_normal((images, robots, 2))


@pytest.mark.parametrize(("sigma", "robots"), [(2.5, 3), (2.0, 1), (5.0, 2)])
def test_finds_white_noise_larger_than_stated(sigma, robots):
    found = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, robots, sigma)).level
    # Overlapping differences of one robot: four sigmas of its median.
    assert found == pytest.approx(
        sigma**2, rel=4.0 * 2.01 / np.sqrt(robots * NOISE_LEVEL.level_images)
    )


def test_leaves_noise_alone_that_is_as_stated_or_less():
    images = 20 * NOISE_LEVEL.level_images
    for seed, sigma in enumerate((1.0, 1.0, 1.0, 1.1, 0.3)):
        level = NoiseLevel()
        for part in np.split(white(images, 3, sigma, seed), 20):
            assert fed(level, part).level == 1.0


def test_counts_robots_of_one_image_as_one_since_they_share_the_poses_noise():
    shared = np.repeat(white(10 * NOISE_LEVEL.level_images, 1, 1.15), 6, axis=1)
    assert fed(NoiseLevel(), shared).level == 1.0


@pytest.mark.parametrize(
    "motion",
    [
        np.linspace(
            0.0, 60.0, NOISE_LEVEL.level_images
        ),  # a camera that turns: 0.6 sigmas an image
        np.where(
            np.arange(NOISE_LEVEL.level_images) < 50, 0.0, 50.0
        ),  # telemetry that jumps and stays
        10.0 * np.sin(np.arange(NOISE_LEVEL.level_images) / 15.0),  # robots that steer
    ],
)
def test_what_lasts_several_images_is_no_noise(motion):
    offsets = white(NOISE_LEVEL.level_images, 3, 1.0) + motion[:, None, None]
    assert fed(NoiseLevel(), offsets).level == 1.0


def test_single_images_that_are_wrong_do_not_move_it():
    offsets = white(NOISE_LEVEL.level_images, 3, 2.5)
    clean = fed(NoiseLevel(), offsets).level
    offsets[::15] += 40.0
    assert fed(NoiseLevel(), offsets).level == pytest.approx(clean, rel=0.5)


def test_needs_images_enough_at_even_intervals():
    noisy = white(NOISE_LEVEL.level_images, 3, 2.5)
    assert fed(NoiseLevel(), noisy[: NOISE_LEVEL.least_images + 3]).level == 1.0
    assert fed(NoiseLevel(), noisy[:20]).level > 3.0
    coarse = white(NOISE_LEVEL.level_images, 3, 10.0)
    assert fed(NoiseLevel(), coarse[: NOISE_LEVEL.least_images + 1]).level == 1.0
    assert fed(NoiseLevel(), coarse[: NOISE_LEVEL.least_images + 2]).level > 30.0
    assert fed(NoiseLevel(), noisy, uneven=True).level == 1.0


def test_is_bounded_and_forgets():
    level = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, 3, 50.0))
    assert level.level == NOISE_LEVEL.largest_level
    fed(level, white(NOISE_LEVEL.level_images, 3, 1.0))
    assert level.level == 1.0
    fed(level, white(NOISE_LEVEL.level_images, 3, 2.5))
    level.reset()
    assert level.level == 1.0


def test_the_sum_of_second_differences_is_normalised():
    """Of white innovations half the normalised square is half a chi-square of two degrees."""
    found = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, 3, 2.5))
    values = np.frombuffer(found._values)
    share = np.mean(values < 2.5**2 * chi2.ppf(0.9, 2) / 2.0)
    assert share == pytest.approx(0.9, abs=0.06)


@pytest.mark.parametrize("count", [3, 5, 11])
def test_correct_noise_looks_larger_once_in_four_thousand_estimates(count):
    """By the binomial distribution of how many of so many independent values are beyond."""
    beyond = math.exp(-_sure_level(count * _CORRELATED) * math.log(2.0))
    assert binom.sf((count - 1) // 2, count, beyond) == pytest.approx(NOISE_LEVEL.by_chance)


def test_images_counted_too_much_are_told_once_while_the_level_knows_all_of_them():
    level = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, 3, 2.5))
    first = level.take_underestimated()
    assert first == pytest.approx(level.level, rel=0.5)
    assert level.take_underestimated() == 1.0
    late = fed(NoiseLevel(), white(NOISE_LEVEL.level_images + 3, 3, 1.0))
    fed(late, white(NOISE_LEVEL.level_images, 3, 2.5))
    assert late.level > 3.0
    assert late.take_underestimated() == 1.0


def test_noise_is_uncertain_until_it_is_seen():
    few, many = NOISE_LEVEL.least_images + 1, NOISE_LEVEL.level_images + 2
    assert NoiseLevel().unknown == 2.0  # of Student's t with 4 degrees of freedom
    assert fed(NoiseLevel(), white(many, 3, 1.0)).unknown == pytest.approx(1.0, abs=0.1)
    larger = fed(NoiseLevel(), white(few, 3, 3.0))
    assert larger.level == 1.0
    assert larger.unknown > 3.0
    assert fed(NoiseLevel(), white(many, 3, 3.0)).unknown == pytest.approx(1.0, abs=0.1)


def test_slow_errors_are_as_likely_as_not_as_much_larger_as_white_noise():
    level = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, 3, 3.0))
    assert level.of_slow_errors == 1.0  # as long as the filter has not been told
    factor = level.take_underestimated()
    assert level.of_slow_errors == pytest.approx(0.5 * (1.0 + factor))
    level.reset()
    assert level.of_slow_errors == 1.0


def test_second_differences_are_weighed_by_their_covariance():
    """Also where East and North are correlated: as numpy solves it."""
    laws = [np.array([[2.0, 0.8], [0.8, 1.0]]), np.array([[1.0, -0.2], [-0.2, 3.0]]), np.eye(2)]
    offsets = np.array([[1.0, 2.0], [-0.5, 0.3], [0.7, -1.1]])
    last = ()
    for i, (offset, law) in enumerate(zip(offsets.tolist(), laws, strict=True)):
        last += (i, *offset, law[0, 0], law[0, 1], law[1, 1])
    level = NoiseLevel()
    level.update([last])
    weights = np.array([1.0, -2.0, 1.0])
    difference = weights @ offsets
    law = sum(weight**2 * one for weight, one in zip(weights, laws, strict=True))
    expected = 0.5 * difference @ np.linalg.solve(law, difference)
    assert np.frombuffer(level._values) == pytest.approx([expected])
