# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Failures are shown with their scores."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training import failures
from aerial_gnss_ros.training.labelled import LabelledImage

sys.path.insert(0, str(Path(__file__).parent))

from scored import ROBOT, Fixed, truth


def test_failures_are_shown_with_their_scores(tmp_path, monkeypatch, capsys):
    image = np.full((60, 400, 3), 90, np.uint8)
    labelled = LabelledImage("a", truth(ROBOT, (100, 30, 140, 50, 1)), lambda: image)
    missed, false = failures.failures(Fixed(), [labelled])
    assert [one.words for one in missed + false] == ["missed", "false 0.33", "false 0.21"]
    assert missed[0].cell.shape == (failures.CELL, failures.CELL, 3)
    # The box's middle is the cell's, and it is drawn 1/1.8 of the cell wide.
    green = (missed[0].cell == (0, 255, 0)).all(axis=2)
    columns = np.flatnonzero(green.any(axis=0))
    assert (columns[0] + columns[-1]) / 2 == pytest.approx((failures.CELL - 1) / 2, abs=1)
    assert np.ptp(columns) == pytest.approx(failures.CELL / 1.8, abs=2)
    monkeypatch.setattr(failures, "load_detector", lambda _: Fixed())
    monkeypatch.setattr(failures, "open_images", lambda *_: [labelled])
    assert failures.main(["x", "y", "-o", str(tmp_path / "f.png"), "--columns", "3"]) == 0
    assert "1 missed, 2 false boxes" in capsys.readouterr().out
    assert cv2.imread(str(tmp_path / "f.png")).shape == (320, 480, 3)
