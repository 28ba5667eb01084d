# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parts of photographs: where water is, and what is labelled in them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.photographs import photographs_of, random_part, water_of

sys.path.insert(0, str(Path(__file__).parent))

from shores import shore


def test_the_calmest_part_is_water():
    water = water_of(shore(), 0.4)
    assert water[:, 180:].sum() == 0
    assert water[:, :120].mean() > 0.7
    assert water_of(shore(), 1.0).all()


def test_boxes_go_with_their_pixels():
    """What is labelled stays on the bright spot, however the photograph is turned."""
    image = np.zeros((240, 320, 3), np.uint8)
    image[100:141, 180:201] = 255
    box = np.array([[180.0, 100.0, 200.0, 140.0]])
    upright = []
    for seed in range(24):
        part = random_part(np.random.default_rng(seed), image, box, 160, (0.8, 1.2), 1.0)
        assert part.image.shape == (160, 160, 3)
        rows, columns = np.nonzero(part.image[..., 0] > 127)
        if not len(rows):
            continue
        left, top, right, bottom = np.clip(part.objects[0], 0, 159)
        seen = (columns.min(), rows.min(), columns.max(), rows.max())
        assert seen == pytest.approx((left, top, right, bottom), abs=1.6)
        upright.append(bottom - top > right - left)
    assert any(upright)
    assert not all(upright)


def test_a_folder_without_photographs_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("none")
    with pytest.raises(InputError, match="has no images"):
        photographs_of(tmp_path, None)
