# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tiles lie where the network was wrong, and their labels where the robots are."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_labels
from aerial_gnss_ros.training.mining import Mining, hard_places, mine


def truth(*corners):
    table = np.array(corners, dtype=np.float64).reshape(-1, 4)
    n = len(table)
    return Truth(table, np.ones(n, bool), np.full(n, 20.0), np.full(n, 0.3), np.zeros(n, np.int64))


class Fixed:
    """A detector that always finds the same."""

    name, class_names = "fixed", ("aqua",)

    def __init__(self, *rows):
        table = np.array(rows, dtype=np.float64).reshape(-1, 5)
        middle = (table[:, :2] + table[:, 2:4]) / 2
        self.found = Detections(
            np.hstack([middle, table[:, 2:4] - table[:, :2]]),
            table[:, 4],
            np.zeros(len(table), np.int64),
            ("aqua",),
        )

    def detect(self, _):
        return self.found


FOUND, MISSED = (50.0, 50.0, 90.0, 70.0), (200.0, 100.0, 240.0, 120.0)


@pytest.mark.parametrize(
    ("boxes", "expected"),
    [
        ([(*FOUND, 0.9)], [(220, 110)]),  # a robot missed
        ([(*FOUND, 0.5), (*MISSED, 0.9)], [(70, 60)]),  # one found with a low score
        ([(*FOUND, 0.9), (203, 102, 243, 122, 0.9)], [(220, 110)]),  # IoU 0.71
        ([(*FOUND, 0.9), (*MISSED, 0.9), (0, 200, 40, 220, 0.2)], [(20, 210)]),  # a false box
        ([(*FOUND, 0.9), (*MISSED, 0.9), (0, 200, 40, 220, 0.12)], []),  # no score to speak of
    ],
)
def test_hard_places(boxes, expected):
    places = hard_places(Fixed(*boxes).found, truth(FOUND, MISSED), Mining())
    assert places.tolist() == [list(map(float, place)) for place in expected]


def test_tiles_show_the_robots_where_their_labels_say(tmp_path):
    image = np.zeros((240, 320, 3), np.uint8)
    boxes = truth(FOUND, MISSED)
    for left, top, right, bottom in boxes.corners.astype(int):
        image[top : bottom + 1, left : right + 1] = 255
    boxes = truth(*(boxes.corners + np.array([-0.5, -0.5, 0.5, 0.5])))
    images = [LabelledImage("a.png", boxes, lambda: image)]
    tiles = tmp_path / "tiles"
    assert mine(Fixed(), images, tiles, Mining(side=96, draws=3, easy=0.0)) == (6, 0)
    for tile in read_labels(tiles, "train"):
        assert len(tile.truth.corners) == 1
        picture = tile.read()
        assert picture.shape == (96, 96, 3)
        v, u = np.nonzero(picture[..., 0] > 127)
        seen = [u.min() - 0.5, v.min() - 0.5, u.max() + 0.5, v.max() + 0.5]
        np.testing.assert_allclose(tile.truth.corners[0], seen, atol=1e-3)
    assert cv2.haveImageReader(str(next((tiles / "images" / "train").iterdir())))


def test_what_cannot_be_cut_is_refused_and_leaves_nothing(tmp_path):
    images = [LabelledImage("a.png", truth(), lambda: np.zeros((90, 320, 3), np.uint8))]
    with pytest.raises(ConfigError, match=r"a\.png is 320x90 px, smaller than a tile of 160"):
        mine(Fixed(), images, tmp_path / "tiles", Mining())
    assert not list(tmp_path.iterdir())
    (tmp_path / "tiles").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        mine(Fixed(), images, tmp_path / "tiles", Mining())
