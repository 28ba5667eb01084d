# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images that an export is calibrated with are spread over the folder."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.calibration_images import choose_images


def test_calibration_images_are_spread_over_the_folder(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        choose_images(tmp_path / "none")
    with pytest.raises(InputError, match="no calibration images"):
        choose_images(tmp_path)
    for number in range(10):
        (tmp_path / f"{number}.png").touch()
    (tmp_path / "notes.txt").touch()
    assert [path.name for path in choose_images(tmp_path, 4)] == [
        "0.png", "3.png", "6.png", "9.png",
    ]  # fmt: skip
    (tmp_path / "contact_sheet.png").touch()  # of `augment`: no camera takes that
    assert len(choose_images(tmp_path, 100)) == 10
