# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small detector: its samples, a training that learns and goes on, and its exported file."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.small import STATE, SmallPlan, fit, main
from aerial_gnss_ros.training.small_samples import Pool, crop_of, draw, maps_of

SIDE = 64


def picture(rng, count=1, size=(160, 128)):
    """Return an image of dark noise with bright robots, and their corners (edges of pixels)."""
    image = rng.integers(20, 70, (size[1], size[0], 3), np.uint8)
    corners = []
    for number in range(count):
        x, y = rng.integers(8, 30, 2) + 20 * number * np.array([3, 1])
        w, h = rng.integers(18, 34, 2)
        image[y : y + h, x : x + w] = (60, 200, 240)
        corners.append((x, y, x + w, y + h))
    return image, np.array(corners, dtype=np.float64)


@pytest.fixture
def pool():
    rng, made = np.random.default_rng(5), Pool()
    for number in range(24):
        image, corners = picture(rng, 1 + number % 2)
        count = len(corners)
        truth = Truth(
            corners - 0.5, np.ones(count, bool), np.ones(count), np.ones(count),
            np.zeros(count, np.int64),
        )  # fmt: skip
        made.add([LabelledImage(str(number), truth, lambda image=image: image)])
    return made


def test_boxes_stay_on_robots_in_varied_crops():
    rng, seen = np.random.default_rng(1), 0
    for _ in range(60):
        image, corners = picture(rng)
        crop, boxes, kinds, partly = crop_of(rng, image, corners, np.zeros(1, np.int64), SIDE)
        bright = (crop[..., 2] > 150).astype(np.uint8)
        if not len(boxes):
            assert bright.sum() == 0 or len(partly)
            continue
        left, top, width, height = cv2.boundingRect(bright)
        wanted = (left, top, left + width, top + height)
        np.testing.assert_allclose(boxes[0], wanted, atol=1.6)
        assert kinds.tolist() == [0]
        seen += 1
    assert seen > 30


def test_a_robot_that_does_not_count_is_neither_a_robot_nor_none():
    rng = np.random.default_rng(2)
    image, corners = picture(rng)
    for _ in range(30):
        _, boxes, _, partly = crop_of(rng, image, corners, np.array([-1]), SIDE)
        assert not len(boxes)
        _, weight, _ = maps_of(boxes, np.zeros(0, int), partly, SIDE, 1)
        assert (weight.min() == 0.0) == bool(len(partly))


def test_the_map_is_1_at_the_centre_and_says_which_box_a_place_belongs_to():
    boxes = np.array([[8.0, 16.0, 24.0, 24.0], [40.0, 32.0, 60.0, 60.0]])
    wanted, _, truth = maps_of(boxes, np.array([0, 1]), np.zeros((0, 4)), SIDE, 2)
    assert wanted.shape == (2, 8, 8)
    assert np.argwhere(wanted[0] == 1.0).tolist() == [[2, 2]]
    assert np.argwhere(wanted[1] == 1.0).tolist() == [[5, 6]]
    assert truth[:, 2, 2].tolist() == [16.0, 20.0, 16.0, 8.0]
    assert truth[:, 5, 6].tolist() == [50.0, 46.0, 20.0, 28.0]
    batch = draw(np.random.default_rng(0), _one(boxes), 3, SIDE, 2)
    assert batch.images.shape == (3, SIDE, SIDE, 3)
    assert batch.truth.shape == (3, 4, 8, 8)


def _one(boxes):
    pool = Pool()
    pool.images, pool.corners = [np.zeros((SIDE, SIDE, 3), np.uint8)], [boxes]
    pool.classes, pool.weights = [np.array([0, 1])], [1.0]
    return pool


@pytest.mark.ultralytics
def test_it_learns_goes_on_and_is_read_as_any_other_detector(tmp_path, pool):
    torch = pytest.importorskip("torch", reason="needs torch, of the extra [ultralytics]")
    plan = SmallPlan(steps=60, side=SIDE, batch=12, learning_rate=0.004, seed=3, threads=1)
    told = []
    fit(pool, plan, tmp_path, ("aqua",), report=lambda *seen: told.append(seen))
    file = fit(
        pool, replace(plan, steps=120), tmp_path, ("aqua",), report=lambda *s: told.append(s)
    )
    assert [step for step, _, _ in told] == [50, 100]  # the second went on from 60
    assert torch.load(tmp_path / STATE, weights_only=True)["step"] == 120
    detector = load_detector(
        DetectorConfig(model=str(file), backend="onnxruntime", threads=1, score_threshold=0.2)
    )
    assert detector.class_names == ("aqua",)
    rng = np.random.default_rng(9)
    image, corners = picture(rng, 2, (192, 160))
    found = detector.detect(image)
    for left, top, right, bottom in corners - 0.5:
        middle = (left + right) / 2, (top + bottom) / 2
        best = np.hypot(*(found.xywh[:, :2] - middle).T).argmin()
        np.testing.assert_allclose(found.xywh[best, :2], middle, atol=3.0)
        np.testing.assert_allclose(found.xywh[best, 2:], (right - left, bottom - top), rtol=0.35)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({}, "--time or --steps"), ({"hours": 1.0, "steps": 5}, "--time or --steps"),
        ({"steps": 5, "side": 100}, "multiple of 32"), ({"steps": 5, "batch": 0}, "--batch"),
    ],
)  # fmt: skip
def test_a_wrong_plan_is_refused(wrong, words):
    with pytest.raises(ConfigError, match=words):
        SmallPlan(**wrong)


def test_wrong_arguments_end_with_a_sentence(tmp_path, capsys):
    folder = str(tmp_path / "none")
    assert main([folder, "-o", str(tmp_path / "run")]) == 2
    assert "--time or --steps" in capsys.readouterr().err
