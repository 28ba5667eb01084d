# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The benchmark of default parameters covers all levels alike, and flies what its cells say."""

from __future__ import annotations

import math
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import told_nothing
from families import truth

CELL = told_nothing.Cell("orbit", 30.0, "reference", "mixed", 3.0, 300.0, -1.5, 1.0)


def test_each_level_is_in_as_many_cells():
    cells = told_nothing.hypercube(36)
    for name, values in told_nothing.FACTORS.items():
        counts = Counter(getattr(cell, name) for cell in cells)
        assert set(counts.values()) == {36 // len(values)}
    assert len(set(cells)) > 30  # the factors do not go through their levels together


@pytest.fixture(scope="module")
def world():
    return told_nothing.World(CELL, 3, Path("no log"))


def test_only_the_reference_is_stated(world):
    assert {name.split(".")[0] for name in world.stated()} == {"map", "camera", "references"}
    others = told_nothing.World(
        told_nothing.Cell("hover", 30.0, "consumer", "still", 1.0, 300.0, 0.0, 1.0), 3, Path("no")
    )
    assert {name.split(".")[0] for name in others.stated()} == {"map", "camera"}


def test_what_is_stated_besides_is_the_truth(world):
    found = world.stated(told_nothing.ALSO)
    assert found["camera.latency_s"] == -1.5
    assert "camera.find_latency" not in found
    assert found["noise.gimbal_pitch_deg"] == pytest.approx(1.2)
    assert found["tracks.find_moored"] is True


def test_errors_are_scaled_but_for_the_receivers(world):
    assert world.sigmas["gimbal_pitch_deg"] == pytest.approx(1.2)
    assert world.sigmas["gnss_offset_m"] == 1.2
    fix = next(world.made.sensors.fixes())
    assert math.sqrt(fix.covariance[0, 0]) == pytest.approx(1.2, rel=0.01)


def test_boxes_are_as_noisy_as_the_bound_is_told(world):
    assert world.sigmas["box_center_px"] == 6.0
    squares = [
        np.square(one - boxes.centers).sum(axis=1).min()
        for _, boxes, found in world.made.detections()
        for one in found.centers
    ]
    assert math.sqrt(np.mean(squares) / 2.0) == pytest.approx(6.0, rel=0.15)


def test_the_reference_and_two_robots_stay(world):
    path = world.made.swarm.positions(np.linspace(0.0, 60.0, 7))
    moved = np.linalg.norm(np.ptp(path[:, :, :2], axis=1), axis=1)
    assert (moved[:3] == 0.0).all()
    assert moved[3] > 1.0


def test_an_unknown_latency_makes_the_bound_larger(world):
    images = list(world.made.detections())[:12]
    assert images[3][0].t == pytest.approx(3.0 + 1.5)
    true = truth(world.made, images)
    known, unknown = (world.bounds(true, sigma)[-1, 1:, 0, 0] for sigma in (0.0, 1.0))
    assert (unknown > 1.05 * known).all()
    assert (known > 0.0).all()


def test_figures_are_ratios_of_roots_over_flights():
    flight = {
        "cell": CELL.words, "seed": 0, "squares": 16.0, "bound": 4.0, "known": 1.0,
        "published": 64.0, "nees": 12.0, "samples": 3, "wanted": 4, "extra_names": 1, "wrong": 2,
    }  # fmt: skip
    found = told_nothing.figures(CELL, [flight, flight])
    assert (found.ratio, found.known, found.published, found.nees) == (2.0, 4.0, 2.0, 2.0)
    assert (found.positions, found.extra_names, found.wrong) == (0.75, 2, 4)
    empty = dict.fromkeys(flight, 0) | {"wanted": 4}
    assert math.isnan(told_nothing.figures(CELL, [empty]).ratio)
