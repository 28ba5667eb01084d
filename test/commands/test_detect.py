# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss detect`: the table, the pictures, the score, and what is wrong in a sentence."""

from __future__ import annotations

import csv
import json
import os

import cv2
import numpy as np
import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.commands import detect as command
from aerial_gnss_ros.detection.base import within_image


class Discs:
    """Finds what is red in the data sets of `make_set`; a network would not know discs."""

    name, class_names = "discs", ("aqua",)

    def detect(self, image):
        mask = (image[:, :, 2] > 200).astype(np.uint8)
        _, _, parts, _ = cv2.connectedComponentsWithStats(mask)
        boxes = [(x, y, x + w, y + h) for x, y, w, h, _ in parts[1:]]
        size = (image.shape[1], image.shape[0])
        count = len(boxes)
        return within_image(np.array(boxes), np.full(count, 0.9), np.zeros(count), ("aqua",), size)


@pytest.fixture(name="folder")
def _folder(tmp_path, make_set, monkeypatch):
    """Four images of 1, 2, 1 and 3 discs with labels; discs are what the detector finds."""
    monkeypatch.setattr(command, "load_detector", lambda _config: Discs())
    make_set(tmp_path / "set", splits=("test",))
    return tmp_path / "set"


def run(*args):
    return cli.main(["detect", *map(str, args)])


