# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes are linked to robots on the water, whatever the latency."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.calibration.tracks import LEAST_BOXES, link


def _boxes(paths, t, shift=0.0):
    """Every robot in every image, in changing order."""
    images = np.repeat(np.arange(len(t)), len(paths))
    rows = [[path(now) + shift * np.array([np.sin(now), 0.0]) for path in paths] for now in t]
    places = np.array([r[:: 1 if i % 2 else -1] for i, r in enumerate(rows)]).reshape(-1, 2)
    truth = np.array(
        [list(range(len(paths)))[:: 1 if i % 2 else -1] for i in range(len(t))]
    ).ravel()
    return images, places, truth


def test_two_robots_that_pass_keep_apart_while_the_map_sways() -> None:
    """A wrong latency sways all places alike, by metres."""
    t = 0.5 * np.arange(30)
    paths = [lambda s: np.array([0.3 * s, 0.0]), lambda s: np.array([4.0 - 0.3 * s, 3.0])]
    for shift in (0.0, 2.0):
        images, places, truth = _boxes(paths, t, shift)
        count = len(images)
        found = link(t, images, places, np.full(count, 20.0), np.zeros(count, dtype=np.intp), 1.5)
        assert set(zip(found, truth, strict=True)) in ({(0, 0), (1, 1)}, {(0, 1), (1, 0)})


def test_classes_gaps_and_single_boxes() -> None:
    t = np.arange(2.0 * LEAST_BOXES)
    t[LEAST_BOXES:] += 20.0  # too long to be the same robot for sure
    places = np.zeros((len(t), 2))
    images = np.arange(len(t))
    kinds = np.zeros(len(t), dtype=np.intp)
    found = link(t, images, places, np.full(len(t), 20.0), kinds, 1.5)
    assert found.tolist() == [0] * LEAST_BOXES + [1] * LEAST_BOXES
    kinds[::2] = 1  # two classes, each seen too seldom
    assert set(link(t, images, places, np.full(len(t), 20.0), kinds, 1.5)) == {-1}
    places[3] = np.nan
    assert link(t, images, places, np.full(len(t), 20.0), 0 * kinds, 1.5)[3] == -1
