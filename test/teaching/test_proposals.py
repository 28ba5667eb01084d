# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The colours of an object, and how much round it is no water."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.teaching.proposals import clutter, likeness, looks, strength
from aerial_gnss_ros.teaching.tracks import TUNING

ROBOT = np.array([160.0, 120.0, 40.0, 24.0])


@pytest.fixture(name="water")
def _water():
    rng = np.random.default_rng(1)
    noise = cv2.GaussianBlur(rng.normal(0.0, 12.0, (240, 320)), (0, 0), 1.5)[..., None]
    return np.clip(np.array([110.0, 120.0, 70.0]) + noise, 0, 255).astype(np.uint8)


def _draw(image, box, colour):
    low, high = box[:2] - box[2:] / 2, box[:2] + box[2:] / 2 - 1
    cv2.rectangle(image, low.astype(int).tolist(), high.astype(int).tolist(), colour, -1)
    return image


def test_colours_tell_robots_apart_wherever_they_are(water):
    places = ROBOT + np.array([[0, 0, 0, 0], [-90, 50, 0, 0], [80, -60, 0, 0]])
    for box, colour in zip(places, [(40, 210, 230), (40, 210, 230), (40, 40, 200)], strict=True):
        _draw(water, box, colour)
    yellow, same, red = looks(water, places)
    alike = likeness(yellow, np.array([same, red]))
    assert alike[0] > 0.95
    assert alike[1] < 0.75


def test_glint_round_a_robot_is_clutter_and_calm_water_is_not(water):
    _draw(water, ROBOT, (235, 235, 235))
    assert clutter(water, ROBOT) < 0.05
    rng = np.random.default_rng(3)
    for place in rng.uniform((100, 70), (220, 170), (120, 2)):
        _draw(water, np.array([*place, 6.0, 5.0]), (240, 240, 240))
    assert clutter(water, ROBOT) > TUNING.clutter


def test_a_robot_is_far_stronger_than_ripples(water):
    _draw(water, ROBOT, (40, 210, 230))
    assert strength(water, np.array([60.0, 60.0, 30.0, 30.0])) < 51.0
    assert strength(water, ROBOT) > 500.0
