# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A model card states data, parameters and scores."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from aerial_gnss_ros.training.held_out import held_out_images, held_out_split
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.model_card import Card, as_markdown, count_split
from aerial_gnss_ros.training.phases import Phase
from aerial_gnss_ros.training.run_folder import Plan
from aerial_gnss_ros.training.score import Score

PLAN = Plan(
    Path("/somewhere/set/data.yaml"), "abc", False, (Phase("single", 3), Phase("several", 2)),
    "yolo11n.yaml", image_size=64, threads=2,
)  # fmt: skip


def test_the_card_tells_data_parameters_and_scores(tmp_path, make_set):
    found = inspect(open_dataset(make_set(tmp_path / "set", classes=("red", "blue"))))
    split = held_out_split(found)
    images = list(held_out_images(found, split))
    assert split == "val"
    np.testing.assert_allclose(images[0].truth.corners[0, 0::2], [23.5, 40.5])  # disc of 17 px
    scores = {
        **Score().as_dict(), "split": split, "map50": 0.5, "map50_95": None, "score_threshold": 0.4,
        "best_f1": 0.9, "best_score_threshold": 0.35,
    }  # fmt: skip
    counts = {name: count_split(found, name) for name in found.examples}
    assert counts["train"].images == 4
    assert sum(counts["train"].robots.values()) == 7
    assert (counts["train"].empty, counts["train"].several) == (0, 2)
    rows = [{"phase": "1", "epoch": "1"}]
    text = as_markdown(Card(PLAN, ("red", "blue"), counts, scores, {"torch": "9"}, rows))
    for words in (
        "red, blue", "`abc`", "1 of 3 epochs on images with one robot", "| seed | 0 |", "torch 9",
        "| mAP50-95 | none |", "| mAP50 | 0.500 |", "a little too good",
        "| at score_threshold | 0.35 |", "AGPL-3.0", "from scratch",
    ):  # fmt: skip
        assert words in text, words
    assert str(tmp_path) not in text
