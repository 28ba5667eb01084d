# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss simulate --dataset`: what it makes within the given ranges, and what it refuses."""

from __future__ import annotations

import csv
import json
import re

import cv2
import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.layout import open_dataset


def test_pictures_within_the_given_ranges(tmp_path, capsys):
    folder = tmp_path / "set"
    arguments = ["simulate", "--dataset", str(folder), "--count", "10", "--val", "5", "--json"]
    arguments += ["--crop", "128", "--seed", "4", "--heights", "8,20", "--tilts", "40,90"]
    arguments += ["--depths=0.3,0.9", "--lengths", "30,60", "--extra-robots", "0.5"]
    arguments += ["--winds", "6,8"]
    assert main(arguments) == 0
    said, shown = capsys.readouterr()
    assert json.loads(said)["pictures"] == {"train": 10, "val": 5}
    assert "rendering: 15 of 15 pictures" in shown
    pictures = sorted(folder.glob("images/*/*.jpg"))
    assert len(pictures) == 15
    assert all(cv2.imread(str(path)).shape == (128, 128, 3) for path in pictures)
    with (folder / "meta.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) >= 10
    for row in rows:
        assert 8.0 <= float(row["height_m"]) <= 20.0
        assert 0.0 <= float(row["tilt_deg"]) <= 50.0
        assert 0.3 <= float(row["depth_m"]) <= 0.9
        assert 6.0 <= float(row["wind_mps"]) <= 8.0


def test_no_robots_where_none_are_asked_for(tmp_path):
    folder = tmp_path / "set"
    arguments = ["simulate", "--dataset", str(folder), "--count", "5", "--val", "0"]
    assert main([*arguments, "--crop", "64", "--occupied", "0"]) == 0
    assert [path.read_text() for path in folder.glob("labels/*/*.txt")] == [""] * 5


def test_whole_frames_to_score_on(tmp_path, capsys):
    folder = tmp_path / "set"
    arguments = ["simulate", "--dataset", str(folder), "--count", "1", "--whole-frames"]
    assert main([*arguments, "--size", "320x192"]) == 0
    (path,) = folder.glob("images/test/*.jpg")
    assert cv2.imread(str(path)).shape == (192, 320, 3)
    assert "1 test images, fast renderer, seed 1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give either -o BAG for a flight or --dataset FOLDER"),
        (["-o", "b", "--dataset", "d"], "give either -o BAG"),
        (["-o", "b", "--no-images", "--distractors", "5"], "--distractors need images"),
        (["-o", "b", "--count", "5"], "--count applies only with --dataset"),
        (["--dataset", "d", "--duration", "9"], "--duration cannot be used with --dataset"),
        (["--dataset", "d", "--size", "640x360"], "--size of images applies only with"),
        (["--dataset", "d", "--flight", "orbit"], "--flight cannot be used with --dataset"),
        (["--dataset", "d", "--occupied", "2"], "--occupied is a share, 0 to 1, not 2"),
        (["--dataset", "d", "--count", "0"], "--count must be 1 or more, not 0"),
        (["--dataset", "d", "--heights", "20,8"], "--heights must be LOW,HIGH .* not 20,8"),
        (["--dataset", "d", "--winds", "0,8"], "--winds must be LOW,HIGH within 0.5 to 15"),
        (["--dataset", "d", "--crop", "20"], "crops of .*20.* cannot be made"),
        (
            ["--dataset", "d", "--distractors", "99"],
            "--distractors must lie within 0 to 10, not 99",
        ),
        (
            ["--dataset", "d", "--whole-frames", "--crop", "99"],
            "cannot be used with --whole-frames",
        ),
        (["--dataset", "d", "--renderer", "gl"], "invalid choice: 'gl'"),
        (["--dataset", "d", "--robot-model", "whale"], "no robot model 'whale'; choose one of"),
        (["--dataset", "d", "--robot-model", "box,torpedo"], "robots of one model, not of box,"),
        (
            ["--dataset", "d", "--count", "1", "--heights", "400,500", "--lengths", "300,400"],
            "no lens shows a robot 3.. px long from 400 to 500 m",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    try:
        status = main(["simulate", *arguments])
    except SystemExit as error:
        status = int(str(error))
    assert status == 2
    said = " ".join(capsys.readouterr().err.split())
    assert re.search(words, said), said
    assert not list(tmp_path.iterdir())


def test_a_data_set_of_another_robot_has_its_class(tmp_path):
    folder = tmp_path / "set"
    arguments = ["simulate", "--dataset", str(folder), "--count", "2", "--val", "0"]
    assert main([*arguments, "--occupied", "1", "--robot-model", "catamaran"]) == 0
    assert open_dataset(folder).names == ("catamaran",)
    with (folder / "meta.csv").open(encoding="utf-8") as file:
        assert {row["robot_id"].split("_")[0] for row in csv.DictReader(file)} == {"catamaran"}


def test_a_flight_has_the_classes_of_its_models(tmp_path):
    bag = tmp_path / "flight"
    arguments = ["simulate", "-o", str(bag), "--duration", "1", "--rate", "1", "--tilt", "90"]
    arguments += ["--size", "320x192", "--robots", "2", "--robot-model", "torpedo,box"]
    assert main(arguments) == 0
    with open_bag([bag]) as opened:
        topics = {name for name in opened.topics if name.endswith("truth/labels")}
        (label,) = (json.loads(r.message().data) for r in opened.messages(topics))
    kinds = {robot["robot_id"]: robot["class"] for robot in label["robots"]}
    assert kinds == {"torpedo_1": "torpedo", "box_1": "box"}


def test_distractors_are_seen_in_a_flight_and_have_no_boxes(tmp_path, capsys):
    """The same flight with and without them: other pixels, the same true boxes."""
    seen = []
    for count in (0, 12):
        bag = tmp_path / f"flight_{count}"
        arguments = ["simulate", "-o", str(bag), "--duration", "1", "--rate", "1", "--seed", "3"]
        arguments += ["--size", "320x192", "--tilt", "90", "--distractors", str(count)]
        assert main(arguments) == 0
        assert ("other things afloat: 12" in capsys.readouterr().out) == (count > 0)
        (image,) = read_bag(bag)
        seen.append((image.read().astype(int), image.truth.corners))
    (plain, boxes), (full, same_boxes) = seen
    assert boxes.tolist() == same_boxes.tolist()
    assert (abs(plain - full).max(axis=2) > 30).sum() > 50
