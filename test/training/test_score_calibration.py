# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores become frequencies: of boxes drawn with known chances, and of a detector's own."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.score_calibration import boxes_of, calibration, main

sys.path.insert(0, str(Path(__file__).parent))

from scored import ROBOT, Fixed, truth

SHIPPED = Path(__file__).parents[2] / "models/aqua_small.onnx"


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (4.0, -1.0), (0.5, 2.0)])
def test_it_is_found_from_boxes_that_were_drawn_with_it(scale, shift):
    rng = np.random.default_rng(7)
    odds = rng.normal(0.0, 1.0, 40_000)
    right = rng.random(len(odds)) < 1.0 / (1.0 + np.exp(-(scale * odds + shift)))
    made = calibration(odds, right)
    assert made.scale == pytest.approx(scale, rel=0.06)
    assert made.shift == pytest.approx(shift, abs=0.06)


def test_boxes_that_part_clearly_give_a_finite_scale():
    made = calibration(np.array([-2.0, -1.9, -1.8, 1.8, 1.9, 2.0]), np.arange(6) > 2)
    assert 0.5 < made.scale < 3.0
    assert made.shift == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("right", [np.ones(5, bool), np.zeros(5, bool), np.zeros(0, bool)])
def test_boxes_of_one_kind_are_refused(right):
    with pytest.raises(InputError, match="some are wrong"):
        calibration(np.linspace(-1.0, 1.0, len(right)), right)


def test_a_box_on_a_robot_that_does_not_count_is_neither_right_nor_wrong():
    robots = truth(ROBOT, (200, 0, 240, 20, 0.0))  # `Fixed` finds another one besides
    odds, right = boxes_of(Fixed(), [LabelledImage("one", robots, lambda: None)])
    np.testing.assert_allclose(odds, np.log([0.72 / 0.28, 0.21 / 0.79]))
    assert right.tolist() == [True, False]


@pytest.mark.ultralytics
def test_the_file_has_the_scores_and_the_boxes_stay(tmp_path, monkeypatch):
    pytest.importorskip("torch", reason="needs torch, of the extra [ultralytics]")
    from aerial_gnss_ros.training import score_calibration
    from aerial_gnss_ros.training.score_calibration import Calibration

    known = Calibration(0.5, -1.0)
    monkeypatch.setattr(score_calibration, "calibration", lambda *_boxes: known)
    monkeypatch.setattr(score_calibration, "images_of", lambda _folders: [])
    file = tmp_path / "mine.onnx"
    assert main([str(SHIPPED), "anywhere", "-o", str(file)]) == 0
    image = np.random.default_rng(2).integers(0, 255, (64, 64, 3), np.uint8)
    plain, made = (
        load_detector(
            DetectorConfig(
                model=str(one), backend="onnxruntime", score_threshold=1e-6, second_look="off"
            )
        ).detect(image)
        for one in (_uncalibrated(tmp_path), file)
    )
    np.testing.assert_allclose(made.xywh, plain.xywh, atol=1e-3)
    odds = np.log(plain.scores / (1.0 - plain.scores))
    np.testing.assert_allclose(np.log(made.scores / (1 - made.scores)), 0.5 * odds - 1, atol=1e-3)


def _uncalibrated(folder):
    from aerial_gnss_ros.training.small_network import names_of, read, write

    file = folder / "plain.onnx"
    assert names_of(SHIPPED) == ("aqua",)
    write(read(SHIPPED, 1), ("aqua",), file)
    return file


def test_what_is_no_small_detector_is_refused(tmp_path, capsys):
    pytest.importorskip("torch", reason="needs torch, of the extra [ultralytics]")
    other = SHIPPED.with_name("aqua_yolo11n.onnx")
    assert main([str(other), str(tmp_path), "-o", str(tmp_path / "x.onnx")]) == 2
    assert "is not a small detector" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.onnx"))
