# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sheet shows variants of a few images, their boxes drawn."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training.contact_sheet import COLUMNS, ROWS, SIDE, write_contact_sheet


def written(tmp_path, variants, size=(64, 32), box="0 0.5 0.5 0.5 0.5\n"):
    """Write so many variants of each name, and the sheet; return it."""
    for kind in ("images", "labels"):
        (tmp_path / kind / "train").mkdir(parents=True)
    for stem, count in variants.items():
        for number in range(count):
            name = f"{stem}_{number:02d}"
            image = np.full((size[1], size[0], 3), 90, np.uint8)
            cv2.imwrite(str(tmp_path / "images" / "train" / f"{name}.jpg"), image)
            (tmp_path / "labels" / "train" / f"{name}.txt").write_text(
                box if "no" not in stem else ""
            )
    write_contact_sheet(tmp_path, "train", list(variants), tmp_path / "sheet.png")
    return cv2.imread(str(tmp_path / "sheet.png"))


@pytest.mark.parametrize(
    ("variants", "rows", "columns"),
    [
        ({"a": 2}, 1, 2),
        ({"a": 2, "b": 3, "c": 1}, 3, 3),
        ({"a": COLUMNS + 2}, 1, COLUMNS),
        ({f"{i:02d}": 1 for i in range(20)}, ROWS, 1),
        ({"a": 0, "b": 1}, 1, 1),  # all of one image were left out
        ({}, 1, 1),
    ],
)
def test_each_image_has_a_row(tmp_path, variants, rows, columns):
    assert written(tmp_path, variants).shape == (rows * SIDE, columns * SIDE, 3)


def test_images_with_robots_are_shown_where_there_are_any(tmp_path):
    assert written(tmp_path, {"a": 1, "no1": 1, "no2": 1}).shape[0] == SIDE


def test_a_box_is_drawn_where_its_label_says(tmp_path):
    """The image fills the width: 320 x 160, from row 80 on; its box a quarter of it."""
    sheet = written(tmp_path, {"a": 1}).astype(int)
    drawn = np.abs(sheet - (0, 255, 255)).sum(axis=2) < 30
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    assert (columns[0], columns[-1], rows[0], rows[-1]) == (80, 240, 120, 200)
    assert not sheet[:80].any()
    assert sheet[85, 5] == pytest.approx([90] * 3, abs=3)
