# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Noise larger than stated is found; what is no white noise is not taken for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.noise_level import NO_INNOVATIONS, NoiseLevel
from aerial_gnss_ros.core.faults.noise_level import TUNING as NOISE_LEVEL

STEP_NS = 100_000_000
VARIANCES = 0.04, 0.01, 0.09
WHITE = 0.13  # all of these
ROOT = np.linalg.cholesky([[0.04, 0.01], [0.01, 0.09]])


def fed(
    level: NoiseLevel, offsets: np.ndarray, uneven: bool = False, white: float = WHITE
) -> NoiseLevel:
    """Let it see offsets (images, robots, 2) of robots, as the stated noise would scale them."""
    stamps = np.arange(len(offsets)) * STEP_NS
    if uneven:
        stamps = np.cumsum(np.where(np.arange(len(offsets)) % 2, STEP_NS, 3 * STEP_NS))
    last = [NO_INNOVATIONS] * offsets.shape[1]
    for stamp_ns, image in zip(stamps.tolist(), (offsets @ ROOT.T).tolist(), strict=True):
        both = zip(last, image, strict=True)
        more = level.level - 1.0  # as the filter's covariances
        expected = [one + more * one * white / WHITE for one in VARIANCES]
        last = [(*before[7:], stamp_ns, *offset, *expected, white) for before, offset in both]
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


def test_leaves_noise_nearly_alone_that_is_as_stated_or_less():
    images = 20 * NOISE_LEVEL.level_images
    for seed, sigma in enumerate((1.0, 1.0, 1.0, 0.3)):
        level = NoiseLevel()
        found = [fed(level, part).level for part in np.split(white(images, 3, sigma, seed), 20)]
        assert np.mean(found) < 1.1
        assert max(found) < 1.4


def test_counts_robots_of_one_image_as_one_since_they_share_the_poses_noise():
    shared = np.repeat(white(NOISE_LEVEL.level_images, 1, 2.5), 6, axis=1)
    alone = fed(NoiseLevel(), shared[:, :1])
    assert fed(NoiseLevel(), shared).unknown == alone.unknown


@pytest.mark.parametrize("share", [1.0, 0.2])
def test_motion_that_nobody_knows_is_no_noise(share):
    """Innovations are as large as expected, and white noise a part of that; then it is larger."""
    stated = share * WHITE
    rest = math.sqrt(1.0 - share) * white(NOISE_LEVEL.level_images, 3, 1.0, 1)
    noise = math.sqrt(share) * white(NOISE_LEVEL.level_images, 3, 1.0, 2)
    assert fed(NoiseLevel(), rest + noise, white=stated).level < 1.5
    found = fed(NoiseLevel(), rest + 3.0 * noise, white=stated).level
    assert found == pytest.approx(9.0, rel=0.5)


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
    noise = white(NOISE_LEVEL.level_images, 3, 1.0)
    alone = fed(NoiseLevel(), noise).level
    found = fed(NoiseLevel(), noise + motion[:, None, None]).level
    assert found == pytest.approx(alone, abs=0.2)


def test_single_images_that_are_wrong_do_not_move_it():
    offsets = white(NOISE_LEVEL.level_images, 3, 2.5)
    clean = fed(NoiseLevel(), offsets).level
    offsets[::15] += 40.0
    assert fed(NoiseLevel(), offsets).level == pytest.approx(clean, rel=0.5)


def test_it_grows_with_the_images_that_tell_it():
    noisy = white(NOISE_LEVEL.level_images, 3, 3.0)
    found = [fed(NoiseLevel(), noisy[:images]).level for images in (2, 4, 8, 16, 100)]
    assert found[0] == 1.0
    assert found[1] < 0.7 * found[-1]
    assert found == sorted(found)
    assert fed(NoiseLevel(), noisy, uneven=True).level == 1.0


def test_is_bounded_and_forgets():
    level = fed(NoiseLevel(), white(NOISE_LEVEL.level_images, 3, 50.0))
    assert 0.9 * NOISE_LEVEL.largest_level < level.level <= NOISE_LEVEL.largest_level
    fed(level, white(NOISE_LEVEL.level_images, 3, 1.0))
    assert level.level < 1.3
    fed(level, white(NOISE_LEVEL.level_images, 3, 2.5))
    level.reset()
    assert level.level == 1.0


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
    assert NoiseLevel().unknown == 2.0  # of Student's t with 4 degrees of freedom
    many = fed(NoiseLevel(), white(NOISE_LEVEL.level_images + 2, 3, 3.0))
    assert many.unknown == pytest.approx(1.0, abs=0.1)


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
        last += (i, *offset, law[0, 0], law[0, 1], law[1, 1], 0.1)
    level = NoiseLevel()
    level.update([last])
    weights = np.array([1.0, -2.0, 1.0])
    difference = weights @ offsets
    law = sum(weight**2 * one for weight, one in zip(weights, laws, strict=True))
    ratio = 0.5 * difference @ np.linalg.solve(law, difference) / math.log(2.0)
    expected = 1.0 + (ratio - 1.0) * np.trace(law) / 0.6
    assert np.frombuffer(level._values) == pytest.approx([expected])
