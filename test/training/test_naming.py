# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every image of a split has a name of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerial_gnss_ros.training.layout import Dataset
from aerial_gnss_ros.training.naming import path_key, unique_names

ROOT = Path("/set")


def dataset(*folders):
    return Dataset(
        ROOT / "data.yaml", ROOT, ("aqua",), {}, {"train": tuple(ROOT / one for one in folders)}
    )


@pytest.mark.parametrize(
    ("folders", "images", "names"),
    [
        (["images/train"], ["images/train/a.png", "images/train/b.jpg"], ["a", "b"]),
        (["images/train"], ["images/train/x/a.png", "images/train/a.png"], ["x_a", "a"]),
        (["one", "two"], ["one/a.png", "two/a.png", "two/b.png"], ["one_a", "two_a", "b"]),
        (["one"], ["one/a.png", "one/a.jpg"], ["one_a_0", "one_a_1"]),  # of two endings
        (["one"], ["two/a.png"], ["a"]),  # listed from elsewhere
    ],
)
def test_a_name_is_as_short_as_it_can_be(folders, images, names):
    assert unique_names([ROOT / one for one in images], dataset(*folders)) == names


def test_an_image_is_known_by_its_path_wherever_the_set_lies():
    assert path_key(ROOT / "images/train/a.png", dataset("images/train")) == "images/train/a"
    assert path_key(Path("/other/a.png"), dataset("images/train")) == "a"
