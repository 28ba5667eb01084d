# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lens models far beyond ordinary lenses: what is monotonic comes back, what is not is refused."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant


def _lenses(rational):
    rng = np.random.default_rng(11)
    reach = np.array([1.0, 1.0, 1e-3, 1e-3, 0.2, 1.0, 1.0, 0.2])
    for _ in range(300):
        coefficients = rng.uniform(-1.0, 1.0, 8) * reach
        if not rational:
            coefficients *= [0.5, 0.3, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0]
        yield BrownConrady(coefficients), rng


@pytest.mark.parametrize("rational", [False, True])
def test_points_inside_the_fold_come_back(rational):
    count = 0
    for lens, rng in _lenses(rational):
        radius = min(0.95 * lens.max_radius, 2.0) * np.sqrt(rng.uniform(0.0, 1.0, 50))
        angle = rng.uniform(0.0, 2.0 * math.pi, 50)
        points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        distorted, jacobian = lens.distort(points)
        kept = lens.monotonic(points, jacobian)
        back, _, valid = lens.undistort(distorted)
        assert valid[kept].all()
        assert back[kept] == pytest.approx(points[kept], abs=1e-6)
        count += int(kept.sum())
    assert count > 14_000


@pytest.mark.parametrize("rational", [False, True])
def test_a_few_points_come_back_as_many_do(rational):
    for lens, rng in itertools.islice(_lenses(rational), 100):
        points = np.vstack([np.zeros(2), rng.uniform(-2.0, 2.0, (30, 2)), [1e3, -1e3]])
        many, few = lens.undistort(points), [lens.undistort(one[None]) for one in points]
        valid = np.concatenate([each[2] for each in few])
        assert (valid == many[2]).all()
        for part in (0, 1):
            both = np.concatenate([each[part] for each in few])
            assert both[valid] == pytest.approx(many[part][valid], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("rational", [False, True])
def test_the_fold_is_where_the_radial_part_stops_growing(rational):
    found = 0
    for lens, _ in _lenses(rational):
        if not 0.1 < lens.max_radius < 3.0:
            continue
        radius = np.linspace(0.0, 1.01 * lens.max_radius, 2000)
        radial = lens._radial(radius**2)
        steps = np.diff(radius * radial)
        first = radius[np.argmax(steps <= 0.0)]
        assert (steps <= 0.0).any()
        assert first == pytest.approx(lens.max_radius, rel=0.002)
        found += 1
    assert found > 50


def test_the_jacobian_is_that_of_finite_differences():
    lens = BrownConrady(np.array([0.5, 0.1, 1e-2, -5e-3, 0.02, 0.6, 0.2, 0.01]))
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (40, 2))
    _, jacobian = lens.distort(points)
    differences = np.stack(
        [
            (lens.distort(points + e)[0] - lens.distort(points - e)[0]) / 2e-6
            for e in np.eye(2) * 1e-6
        ],
        axis=-1,
    )
    assert jacobian == pytest.approx(differences, abs=1e-8)


def test_a_fisheye_comes_back_up_to_its_fold_and_not_beyond():
    rng = np.random.default_rng(5)
    folds = 0
    for _ in range(300):
        lens = Equidistant(rng.uniform(-0.3, 0.3, 4) * [1.0, 0.3, 0.1, 0.03])
        angles = rng.uniform(0.0, 0.99 * lens.max_angle, 50)
        back, _, valid = lens.angle(lens.radius(angles)[0])
        assert valid.all()
        assert back == pytest.approx(angles, abs=1e-7)
        if lens.max_angle < 3.0:
            folds += 1
            top = lens.radius(np.array([lens.max_angle]))[0]
            assert not lens.angle(top * 1.01)[2].any()
    assert folds > 20
