# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that turn harder than stated are noticed; those that obey and moving cameras are not."""

from __future__ import annotations

import math

import numpy as np

from aerial_gnss_ros.core.faults.manoeuvre_noise import ManoeuvreNoise
from aerial_gnss_ros.core.models.motion_model import MotionModel

DT, STATED, BOX_M = 0.1, 0.05, 0.03


def followed(paths: np.ndarray, seed: int = 0, told: list[float] | None = None) -> list[np.ndarray]:
    """Return the strengths (n,) after each image of robots on paths (images, n, 2).

    By how much one of them was too small is added to `told`.

    A plain filter of place and velocity, the same for both axes, takes boxes with noise `BOX_M`.
    """
    boxes = paths + BOX_M * np.random.default_rng(seed).standard_normal(paths.shape)
    n = paths.shape[1]
    found = ManoeuvreNoise()
    found.add(n)
    motion, state = MotionModel(STATED, 0.75), np.zeros((n, 2, 2))  # robot; place, velocity; axis
    spread = np.tile(np.diag([100.0, 0.56]), (n, 1, 1))
    step = np.array([[1.0, DT], [0.0, 1.0]])
    strengths = []
    for seen in boxes:
        found.predict(DT, STATED**2)
        noise = motion.step(DT, np.zeros(n), found.strength)[2]
        state = step @ state
        spread = step @ spread @ step.T + noise[:, [0, 1, 1, 2]].reshape(n, 2, 2)
        gain = spread[:, :, 0] / (spread[:, 0, 0] + BOX_M**2)[:, None]
        change = gain[:, :, None] * (seen - state[:, 0])[:, None, :]
        less = gain[:, :, None] * spread[:, None, 0, :]
        state, spread = state + change, spread - less
        found.update(np.arange(n), change[:, 1], 2.0 * less[:, 1, 1])
        strengths.append(found.strength.copy())
        if told is not None:
            told.append(found.take_underestimated())
    return strengths


def circles(radius_m: float, speed_mps: float, images: int, phases: list[float]) -> np.ndarray:
    angle = np.arange(images)[:, None] * DT * speed_mps / radius_m + phases
    return radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_robots_that_obey_are_left_alone():
    rng = np.random.default_rng(1)
    velocity = np.cumsum(STATED * math.sqrt(DT) * rng.standard_normal((600, 100, 2)), axis=0)
    strengths = np.array(followed(np.cumsum(velocity * DT, axis=0)))
    assert (strengths > 1.0).mean() < 0.01
    assert strengths.mean() < 1.02


def test_a_robot_that_circles_is_noticed_within_seconds():
    """0.5 m/s on 1 m: 0.25 m/s² all the time, and 0.75 m/s in 3 s where 0.09 m/s are stated."""
    strengths = np.array(followed(circles(1.0, 0.5, 300, [0.0])))[:, 0]
    assert (strengths[100:] > 1.0).all()
    # A sum that fades over 3 s, of corrections that turn at 0.5 rad/s: a² / (1/3² + 0.5²), by
    # what is stated, 2 q 3 s / 2. The filter overshoots somewhat.
    expected = 0.25**2 / (3.0**-2 + 0.5**2) / (STATED**2 * 3.0)
    assert expected < strengths[-1] < 2.0 * expected


def test_a_mean_strength_that_was_too_small_is_told_once():
    paths = np.concatenate([circles(1.0, 0.5, 300, [0.0]), np.zeros((300, 2, 2))], axis=1)
    factors: list[float] = []
    means = np.mean(followed(paths, told=factors), axis=1)
    np.testing.assert_allclose(factors, np.maximum(means / np.append(1.0, means[:-1]), 1.0))
    assert math.prod(factors) > 3.0


def test_what_all_robots_seem_to_do_is_the_cameras():
    paths = np.repeat(circles(1.0, 0.5, 300, [0.0]), 3, axis=1)
    assert (np.array(followed(paths)) == 1.0).all()


def test_a_robot_that_turned_out_to_be_another_keeps_its_strength():
    found = ManoeuvreNoise()
    found.add(3)
    found.strength[:] = 1.0, 5.0, 1.0
    found.inherit(1, 2)
    found.drop(np.array([True, False, True]))
    assert found.strength.tolist() == [1.0, 5.0]


def test_a_robot_that_is_copied_from_another_block_brings_its_strength():
    source, target = ManoeuvreNoise(), ManoeuvreNoise()
    source.add(3)
    target.add(3)
    source.strength[:] = [2.0, 3.0, 4.0]
    source._sums[:] = np.arange(3.0)
    target.copy(source, 1)
    assert target.strength.tolist() == [1.0, 1.0, 3.0]
    assert target._sums[0].tolist() == [0.0, 0.0, 1.0]