def test_writes_boxes_and_pictures_and_scores_them(folder, tmp_path, capsys):
    out = tmp_path / "out"
    images, labels = folder / "images" / "test", folder / "labels" / "test"
    assert run(images, "--against", labels, "-o", out) == 0
    text = capsys.readouterr().out
    assert "4 pictures, 7 boxes (aqua 7), 1.75 a picture" in text
    assert "precision 1.000, recall 1.000 (IoU 0.5): 7 of 7 found" in text
    assert "false boxes 0, 0.000 a picture" in text
    with (out / "boxes.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == command.COLUMNS
    for i in range(4):
        lines = (labels / f"{i}.txt").read_text().split("\n")[:-1]
        true = sorted(
            [64 * (u - w / 2), 64 * (v - h / 2), 64 * w, 64 * h]
            for _, u, v, w, h in (map(float, line.split()) for line in lines)
        )
        mine = sorted(
            [float(row[key]) for key in ("x_px", "y_px", "width_px", "height_px")]
            for row in rows
            if row["file_name"] == f"{i}.png"
        )
        assert np.array(mine) == pytest.approx(np.array(true), abs=0.01)
    assert sorted(path.name for path in (out / "pictures").iterdir()) == [
        "0.jpg", "1.jpg", "2.jpg", "3.jpg",
    ]  # fmt: skip


def test_its_own_table_is_a_table_of_labels(folder, tmp_path, capsys):
    images = folder / "images" / "test"
    assert run(images, "-o", tmp_path / "one", "--no-pictures") == 0
    assert not (tmp_path / "one" / "pictures").exists()
    capsys.readouterr()
    table = tmp_path / "one" / "boxes.csv"
    assert run(images, "--against", table, "-o", tmp_path / "two", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["score"]["precision"], summary["score"]["recall"]) == (1.0, 1.0)
    assert (summary["pictures"], summary["boxes"]) == (4, {"aqua": 7})
    with table.open(newline="", encoding="utf-8") as file:
        scores = sorted(float(row["score"]) for row in csv.DictReader(file))
    assert sorted(summary["scores"]["on_robots"]) == pytest.approx(scores, abs=1e-3)
    assert summary["scores"]["false"] == []


def test_says_what_false_boxes_are(folder, tmp_path, capsys):
    images = folder / "images" / "test"
    assert run(images, "-o", tmp_path / "one") == 0
    table = tmp_path / "labels.csv"
    rows = (tmp_path / "one" / "boxes.csv").read_text().splitlines()
    table.write_text("\n".join([rows[0], *(row.replace("aqua", "boat") for row in rows[1:4])]))
    capsys.readouterr()
    assert run(images, "--against", table, "-o", tmp_path / "two") == 0
    text = capsys.readouterr().out
    assert "against labels of 2 pictures:" in text
    assert "false boxes 3, 1.500 a picture" in text
    assert "on boat                      3" in text
    assert "labels of classes that the model does not know: boat 3" in text
    assert "scores of boxes on robots" not in text


def test_labels_of_all_classes_can_count(folder, tmp_path, capsys):
    images, table = folder / "images" / "test", tmp_path / "labels.csv"
    assert run(images, "-o", tmp_path / "one") == 0
    text = (tmp_path / "one" / "boxes.csv").read_text()
    table.write_text(text.replace("aqua", "boat"))
    capsys.readouterr()
    options = ("--any-class", "--iou", "0.9", "--no-pictures")
    assert run(images, "--against", table, *options, "-o", tmp_path / "two") == 0
    assert "recall 1.000 (IoU 0.9): 7 of 7 found" in capsys.readouterr().out


def test_several_inputs_keep_their_names_apart(folder, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    for i in range(2):
        (other / f"{i}.png").write_bytes((folder / "images/test/0.png").read_bytes())
    assert run(folder / "images" / "test", other, "-o", tmp_path / "out") == 0
    with (tmp_path / "out" / "boxes.csv").open() as stream:
        names = {row["file_name"] for row in csv.DictReader(stream)}
    assert {"test/0.png", "other/0.png", "other/1.png"} <= names
    assert (tmp_path / "out" / "pictures" / "other" / "1.jpg").is_file()


def test_labels_of_one_folder_are_not_those_of_another(folder, tmp_path, capsys):
    images, other = folder / "images" / "test", tmp_path / "other"
    other.mkdir()
    cv2.imwrite(str(other / "0.png"), np.full((96, 128, 3), 90, dtype=np.uint8))
    assert run(images, other, "-o", tmp_path / "out") == 0
    capsys.readouterr()
    own = tmp_path / "out" / "boxes.csv"
    assert run(images, other, "--against", own, "-o", tmp_path / "again") == 0
    assert "precision 1.000, recall 1.000" in capsys.readouterr().out
    named = tmp_path / "labels.csv"
    named.write_text(own.read_text().replace("test/", "").replace("other/", ""))
    assert run(images, other, "--against", named, "-o", tmp_path / "both") == 2
    assert "0.png would be the labels of" in capsys.readouterr().err


@pytest.mark.parametrize("inside", [True, False])
def test_a_pipe_is_not_waited_for(folder, tmp_path, capsys, inside):
    pipe = folder / "images" / "test" / "pipe.jpg"
    os.mkfifo(pipe)
    assert run(pipe.parent if inside else pipe, "-o", tmp_path / "out") == (0 if inside else 2)
    said = capsys.readouterr()
    assert ("it is a pipe" in said.out) == inside
    assert ("a device or a pipe, not a file" in said.err) != inside


def test_a_picture_that_cannot_be_read_is_reported_and_left_out(folder, tmp_path, capsys):
    (folder / "images" / "test" / "0.png").write_bytes(b"cut off")
    assert run(folder / "images" / "test", "-o", tmp_path / "out") == 0
    text = capsys.readouterr().out
    assert "3 pictures, 6 boxes" in text
    assert "not read: the image" in text


@pytest.mark.parametrize(
    ("args", "sentence"),
    [
        (["nowhere"], "nowhere does not exist; give images, a folder, a video or a bag."),
        (["{images}", "{images}"], "two inputs have the name test"),
        (["{images}", "--against", "{images}"], "holds no label files"),
        (["{images}", "--against", "{other}"], "has labels of none of these images"),
        (["{damaged}"], "cannot be read"),
        (
            ["{images}", "--against", "{other}", "--iou", "0"],
            "--iou 0 must lie above 0 and at most at 1.",
        ),
        (["{images}", "--any-class"], "--any-class applies only with --against."),
        (["{images}", "--iou", "0.3"], "--iou applies only with --against."),
        (["{images}", "--score", "2"], "score_threshold must lie within"),
    ],
)
def test_wrong_input_leaves_nothing_behind(folder, tmp_path, capsys, args, sentence):
    damaged, other = tmp_path / "damaged", tmp_path / "other.csv"
    damaged.mkdir()
    (damaged / "a.png").write_bytes(b"cut off")
    other.write_text("file_name,class,x_px,y_px,width_px,height_px\nz.png,aqua,1,2,3,4\n")
    names = {"images": folder / "images" / "test", "damaged": damaged, "other": other}
    before = sorted(tmp_path.iterdir())
    assert run(*(arg.format(**names) for arg in args), "-o", tmp_path / "out") == 2
    assert sentence in capsys.readouterr().err.splitlines()[-1]
    assert sorted(tmp_path.iterdir()) == before


def test_the_shipped_network_looks_at_a_picture(tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "sea.png"), np.full((96, 128, 3), 90, dtype=np.uint8))
    assert run(tmp_path / "sea.png", "-o", tmp_path / "out") == 0
    assert "1 picture, 0 boxes, 0.00 a picture" in capsys.readouterr().out
    assert (tmp_path / "out" / "boxes.csv").read_text() == ",".join(command.COLUMNS) + "\n"
