# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes of several windows become robots: each once, whole where any window shows it whole."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.pieces import Piece, detections, look, merge, reconsidered
from aerial_gnss_ros.detection.windows import Window

WINDOWS = [Window(0, 0, 100, 100), Window(60, 0, 100, 100)]
NO, RIGHT, LEFT = np.zeros(4, bool), np.eye(4, dtype=bool)[2], np.eye(4, dtype=bool)[0]


def piece(corners, window, score=0.9, cut=NO, class_id=0):
    return Piece(np.array(corners, float), score, class_id, window, cut)


def left(*pieces):
    return [(one.corners.tolist(), one.score) for one in merge(pieces, WINDOWS)]


def test_a_robot_that_both_windows_show_is_taken_from_the_better_one():
    whole, worse = piece([65, 20, 85, 40], 0), piece([66, 21, 86, 41], 1, 0.5)
    assert left(worse, whole) == [([65, 20, 85, 40], 0.9)]
    assert len(left(whole, piece([66, 21, 86, 41], 1, 0.5, class_id=1))) == 2
    assert len(left(whole, piece([66, 21, 86, 41], 0, 0.5))) == 2  # of one window both are robots
    assert len(left(whole, piece([90, 20, 98, 40], 1, 0.5))) == 2


def test_two_ends_that_face_each_other_are_one_robot():
    one, other = piece([50, 20, 99.5, 40], 0, 0.6, RIGHT), piece([59.5, 21, 130, 40], 1, 0.8, LEFT)
    assert left(one, other) == [([50, 20, 130, 40], 0.8)]
    below = piece([59.5, 35, 130, 80], 1, 0.8, LEFT)
    assert len(left(one, below)) == 2  # not at the same height


def test_a_cut_box_is_dropped_where_another_window_shows_the_place_whole():
    cut = piece([75, 20, 99.5, 40], 0, 0.6, RIGHT)
    assert left(cut) == []  # the other one shows all of it, with room, and no robot
    assert left(piece([45, 20, 99.5, 40], 0, 0.6, RIGHT)) == [([45, 20, 99.5, 40], 0.6)]
    assert left(cut, piece([74, 20, 120, 40], 1, 0.7)) == [([74, 20, 120, 40], 0.7)]


class Seeing:
    """A detector that finds the same box in each window."""

    name, class_names = "seeing", ("aqua", "boat")

    def detect(self, _):
        found = np.array([[90.0, 50.0, 19.0, 10.0]])
        return Detections(found, np.array([0.7]), np.array([1]), self.class_names, {"infer": 2.0})


def test_boxes_are_placed_in_the_whole_image_and_cut_by_inner_edges_alone():
    pieces, spent = look(Seeing(), np.zeros((100, 160, 3), np.uint8), WINDOWS)
    assert spent == {"infer": 4.0}
    assert [one.corners.tolist() for one in pieces] == [
        [80.5, 45.0, 99.5, 55.0], [140.5, 45.0, 159.5, 55.0],
    ]  # fmt: skip
    assert [one.cut.tolist() for one in pieces] == [RIGHT.tolist(), NO.tolist()]
    assert [(one.window, one.class_id, one.whole) for one in pieces] == [
        (0, 1, False),
        (1, 1, True),
    ]


def test_a_second_look_judges_what_is_whole():
    class Second:
        def scores(self, _, xywh, scores):
            assert xywh.tolist() == [[75, 30, 20, 20], [15, 15, 10, 10]]
            assert scores.tolist() == [0.9, 0.4]
            return np.array([0.1, 0.8])

    pieces = [piece([10, 10, 20, 20], 0, 0.4), piece([65, 20, 85, 40], 0),
              piece([90, 20, 99.5, 40], 0, 0.6, RIGHT)]  # fmt: skip
    found = reconsidered(pieces, np.zeros((9, 9, 3), np.uint8), Second(), 0.3)
    assert [(one.corners[0], one.score) for one in found] == [(10, 0.8), (90, 0.6)]


@pytest.mark.parametrize("most", [0, 1, 5])
def test_the_best_are_reported(most):
    found = detections(
        [piece([10, 10, 20, 30], 0), piece([0, 0, 4, 4], 0, 0.2)], ("aqua",), most, {}
    )
    assert len(found) == min(most, 2)
    assert found.xywh[:1].tolist() == [[15, 20, 10, 20]][:most]
