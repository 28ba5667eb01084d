# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data sets with every kind of error: each file is named, and a good one passes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PIL import Image as PillowImage

from aerial_gnss_ros.training.inspection import DatasetError, inspect
from aerial_gnss_ros.training.layout import open_dataset


def problems(folder, **options):
    return [str(problem) for problem in inspect(open_dataset(folder), **options).problems]


def test_a_good_set_has_no_problems(tmp_path, make_set):
    found = inspect(open_dataset(make_set(tmp_path / "images" / "set", classes=("aqua", "boat"))))
    found.refuse_problems()
    assert {split: len(examples) for split, examples in found.examples.items()} == {
        "train": 4,
        "val": 4,
    }
    assert [len(example.boxes) for example in found.examples["train"]] == [1, 2, 1, 3]
    assert found.examples["train"][0].size == (64, 64)


LINES = [
    ("0 0.5 0.5 0.2", "has 4 values"),
    ("0 0.5 0.5 0.2 0.2 0.9", "has 6 values"),
    ("0 0.5 half 0.2 0.2", "is not five numbers"),
    ("0 0.5 nan 0.2 0.2", "is not five numbers"),
    ("1 0.5 0.5 0.2 0.2", "class 1 is not in data.yaml, which has 0"),
    ("-1 0.5 0.5 0.2 0.2", "class -1 is not in"),
    ("0.5 0.5 0.5 0.2 0.2", "class 0.5 is not in"),
    ("0 32 32 9 9", "outside 0 to 1: it may be in pixels"),
    ("0 -0.1 0.5 0.2 0.2", "outside 0 to 1"),
    ("0 0.5 0.5 0 0.2", "is not above 0"),
    ("0 0.5 0.5 1.2 0.2", "is not above 0 and at most 1"),
    ("0 0.95 0.5 0.2 0.2", "reaches beyond the image, from 0.4 to 1.05"),
]


@pytest.mark.parametrize(("line", "expected"), LINES, ids=[line for line, _ in LINES])
def test_a_wrong_line_is_named(tmp_path, make_set, line, expected):
    labels = make_set(tmp_path / "set") / "labels" / "train" / "1.txt"
    with labels.open("a") as file:
        file.write(f"\n{line}\n")
    (said,) = problems(tmp_path / "set")
    assert said.startswith(f"{labels.resolve()}, line 4: ")
    assert expected in said


def test_rounding_at_the_edge_is_no_error(tmp_path, make_set):
    labels = make_set(tmp_path / "set") / "labels" / "train" / "0.txt"
    labels.write_text("0 0.900001 0.5 0.200000 1.0000\n")
    assert problems(tmp_path / "set") == []


def damage(folder):
    """One of everything that can be wrong with files; what must be said of each."""
    train, labels = folder / "images" / "train", folder / "labels" / "train"
    whole = cv2.imencode(".jpg", np.random.default_rng(1).integers(0, 255, (64, 64, 3)))[1]
    (train / "cut.jpg").write_bytes(whole.tobytes()[:-300])
    (labels / "cut.txt").touch()
    (train / "text.png").write_text("no image")
    (labels / "text.txt").touch()
    (train / "zero.jpg").touch()
    (labels / "zero.txt").touch()
    turned = PillowImage.fromarray(np.full((20, 20, 3), 9, np.uint8))
    exif = turned.getexif()
    exif[0x0112] = 6
    turned.save(train / "turned.jpg", exif=exif)
    (labels / "turned.txt").touch()
    cv2.imwrite(str(train / "forgotten.png"), np.full((20, 20, 3), 7, np.uint8))
    (labels / "orphan.txt").write_text("0 0.5 0.5 0.1 0.1\n")
    (labels / "classes.txt").write_text("aqua\n")
    cv2.imwrite(str(train / "0.jpg"), np.full((20, 20, 3), 8, np.uint8))
    twice = (labels / "2.txt").read_text()
    (labels / "2.txt").write_text(twice + twice)
    same = cv2.imread(str(folder / "images" / "val" / "3.png"))
    cv2.imwrite(str(train / "again.png"), same, [cv2.IMWRITE_PNG_COMPRESSION, 0])
    (labels / "again.txt").touch()
    return {
        "images/train/cut.jpg": "cannot be read",
        "images/train/text.png": "it is not an image, despite its name",
        "images/train/zero.jpg": "the file is empty",
        "images/train/turned.jpg": "EXIF orientation 6",
        "images/train/forgotten.png": "has no label file",
        "labels/train/orphan.txt": "its image is missing",
        "images/train/0.png": "shares its label file",
        "labels/train/2.txt, line 2": "occurs twice",
        "images/val/3.png": "the same picture is in train",
    }


def test_every_damaged_file_is_named_once(tmp_path, make_set):
    folder = make_set(tmp_path / "set").resolve()
    expected = damage(folder)
    said = problems(folder)
    for file, words in expected.items():
        assert any(line.startswith(f"{folder / file}: ") and words in line for line in said), file
    assert len(said) == len(expected)
    with pytest.raises(DatasetError, match=r"data set with 9 errors; no work was done:\n  /"):
        inspect(open_dataset(folder)).refuse_problems()


def test_images_without_labels_may_count_as_empty(tmp_path, make_set):
    folder = make_set(tmp_path / "set")
    (folder / "labels" / "val" / "0.txt").unlink()
    assert len(problems(folder)) == 1
    found = inspect(open_dataset(folder), unlabelled_is_empty=True)
    assert not found.problems
    assert len(found.examples["val"][0].boxes) == 0


def test_an_empty_set_and_a_missing_one_are_errors(tmp_path, make_set):
    folder = make_set(tmp_path / "set", robots=())
    assert any("train has no images" in line for line in problems(folder))
    (folder / "data.yaml").write_text("train: images/train\nnames: [a]\n")
    assert any("it has no val" in line for line in problems(folder))
    assert not any("no val" in line for line in problems(folder, needed=("train",)))


def test_the_fingerprint_knows_every_byte_but_not_the_place(tmp_path, make_set):
    def fingerprint(folder):
        return inspect(open_dataset(folder)).fingerprint()

    first = make_set(tmp_path / "first")
    second = make_set(tmp_path / "second")
    assert fingerprint(first) == fingerprint(second)
    labels = second / "labels" / "val" / "3.txt"
    labels.write_text(labels.read_text().replace("0.", "0.0", 1))
    assert fingerprint(first) != fingerprint(second)
