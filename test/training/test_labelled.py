# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images as they are read back: from labels, and from the simulation's own table."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.labelled import read_folder, read_labels

HEAD = "split,image,scored,left,top,right,bottom,long_px,contrast"


def written(tmp_path, labels="1 0.5 0.25 0.2 0.1\n", meta=None):
    """Write an image of 100 x 80 px with its labels."""
    for kind in ("images", "labels"):
        (tmp_path / kind / "val").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "images" / "val" / "a.png"), np.full((80, 100, 3), 9, np.uint8))
    if labels is not None:
        (tmp_path / "labels" / "val" / "a.txt").write_text(labels)
    if meta is not None:
        (tmp_path / "meta.csv").write_text("\n".join([HEAD, *meta]) + "\n")
    return tmp_path


def test_a_label_is_a_box_whose_first_pixel_has_its_middle_at_0(tmp_path):
    """Middle at (50, 20) from the edge, 20 x 8 px."""
    (one,) = read_labels(written(tmp_path), "val")
    assert one.name == "a.png"
    assert one.truth.corners.tolist() == pytest.approx(np.array([[39.5, 15.5, 59.5, 23.5]]))
    assert (one.truth.class_ids.tolist(), one.truth.counted.tolist()) == ([1], [True])
    assert one.truth.long_px.tolist() == pytest.approx([20.0])
    assert np.isnan(one.truth.contrast).all()
    assert one.read().shape == (80, 100, 3)


@pytest.mark.parametrize("labels", [None, "", "\n\n"])
def test_an_image_without_labels_shows_no_robot(tmp_path, labels):
    (one,) = read_folder(written(tmp_path, labels), "val")
    assert len(one.truth.corners) == 0


def test_the_simulations_table_says_which_robots_count(tmp_path):
    rows = [
        "val,a.png,1,1,2,30,20,30,0.3",
        "val,a.png,0,5,5,9,9,4,0.01",
        "test,a.png,1,0,0,9,9,9,1",
    ]
    folder = written(tmp_path, meta=rows)
    (one,) = read_folder(folder, "val")
    assert one.truth.corners.tolist() == [[1, 2, 30, 20], [5, 5, 9, 9]]
    assert one.truth.counted.tolist() == [True, False]
    assert one.truth.contrast.tolist() == [0.3, 0.01]
    (trained_on,) = read_labels(folder, "val")
    assert len(trained_on.truth.corners) == 1


def test_a_table_of_other_splits_says_nothing_of_this_one(tmp_path):
    (one,) = read_folder(written(tmp_path, meta=["test,a.png,1,0,0,9,9,9,1"]), "val")
    assert one.truth.class_ids.tolist() == [1]


@pytest.mark.parametrize("labels", ["0 1 2 3", "0 a b c d", "0 1 2 3 4 5"])
def test_labels_that_are_none_are_named(tmp_path, labels):
    with pytest.raises(InputError, match=r"a\.txt"):
        list(read_folder(written(tmp_path, labels), "val"))


def test_another_split_is_proposed(tmp_path):
    with pytest.raises(InputError, match=r"--split\).* val"):
        list(read_folder(written(tmp_path), "train"))
    with pytest.raises(InputError, match="YOLO"):
        list(read_folder(tmp_path / "none", "train"))
