# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots composed onto photographs: on water, beside what is there, labelled as in a simulation."""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training.composing import (
    Composing,
    main,
    write_composed,
)
from aerial_gnss_ros.training.labelled import read_folder, read_labels
from aerial_gnss_ros.training.photographs import photographs_of

sys.path.insert(0, str(Path(__file__).parent))

from shores import shore

PLAN = Composing(6, side=160, seed=4, occupied=1.0, scales=(0.8, 1.2))
PLAN = replace(PLAN, variety=replace(PLAN.variety, distractors=0.0, flotsam=0.0))


@pytest.fixture
def photographs(tmp_path):
    folder = tmp_path / "photographs"
    folder.mkdir()
    for number in range(2):
        cv2.imwrite(str(folder / f"p{number}.png"), shore(number))
    (tmp_path / "labels.csv").write_text(
        "file_name,class,x_px,y_px,width_px,height_px\np0.png,boat,10,20,40,30\np1.png,,,,,\n"
    )
    return folder


def test_robots_are_on_water_and_labelled(tmp_path, photographs):
    plan = replace(PLAN, calm=0.4)
    found = photographs_of(photographs, tmp_path / "labels.csv")
    assert [len(objects) for _, objects in found] == [1, 0]
    np.testing.assert_allclose(found[0][1], [[9.5, 19.5, 49.5, 49.5]])
    count = write_composed(found, tmp_path / "set", plan)
    assert count > 0
    labels = {image.name: image for image in read_labels(tmp_path / "set", "train")}
    seen = 0
    for image in read_folder(tmp_path / "set", "train"):
        pixels = image.read()
        assert pixels.shape == (160, 160, 3)
        np.testing.assert_allclose(labels[image.name].truth.corners, image.truth.corners, atol=0.1)
        for corners in image.truth.corners:
            assert 10.0 < (corners[2:] - corners[:2]).max() < 300.0
            seen += 1
    assert seen == count
    with (tmp_path / "set/meta.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == count
    assert {row["labelled"] for row in rows} == {"1"}


def test_the_same_seed_gives_the_same_bytes(tmp_path, photographs):
    found = photographs_of(photographs, None)
    for name, seed in (("a", 4), ("b", 4), ("c", 5)):
        write_composed(found, tmp_path / name, replace(PLAN, count=2, seed=seed))
    files = [
        [path.read_bytes() for path in sorted((tmp_path / name).rglob("*")) if path.is_file()]
        for name in "abc"
    ]
    assert files[0] == files[1]
    assert files[0] != files[2]


def test_the_command(tmp_path, photographs, capsys):
    output = tmp_path / "out"
    command = [str(photographs), "-o", str(output), "--count", "2", "--side", "160"]
    assert main([*command, "--occupied", "0"]) == 0
    assert "2 images with 0 robots" in capsys.readouterr().out
    assert sorted(path.name for path in output.iterdir()) == [
        "data.yaml", "images", "labels", "meta.csv",
    ]  # fmt: skip
    assert "0: aqua" in (output / "data.yaml").read_text()
    for wrong, words in (
        ([], "exists already"),
        (["--calm", "0"], "calm must lie within"),
        (["--lengths", "thirty"], "two lengths"),
    ):
        assert main([*command, *wrong]) == 2
        assert words in capsys.readouterr().err
    assert main([str(tmp_path / "set"), "-o", str(tmp_path / "o"), "--count", "1"]) == 2
    assert "has no images" in capsys.readouterr().err
    with pytest.raises(ConfigError, match="side"):
        Composing(1, side=10)
