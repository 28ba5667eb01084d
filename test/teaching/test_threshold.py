# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The threshold of a taught detector: between robots and others, and never close to robots."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.second_look_terms import log_odds, score_of
from aerial_gnss_ros.teaching.threshold import DRAWN, best_threshold
from aerial_gnss_ros.training.labelled import LabelledImage, Truth

BOXES = np.array([[50.0, 50.0, 20.0, 20.0], [150.0, 50.0, 20.0, 20.0]])


def chosen(scores, count=1):
    """Return the threshold for a detector on so many images, each of even water and a robot.

    Args:
        scores: returns those of the robot and of another thing, by the image and its number.
        count: of images.
    """
    seen = itertools.count()

    class Known:
        def detect(self, image):
            given = np.array(scores(image, next(seen)))
            some = len(given)
            return Detections(BOXES[:some], given, np.zeros(some, np.int64), ("fin",))

    truth = Truth(
        np.array([[40.0, 40.0, 60.0, 60.0]]), np.ones(1, bool), np.ones(1), np.ones(1),
        np.zeros(1, np.int64),
    )  # fmt: skip
    image = LabelledImage("a", truth, lambda: np.zeros((100, 200, 3), np.uint8))
    return best_threshold(Known(), [image] * count, 1)


def test_the_threshold_is_the_middle_of_the_best():
    """Robots have scores of 0.97, others of 0.1: the middle of log odds is as far from both."""
    middle = score_of(0.5 * (log_odds(0.97) + log_odds(0.1)))
    assert chosen(lambda *_: [0.97, 0.1]) == pytest.approx(middle, abs=0.015)


def test_the_threshold_is_chosen_with_other_things_in_view():
    """The recording shows one robot of 0.98; what is drawn beside it has 0.4.

    Without the things any threshold up to 0.98 would be as good.
    """
    found = chosen(lambda image, _: [0.98, 0.4] if image.std() > 0.0 else [0.98])
    middle = score_of(0.5 * (log_odds(0.98) + log_odds(0.4)))
    assert found == pytest.approx(middle, abs=0.015)


def test_one_thing_that_scores_as_a_robot_does_not_put_the_threshold_beside_the_robots():
    """F is best between 0.88 and 0.9, where robots that score a little lower are lost."""
    assert 0.2 < chosen(lambda _, number: [0.9, 0.88 if number == 7 else 0.2], 10) < 0.8


def test_two_false_boxes_cost_more_than_two_robots():
    """Of ten robots two score 0.6, and two other things 0.7: F1 is best with all, F0.5 without."""

    def scores(_, number):
        image = number // (1 + DRAWN)
        return [0.6 if image < 2 else 0.95, *([0.7] if image in (2, 3) else [])]

    assert chosen(scores, 10) > 0.6
