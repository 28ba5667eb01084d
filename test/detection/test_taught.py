# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A taught detector: classes and tight boxes of what stands out; networks of another purpose."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection import taught
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.taught import TERMS, Proposer, TaughtDetector
from aerial_gnss_ros.detection.yolo import iou

pytest.importorskip("onnx", reason="onnx builds the test's models; pip install '.[test]'")
_HERE = Path(__file__)
class_look = runpy.run_path(str(_HERE.with_name("class_look.py")))["class_look"]
brightness_look = runpy.run_path(str(_HERE.with_name("brightness_look.py")))["brightness_look"]
white_box_model = runpy.run_path(str(_HERE.with_name("synthetic_model.py")))["white_box_model"]
ROBOTS = replace(TERMS, class_names=("sub", "boat"))
BLUE, RED, DARK = (250, 40, 40), (40, 40, 230), (20, 20, 20)


@pytest.fixture(name="image")
def _image():
    """Water with a blue, a red and a dark box: left, top, width, height."""
    noise = np.random.default_rng(2).normal(0.0, 3.0, (480, 640, 3))
    image = np.clip(np.array([110.0, 120.0, 90.0]) + noise, 0, 255).astype(np.uint8)
    for (left, top), colour in (((100, 80), BLUE), ((400, 300), RED), ((250, 200), DARK)):
        cv2.rectangle(image, (left, top), (left + 39, top + 19), colour, -1)
    return image


def _config(path: Path, **other: object) -> DetectorConfig:
    return DetectorConfig(model="anomaly", second_look=str(path), **other)


def test_it_names_what_it_was_taught_in_tight_boxes(tmp_path, image):
    detector = load_detector(_config(class_look(tmp_path / "mine.onnx", ROBOTS)))
    assert isinstance(detector, TaughtDetector)
    assert detector.class_names == ("sub", "boat")
    found = detector.detect(image)
    assert found.names == ("sub", "boat")  # the blue one has the better score
    np.testing.assert_allclose(found.scores, [(250 / 255) ** 2, (230 / 255) ** 2], atol=0.02)
    np.testing.assert_allclose(found.xyxy[0], [99.5, 79.5, 139.5, 99.5], atol=1.5)
    np.testing.assert_allclose(found.xyxy[1], [399.5, 299.5, 439.5, 319.5], atol=1.5)
    strict = load_detector(_config(tmp_path / "mine.onnx", score_threshold=0.9))
    assert strict.detect(image).names == ("sub",)
    few = load_detector(_config(tmp_path / "mine.onnx", max_detections=1))
    assert few.detect(image).names == ("sub",)
    assert len(detector.detect(np.full((300, 400, 3), 90, np.uint8))) == 0


def test_names_may_be_given_as_many_as_it_knows(tmp_path, image):
    path = class_look(tmp_path / "mine.onnx", ROBOTS)
    named = load_detector(_config(path, class_names=("a", "b")))
    assert named.detect(image).names == ("a", "b")
    with pytest.raises(ConfigError, match=r"has 1 names, but mine.onnx knows 2 classes \(sub, bo"):
        load_detector(_config(path, class_names=("a",)))


def test_networks_of_another_purpose_are_refused(tmp_path):
    plain = brightness_look(tmp_path / "plain.onnx", Terms())
    with pytest.raises(ModelError, match=r"plain.onnx rescores boxes of another detector"):
        load_detector(_config(plain))
    path = class_look(tmp_path / "mine.onnx", ROBOTS)
    model = str(white_box_model(tmp_path / "m.onnx"))
    other = DetectorConfig(model=model, backend="onnxruntime", second_look=str(path))
    with pytest.raises(
        ModelError, match=r"was taught with the model anomaly.*set model to anomaly"
    ):
        load_detector(other)
    with pytest.raises(ConfigError, match=r"search.mode is tiles"):
        load_detector(detector_config({
            "model": "anomaly", "second_look": str(path), "search": {"mode": "tiles"},
        }))  # fmt: skip
    three = class_look(tmp_path / "3.onnx", replace(TERMS, class_names=("a", "b", "c")))
    with pytest.raises(ModelError, match=r"scores of the shape \(1, 2\) for 1 boxes and 3 classes"):
        load_detector(_config(three))


def test_a_robot_of_which_a_part_stands_out_most_is_a_proposal_as_a_whole():
    """The outline round a part of a hull ends where what was searched ends; the next one has it."""
    image = np.full((300, 400, 3), (110, 120, 90), np.uint8)
    cv2.rectangle(image, (100, 100), (159, 119), DARK, -1)
    part = Detections(np.array([[111.5, 109.5, 24.0, 20.0]]), np.ones(1), np.zeros(1, int), ("x",))
    proposer = Proposer(TERMS)
    proposer._anomaly = SimpleNamespace(detect=lambda _image: part)
    found = proposer.detect(image)
    shared = iou(np.array([[99.5, 99.5, 159.5, 119.5]]), found.xyxy)[0]
    assert len(found) == 2
    assert shared.max() > 0.95
    assert shared.min() < 0.7


def test_bright_ends_of_a_dark_robot_are_a_proposal_together(image):
    """Of the water's colour between them; things farther apart than they are long are not."""
    cv2.rectangle(image, (100, 400), (119, 412), BLUE, -1)
    cv2.rectangle(image, (150, 404), (169, 416), RED, -1)
    found = Proposer(TERMS).detect(image)
    plain = Proposer(replace(TERMS, parts=False)).detect(image)
    assert iou(np.array([[99.5, 399.5, 169.5, 416.5]]), plain.xyxy).max() < 0.5
    shared = iou(np.array([[99.5, 399.5, 169.5, 416.5], [399.5, 79.5, 439.5, 99.5]]), found.xyxy)
    assert shared[0].max() > 0.9
    assert (found.xywh[:, 2:].max(axis=1) < 100.0).all()
    assert taught._pairs(np.zeros((0, 4))) == []
    ends = np.array([[10.0, 10.0, 20.0, 10.0], [50.0, 10.0, 20.0, 10.0], [59.0, 10.0, 9.0, 9.0]])
    pairs = [(i, j) for i, j, _ in taught._pairs(ends)]
    assert pairs == [(0, 1), (0, 2)]  # one in another is no pair


def test_of_boxes_of_one_robot_the_best_is_reported():
    """A part in a whole, or the whole round a part, is no second robot; a neighbour is."""
    corners = np.array([[0, 0, 60, 30], [40, 5, 58, 25], [-20, -20, 70, 50], [62, 0, 120, 30]])
    assert taught._distinct(corners.astype(float)) == [0, 3]
    assert taught._distinct(corners[[1, 0]].astype(float)) == [0]
