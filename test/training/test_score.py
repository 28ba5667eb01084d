# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Counting right and wrong boxes, on images that can be counted by hand."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import within_image
from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_folder
from aerial_gnss_ros.training.score import Score, main, match, report, score, sweep, sweep_report

sys.path.insert(0, str(Path(__file__).parent))

from scored import ROBOT, Fixed, found, truth

FAINT = (100.0, 0.0, 140.0, 20.0, 0.0)


@pytest.mark.parametrize(
    ("boxes", "robots", "expected"),
    [
        ([(0, 0, 40, 20, 0.9)], [ROBOT], (1, 0)),
        ([(0, 0, 40, 20, 0.9), (1, 0, 41, 20, 0.8)], [ROBOT], (1, 1)),  # found twice
        ([(0, 0, 40, 41, 0.9)], [ROBOT], (0, 1)),  # IoU 0.488
        ([(0, 0, 40, 39, 0.9)], [ROBOT], (1, 0)),  # IoU 0.513
        ([], [ROBOT], (0, 0)),
        ([(200, 0, 240, 20, 0.9)], [ROBOT], (0, 1)),
        ([(100, 0, 140, 20, 0.9)], [ROBOT, FAINT], (0, 0)),  # neither right nor wrong
        ([(110, 5, 130, 15, 0.9)], [ROBOT, FAINT], (0, 0)),  # its middle lies in one of those
        ([(0, 0, 40, 20, 0.3), (0, 0, 40, 20, 0.9)], [ROBOT], (1, 1)),
    ],
)
def test_right_and_wrong_boxes(boxes, robots, expected):
    matched = match(found(*boxes), truth(*robots))
    assert (int((matched.robot >= 0).sum()), int((matched.robot == -1).sum())) == expected


def test_the_surer_box_takes_the_robot():
    matched = match(found((0, 0, 40, 20, 0.3), (1, 0, 41, 20, 0.9)), truth(ROBOT))
    assert matched.robot.tolist() == [-1, 0]


def test_figures_of_two_images():
    result = Score()
    result.add(found((3, 4, 43, 24, 0.9), (300, 300, 310, 310, 0.5)), truth(ROBOT, FAINT))
    result.add(found(), truth((0, 0, 90, 50, 1)))
    figures = result.as_dict()
    assert figures["overall"] == {"robots": 2, "found": 1, "false": 1}
    assert (figures["precision"], figures["recall"]) == (0.5, 0.5)
    assert figures["centre_error_median_px"] == pytest.approx(5.0)
    np.testing.assert_allclose(figures["centre_offset_px"], [3, 4])
    sizes = figures["by_long_side_px"]
    assert sizes["0 to 16"] == {"robots": 0, "found": 0, "false": 1}
    assert sizes["40 to 80"] == {"robots": 1, "found": 1, "false": 0}
    assert sizes["80 to 160"] == {"robots": 1, "found": 0, "false": 0}
    assert "precision 0.500, recall 0.500" in report(result)


class Oracle:
    """Finds exactly what the labels say, through the edges that networks count from."""

    name, class_names = "oracle", ("aqua",)

    def __init__(self, truths: list[Truth]):
        self._truths = iter(truths)

    def detect(self, image):
        corners = next(self._truths).corners + 0.5
        count, size = len(corners), (image.shape[1], image.shape[0])
        return within_image(corners, np.ones(count), np.zeros(count), self.class_names, size)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rendered") / "set"
    generate(folder, DatasetConfig({"test": 4}, size=(160, 160), seed=5, occupied=1.0))
    return folder


def test_a_perfect_detector_scores_perfectly_on_rendered_images(rendered):
    images = list(read_folder(rendered, "test"))
    result = score(Oracle([image.truth for image in images]), images)
    assert result.images == 4
    assert result.overall.robots > 0
    assert (result.overall.precision, result.overall.recall) == (1.0, 1.0)
    assert result.as_dict()["centre_error_p95_px"] == pytest.approx(0.0, abs=1e-9)


def test_labels_and_meta_agree(rendered):
    """The two files count pixels differently; read, they must say the same."""
    with_meta = {image.name: image.truth for image in read_folder(rendered, "test")}
    (rendered / "meta.csv").rename(rendered / "meta.hidden")
    try:
        plain = {image.name: image.truth for image in read_folder(rendered, "test")}
    finally:
        (rendered / "meta.hidden").rename(rendered / "meta.csv")
    assert plain.keys() == with_meta.keys()
    for name, labels in plain.items():
        # meta.csv is rounded to 0.01 px; with pruning every robot in it is labelled.
        np.testing.assert_allclose(labels.corners, with_meta[name].corners, atol=0.011)


def test_what_cannot_be_scored_is_said(tmp_path, capsys):
    with pytest.raises(InputError, match="has no images"):
        list(read_folder(tmp_path, "test"))
    (tmp_path / "images" / "test").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "images" / "test" / "a.png"), np.zeros((8, 8, 3), np.uint8))
    (tmp_path / "labels" / "test").mkdir(parents=True)
    (tmp_path / "labels" / "test" / "a.txt").write_text("0 0.5 0.5\n")
    with pytest.raises(InputError, match="class x y width height"):
        list(read_folder(tmp_path, "test"))
    assert main([str(tmp_path / "none.onnx"), str(tmp_path)]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_figures_for_a_machine(rendered, capsys, monkeypatch):
    images = list(read_folder(rendered, "test"))
    monkeypatch.setattr(
        "aerial_gnss_ros.training.score.load_detector",
        lambda _: Oracle([image.truth for image in images]),
    )
    assert main(["any.onnx", str(rendered), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recall"] == 1.0


def test_a_sweep_counts_the_boxes_above_each_threshold():
    image = LabelledImage("a", truth(ROBOT, (200, 0, 240, 20, 1)), lambda: np.zeros((9, 9, 3)))
    results = sweep(Fixed(), [image])
    counts = {t: (r.overall.found, r.overall.false) for t, r in results.items()}
    assert counts[0.2] == (2, 1)
    assert counts[0.3] == (2, 0)
    assert counts[0.35] == (1, 0)
    assert counts[0.75] == (0, 0)
    assert "| 0.35 | 1.000 | 0.500 | 0.667 |" in sweep_report(results)
