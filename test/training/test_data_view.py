# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A view of a data set leaves its images alone."""

from __future__ import annotations

import cv2
import numpy as np

from aerial_gnss_ros.training.data_view import write_view
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset


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
