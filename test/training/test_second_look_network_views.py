# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Views are varied as stated: turned with their traits, sharper and softer, other scores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.proposals import Proposals

pytestmark = pytest.mark.ultralytics
torch = pytest.importorskip("torch", reason="needs the extra [training]")
COUNT = 400


def proposals():
    """Boxes half bright and half dark, twice as wide as tall, half of them sure."""
    views = np.full((COUNT, 80, 80, 6), 90, np.uint8)
    views[:, :, 40:] = 150
    traits = np.tile(np.float32([0.0, 0.0, 0.7]), (COUNT, 1))
    traits[::2, 0] = 3.0
    return Proposals(views, traits, np.full(COUNT, 0.5), np.ones(COUNT, bool), np.ones(COUNT))


def made(variation):
    from aerial_gnss_ros.training.second_look_network_views import varied

    rng = np.random.default_rng(3)
    torch.manual_seed(3)
    return varied(proposals(), np.arange(COUNT), Terms(), rng, variation)


@pytest.fixture
def plain():
    from aerial_gnss_ros.training.second_look_network_views import Variation

    return Variation(greyed=0.0, exchanged=0.0, sharpened=0.0, unsure=0.0)


def test_upright_views_have_upright_traits(plain):
    seen, traits = made(plain)
    views = seen.numpy()
    across = np.abs(views[:, 0, :, 48:].mean((1, 2)) - views[:, 0, :, :16].mean((1, 2)))
    along = np.abs(views[:, 0, 48:].mean((1, 2)) - views[:, 0, :16].mean((1, 2)))
    np.testing.assert_array_equal(across > along, traits[:, 2].numpy() > 0.0)
    assert 0.35 < float((traits[:, 2] > 0).float().mean()) < 0.65


def steepness(seen):
    """Return the greatest step between neighbouring pixels of each view, by its whole step."""
    values = seen.numpy()[:, :3].mean(1)
    steps = np.abs(np.diff(values, axis=1)).mean(2), np.abs(np.diff(values, axis=2)).mean(1)
    steps = np.abs(np.diff(values, axis=1)).mean(2), np.abs(np.diff(values, axis=2)).mean(1)
    step = np.maximum(*(one.max(1) for one in steps))
    return step / np.ptp(np.quantile(values.reshape(COUNT, -1), [0.1, 0.9], axis=1), axis=0)


def test_some_views_are_sharper_and_some_softer(plain):
    before = steepness(made(plain)[0])
    after = steepness(made(replace(plain, sharpened=1.0))[0])
    assert np.quantile(after, 0.9) > 1.3 * np.quantile(before, 0.9)
    assert np.quantile(after, 0.1) < 0.92 * np.quantile(before, 0.1)
    half = steepness(made(replace(plain, sharpened=0.5))[0])
    assert np.quantile(before, 0.9) < np.quantile(half, 0.9) <= np.quantile(after, 0.9)


def test_some_views_have_the_score_of_another_box_and_their_own_shape(plain):
    sure = np.arange(COUNT) % 2 == 0
    for share in (0.0, 0.5):
        _, traits = made(replace(plain, unsure=share))
        told = traits[:, 0].numpy() > 1.5
        assert np.mean(told != sure) == pytest.approx(share / 2, abs=0.06 if share else 0.02)
        np.testing.assert_allclose(np.abs(traits[:, 2].numpy()), 0.7, rtol=1e-6)
