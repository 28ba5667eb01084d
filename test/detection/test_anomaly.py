# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Things on made-up water and on recorded water; the distance by its definition."""

from __future__ import annotations

import csv
from collections import defaultdict

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.anomaly import TUNING, AnomalyDetector, squared_distances
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.select import load_detector


def detector(**values):
    return load_detector(detector_config({"model": "anomaly", **values}))


def water(width=900, height=600, seed=1):
    """Dark green water that is brighter on the left, with waves of a few pixels."""
    rng = np.random.default_rng(seed)
    waves = cv2.blur(rng.normal(0, 24, (height, width, 1)).astype(np.float32), (5, 5))[..., None]
    slope = np.linspace(40, 0, width)[None, :, None]
    noise = rng.normal(0, 2, (height, width, 3))
    return np.clip(np.array([60, 80, 50]) + slope + waves + noise, 0, 255).astype(np.uint8)


def test_the_distance_is_that_from_the_ring():
    rng = np.random.default_rng(4)
    colours = rng.normal(100, 5, (80, 90, 3)).astype(np.float32)
    colours[40, 45] += (6, -9, 3)
    outer, inner = TUNING.ring_px // 2, TUNING.guard_px // 2
    ring = np.ones((2 * outer + 1,) * 2, dtype=bool)
    ring[outer - inner : outer + inner + 1, outer - inner : outer + inner + 1] = False
    around = colours[40 - outer : 41 + outer, 45 - outer : 46 + outer][ring].astype(float)
    spread = np.cov(around.T, bias=True) + TUNING.floor * np.eye(3)
    away = colours[40, 45] - around.mean(axis=0)
    expected = away @ np.linalg.solve(spread, away)
    assert squared_distances(colours)[40, 45] == pytest.approx(expected, rel=0.01)


THINGS = [(300, 200, 24, 24), (600, 400, 60, 20), (120, 480, 14, 30), (700, 100, 110, 60)]


@pytest.mark.parametrize("colour", [(40, 140, 250), (200, 200, 200), (30, 25, 20)])
def test_finds_things_of_any_colour_and_size_where_they_are(colour):
    image = water()
    for x, y, width, height in THINGS:
        cv2.rectangle(image, (x, y), (x + width - 1, y + height - 1), colour, -1)
    found = detector().detect(image)
    assert set(found.names) == {"object"}
    corners = found.xyxy[:, :] + 0.5
    for x, y, width, height in THINGS:
        errors = np.abs(corners - (x, y, x + width, y + height)).max(axis=1)
        assert errors.min() < 0.25 * max(width, height) + 6
    assert len(found) == len(THINGS)


def test_finds_nothing_on_water_alone():
    for seed in range(5):
        assert len(detector().detect(water(seed=seed))) == 0


def test_a_lower_threshold_finds_the_same_and_more():
    image = water()
    cv2.circle(image, (450, 300), 9, (70, 105, 75), -1)
    strict, loose = (detector(score_threshold=score).detect(image) for score in (0.5, 0.05))
    assert len(loose) >= len(strict)
    assert (loose.scores >= 0.05).all()
    assert (np.diff(loose.scores) <= 0.0).all()
    most = detector(score_threshold=0.01, max_detections=2).detect(image)
    assert len(most) == 2


@pytest.mark.parametrize("size", [(64, 48), (15, 400), (1, 1)])
def test_images_of_any_size_are_no_error(size):
    assert len(detector().detect(np.full((size[1], size[0], 3), 90, np.uint8))) == 0


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"search.mode": "tiles"}, "search.mode is tiles, but the model anomaly processes whole"),
        ({"class_names": ["a", "b"]}, "class_names has 2 names, .* knows one class"),
    ],
)
def test_settings_that_it_does_not_have_are_refused(values, sentence):
    with pytest.raises(ConfigError, match=sentence):
        detector(**values)


def test_its_class_can_be_named():
    config = detector_config({"model": "anomaly", "class_names": ["buoy"]})
    assert AnomalyDetector(config).class_names == ("buoy",)


def test_swimmers_in_recorded_images(shared_data):
    folder = shared_data / "real_water" / "northsea_video"
    if not folder.is_dir():
        pytest.skip("needs the photographs northsea_video")
    labels = defaultdict(list)
    with (folder / "labels.csv").open() as stream:
        for row in csv.DictReader(stream):
            box = [float(row[key]) for key in ("x_px", "y_px", "width_box_px", "height_box_px")]
            labels[row["file_name"]].append(box)
    names = sorted(labels)[31::6]  # the first half was looked at while this was made
    finder, found, false = detector(), 0, 0
    for name in names:
        things = np.array(labels[name])
        boxes = finder.detect(cv2.imread(str(folder / "images" / name)))
        middles = boxes.xywh[:, None, :2]
        inside = ((middles >= things[:, :2]) & (middles <= things[:, :2] + things[:, 2:])).all(2)
        found += int(inside.any(axis=0).sum())
        false += int((~inside.any(axis=1)).sum())
    total = sum(len(labels[name]) for name in names)
    assert found >= 0.95 * total
    assert false <= 4 * len(names)
