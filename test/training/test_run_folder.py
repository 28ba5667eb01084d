# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a training remembers, what it shows ultralytics, and what it leaves for people."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.curves import as_csv, draw_curves, read_epochs
from aerial_gnss_ros.training.data_view import write_view
from aerial_gnss_ros.training.held_out import held_out_images, held_out_split
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.model_card import Card, as_markdown, count_split
from aerial_gnss_ros.training.phases import Phase
from aerial_gnss_ros.training.run_folder import Plan, RunFolder
from aerial_gnss_ros.training.score import Score

PLAN = Plan(
    Path("/somewhere/set/data.yaml"), "abc", False, (Phase("single", 3), Phase("several", 2)),
    "yolo11n.yaml", image_size=64, threads=2,
)  # fmt: skip


def test_a_plan_survives_being_saved(tmp_path):
    run = RunFolder(tmp_path)
    run.save(PLAN)
    assert run.load() == PLAN


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (None, "has no plan.json"),
        ("{", "is damaged"),
        ("[]", "is damaged"),
        ('{"format": 99}', "another version"),
        ('{"format": 1, "phases": []}', "is damaged"),
    ],
)
def test_a_folder_that_is_no_training(tmp_path, content, expected):
    if content is not None:
        (tmp_path / "plan.json").write_text(content)
    with pytest.raises(InputError, match=expected):
        RunFolder(tmp_path).load()


def test_one_training_at_a_time(tmp_path):
    with (
        RunFolder(tmp_path).locked(),
        pytest.raises(InputError, match="another process is training"),
        RunFolder(tmp_path).locked(),
    ):
        pass
    with RunFolder(tmp_path).locked():
        pass


def test_the_view_leaves_the_images_alone(tmp_path, make_set):
    folder = make_set(tmp_path / "set")
    odd = folder / "images" / "train" / "odd.jpg"
    encoded = cv2.imencode(".jpg", np.full((32, 32, 3), 99, np.uint8))[1].tobytes()
    odd.write_bytes(encoded + b"a camera's own data")
    (folder / "labels" / "train" / "odd.txt").write_text("0 0.5 0.5000004 0.2 1.000001\n")
    found = inspect(open_dataset(folder))
    file = write_view(tmp_path / "view", found.examples, found.dataset.names)
    view = inspect(open_dataset(file))
    view.refuse_problems()
    assert len(view.examples["train"]) == 5
    shown = {path.name: path for path in (tmp_path / "view" / "images" / "train").iterdir()}
    assert shown["000000_0.png"].is_symlink()
    assert not shown["000004_odd.jpg"].is_symlink()  # ultralytics would save it anew
    labels = tmp_path / "view" / "labels" / "train" / "000004_odd.txt"
    assert labels.read_text() == "0 0.5000000 0.5000004 0.2000000 1.0000000\n"
    write_view(tmp_path / "view", {"val": []}, ["aqua"])  # anew, nothing is left
    assert sorted(path.name for path in (tmp_path / "view" / "images").iterdir()) == ["val"]
    assert odd.read_bytes().endswith(b"own data")


def test_epochs_that_were_repeated_count_once(tmp_path):
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    head = "epoch,train/box_loss,metrics/recall(B)\n"
    first.write_text(head + "1,9.0,0.1\n2,8.0,0.2\n2,7.0,0.3\n3,6.0,0.4\n")
    second.write_text("epoch, train/box_loss\n1, 5.0\n")
    rows = read_epochs([first, second, tmp_path / "none.csv"])
    table = list(csv.DictReader(io.StringIO(as_csv(rows))))
    told = [(row["phase"], row["epoch"], row["train/box_loss"]) for row in table]
    assert told == [("1", "1", "9.0"), ("1", "2", "7.0"), ("1", "3", "6.0"), ("2", "1", "5.0")]
    draw_curves(rows, tmp_path / "curves.png")
    assert cv2.imread(str(tmp_path / "curves.png")) is not None


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


def test_a_split_named_test_is_held_out(tmp_path, make_set):
    found = inspect(open_dataset(make_set(tmp_path / "set", splits=("train", "val", "test"))))
    assert held_out_split(found) == "test"
