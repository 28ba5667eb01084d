# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence from the image is compared with the tracks."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from aerial_gnss_ros.core.association.image_labels import LabelEvidence
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.image_evidence import TUNING, ImageEvidence

A, B = LabelEvidence({"a": 0.99, "b": 0.001}, 0.0), LabelEvidence({"a": 0.001, "b": 0.99}, 0.0)


def picture(labels):
    """Return image evidence with these labels of boxes, and a record of its calls."""
    reported = []
    image = SimpleNamespace(
        blind_ns=0,
        expected=lambda _: labels,
        followed=lambda _: reported.append("blind") or labels,
        measured=lambda *given: reported.append(given[-1]) or labels,
    )
    return ImageEvidence(image), reported


def test_a_pair_that_the_picture_contradicts_is_excluded():
    tracks = [Track("aqua", 0, 0, robot_id=name) for name in ("a", "b", "")]
    made, _ = picture({4: B, 5: B, 6: A})
    seen = SimpleNamespace(index=np.array([4, 5, 6]))
    every = np.arange(3)
    excluded = made.cost(tracks, None, seen)[every, every] == TUNING.excluded_cost
    assert excluded.tolist() == [True, False, False]
    assert not picture({})[0].cost(tracks, None, seen).any()


def test_what_the_picture_says_of_a_pair_is_a_likelihood():
    tracks = [Track("aqua", 0, 0, robot_id=name) for name in ("a", "b", "")]
    made, _ = picture({4: B, 5: LabelEvidence({"a": 0.3, "b": 0.6}, 0.1)})
    cost = made.cost(tracks, None, SimpleNamespace(index=np.array([5, 4, 7])))
    excluded = np.exp(-0.5 * TUNING.excluded_cost)
    likelihood = [[0.3, excluded, 1.0], [0.6, 0.99, 1.0], [1.0, 1.0, 1.0]]
    np.testing.assert_allclose(np.exp(-0.5 * cost), likelihood)


def test_images_without_a_pose_are_told():
    made, _ = picture({})
    assert made.blind
    made._image.blind_ns = None
    assert not made.blind


def test_new_tracks_learn_what_the_picture_says_of_them():
    frame = SimpleNamespace(detections=None, camera=None, pose=SimpleNamespace(height=20.0))
    made, reported = picture({0: A, 1: B})
    robot, new, known = (Track("aqua", 0, 0, robot_id=name) for name in ("a", "", ""))
    known.label_evidence = A
    made.label([robot, new, known], {0: 0, 1: 1, 2: 1}, frame, unexplained=True)
    assert (robot.label_evidence, new.label_evidence, known.label_evidence) == (None, B, A)
    made.label([new], {0: 1}, frame, unexplained=False)
    made.label([new], {0: 1}, frame, unexplained=True)
    assert reported == [{0: "a"}, {}, "blind"]
