# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much a second look counts is what held-out images say."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.share import Look, Share, best_share, strictest_share

sys.path.insert(0, str(Path(__file__).parent))

from scored import truth_of


def look_of(detector, second):
    """Two robots and a false box, with the scores that each network gives them."""
    middles = np.array([[10.0, 10.0], [60.0, 10.0], [10.0, 60.0]])
    corners = np.hstack([middles - 10.0, middles + 10.0])
    xywh, none = np.hstack([middles, np.full((3, 2), 20.0)]), np.zeros(3, np.int64)
    found = Detections(xywh, np.array(detector), none, ("aqua",))
    return Look(found, np.array(second), truth_of(*corners[:2]))


def test_the_share_is_what_the_held_out_images_say():
    # The detector takes the false box for a robot, the second look does not take the second one
    # for one; only together, at even odds or nearly, they are right.
    look = look_of([0.79, 0.55, 0.65], [0.7, 0.45, 0.04])
    share, reached = best_share([[look]])
    assert reached == 1.0
    boxes, _ = look.shared(share.weight)
    odds = np.log(boxes.scores / (1.0 - boxes.scores)) + share.shift
    assert (odds[:2] > np.log(0.3 / 0.7)).all()
    assert odds[2] < np.log(0.3 / 0.7)
    assert boxes.xywh[2, 1] == 60.0
    # Ten images of another kind, in which the detector alone is right, count no more than this one.
    others = [look_of([0.79, 0.7, 0.04], [0.79, 0.7, 0.04])] * 10
    again, reached = best_share([[look], others])
    assert (again, reached) == (share, 1.0)
    # A box that was not looked at again keeps the score that it had.
    assert look_of([0.9, 0.5, 0.02], [0.9, 0.7, 0.02]).shared(1.0)[0].scores.tolist() == (
        pytest.approx([0.9, 0.7, 0.02])
    )


def test_the_strictest_share_gives_up_robots_only_as_far_as_allowed():
    # Only the second look knows the false box, and takes one robot of two for nothing.
    look = look_of([0.7, 0.7, 0.75], [0.9, 0.3, 0.6])
    both, false = strictest_share([[look]], [1.0])
    assert false == 1.0
    one, false = strictest_share([[look]], [0.5])
    assert false == 0.0
    for share, kept in ((both, 3), (one, 1)):
        boxes, _ = look.shared(share.weight)
        odds = np.log(boxes.scores / (1.0 - boxes.scores)) + share.shift
        assert (odds >= np.log(0.3 / 0.7) - 1e-9).sum() == kept
    # Of the stated weights only: with little of the second look the false box stays.
    stated, false = strictest_share([[look]], [0.5], (0.1,))
    assert (stated.weight, false) == (0.1, 1.0)
    # Each kind of images has its own least recall, and false boxes count by the image.
    lost = look_of([0.005] * 3, [0.005] * 3)
    assert strictest_share([[look], [lost, lost]], [0.5, 0.0])[1] == 0.0
    with pytest.raises(ModelError, match="ask for fewer"):
        strictest_share([[look], [lost]], [0.5, 1.0])


def test_log_odds_are_shared_by_weight_and_then_shifted():
    """A quarter of log 9 and three quarters of -log 4, and 0.5 more; even odds are 0."""
    mixed = Share(0.25, 0.5).scores(np.array([0.9, 0.5]), np.array([-np.log(4.0), 0.0]))
    odds = np.array([0.25 * np.log(9.0) - 0.75 * np.log(4.0) + 0.5, 0.5])
    np.testing.assert_allclose(np.log(mixed / (1.0 - mixed)), odds)
