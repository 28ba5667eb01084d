# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot whose boxes have another class now and then is one robot."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.misclassified_tracks import misclassified
from aerial_gnss_ros.core.values.estimates import State

WINDOW, GATE = 20, 9.0
OFTEN = (1, 2, 4, 5, 7, 8)
"""Images that showed the robot."""


def found(new_hits, apart_m=2.0, hits=OFTEN, class_id="boat", label="aqua_1"):
    """Return whether a track is the robot, with places known to 1 m and so far apart."""
    robot = Track("aqua", hits[0], hits[-1], State.CONFIRMED, label, hits)
    new = Track(class_id, new_hits[0], new_hits[-1], State.TENTATIVE, "", new_hits)
    table = SimpleNamespace(
        tracks=[new, robot],
        separations=lambda old, late: (
            np.tile([apart_m, 0.0], (len(old), len(late), 1)),
            np.tile(np.eye(2), (len(old), len(late), 1, 1)),
        ),
    )
    return misclassified(table, [0], GATE, WINDOW) == {0}


@pytest.mark.parametrize(
    ("given", "robot"),
    [
        ({}, True),
        ({"apart_m": 3.1}, False),  # outside the gate
        ({"class_id": "aqua"}, False),  # may be one that is reacquired
        ({"label": ""}, False),  # nobody knows which of the two it is
        ({"hits": (1, 2, 4, 5, 6)}, False),  # an image has shown both
        ({"hits": (1, 2)}, False),  # seen less often
        ({"hits": (1, 2, 4)}, True),
        ({"hits": (-20, -19, -18, -17, -11, -10)}, False),  # not lately
    ],
)
def test_which_track_is_a_robot_of_another_class(given, robot):
    assert found((3, 6, 9), **given) == robot


@pytest.mark.flights
def test_a_detector_that_confuses_classes_makes_no_more_robots(sea):
    """A tenth of the boxes of three robots have another class."""

    class Confusing(sea.World):
        def frame(self, t):
            frame = super().frame(t)
            wrong = self.rng.random(len(frame.class_ids)) < 0.1
            return replace(frame, class_ids=tuple(np.where(wrong, "boat", frame.class_ids)))

    world = Confusing(
        robots={
            "one": lambda _t: (0.0, 20.0),
            "other": lambda _t: (5.0, 22.0),
            "third": lambda _t: (-4.0, 25.0),
        },
        pixel_sigma=1.0,
    )
    results = sea.play(sea.estimator(), world, 40.0, images=10)
    names = {one.robot_id for result in results for one in result.estimates}
    assert names == {"aqua_1", "aqua_2", "aqua_3"}
