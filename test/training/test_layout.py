# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data sets as data.yaml describes them."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import label_file, open_dataset


def problems(folder, **options):
    return [str(problem) for problem in inspect(open_dataset(folder), **options).problems]


def test_paths_as_roboflow_writes_them(tmp_path, make_set):
    """train/images beside data.yaml, called ../train/images in it."""
    made, folder = make_set(tmp_path / "made"), tmp_path / "set"
    for split in ("train", "val"):
        (folder / split).mkdir(parents=True)
        for kind in ("images", "labels"):
            (made / kind / split).rename(folder / split / kind)
    paths = "train: ../train/images\nval: ../val/images\nnc: 1\nnames: [aqua]\n"
    (folder / "data.yaml").write_text(paths)
    assert problems(folder) == []
    assert [len(e.boxes) for e in inspect(open_dataset(folder)).examples["val"]] == [1, 2, 1, 3]
    (folder / "data.yaml").write_text(paths.replace("val/images", "valid/images"))
    with pytest.raises(InputError, match=r"'\.\./valid/images', but .* is neither a folder"):
        open_dataset(folder)


def test_lists_of_images(tmp_path, make_set):
    folder = make_set(tmp_path / "set")
    (folder / "some.txt").write_text("images/train/1.png\n\nimages/train/9.png\n")
    (folder / "data.yaml").write_text("train: some.txt\nval: [images/val]\nnames: [aqua]\n")
    dataset = open_dataset(folder)
    assert [path.name for path in dataset.images["train"]] == ["1.png", "9.png"]
    (said,) = problems(folder)
    assert said.endswith("9.png: the image is missing")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("train: [", "is not YAML"),
        ("- train", "must have the keys"),
        ("train: images/train", "has no names"),
        ("val: images/val\nnames: [a]", "has no train"),
        ("train: images/train\nnames: {1: a, 2: b}", "numbered 0, 1, 2"),
        ("train: images/train\nnames: [a, b]\nnc: 3", "nc is 3, but there are 2"),
        ("train: images/train\nnames: [a, a]", "same name"),
        ("train: images/none\nnames: [a]", "neither a folder of images nor a text file"),
    ],
)
def test_what_data_yaml_must_say(tmp_path, make_set, text, expected):
    folder = make_set(tmp_path / "set")
    (folder / "data.yaml").write_text(text)
    with pytest.raises(InputError, match=expected):
        open_dataset(folder)


def test_labels_lie_beside_the_last_images_folder(tmp_path):
    image = tmp_path / "images" / "set" / "images" / "train" / "a.b.jpg"
    assert label_file(image) == tmp_path / "images" / "set" / "labels" / "train" / "a.b.txt"
    assert label_file(tmp_path / "plain" / "a.jpg").name == "a.txt"
