# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Probabilities of labels: each robot is at one point, and a point is one robot."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.image_labels import (
    NO_EVIDENCE,
    LabelEvidence,
    Point,
    label_probabilities,
    labels_of,
    once_each,
    scaled,
)


def point(there=1.0, **names):
    return Point((0.0, 0.0), "aqua", names, 0, there=there)


def test_links_mix_the_labels_of_points():
    points = [point(a=0.8, b=0.2), point(there=0.5, b=0.4)]
    found = label_probabilities(points, np.array([[0.9, 0.1], [0.0, 0.5]]))
    assert found[0] == pytest.approx({"a": 0.72, "b": 0.18})
    assert found[1] == pytest.approx({"a": 0.08, "b": 0.02 + 0.4})  # it is there if it is seen


def test_a_robot_is_at_one_point_or_lost():
    factors = once_each([point(a=0.9)], ("a", "b"), [{"a": 0.9}, {"a": 0.9}])
    assert factors["a"] == pytest.approx(1.0 / 1.9)
    assert factors["b"] == pytest.approx(1.0)  # lost before and after
    assert scaled({"a": 0.9, "b": 1e-4}, factors) == pytest.approx({"a": 0.9 / 1.9})


def test_a_box_that_no_way_leads_to_may_be_a_robot_that_got_lost():
    found = labels_of([point(a=1.0), point()], ("a", "b"))
    assert found[0] == LabelEvidence({"a": 1.0, "b": 0.0}, 0.0)
    assert found[1] == LabelEvidence({"a": 0.0, "b": 1.0}, 1.0)


def test_a_detection_contradicts_a_name_where_it_is_clearly_another_one():
    assert LabelEvidence({"a": 0.99, "b": 0.004}, 0.0).contradicts("b")
    assert not LabelEvidence({"a": 0.99, "b": 0.004}, 0.0).contradicts("a")
    assert not LabelEvidence({"a": 0.9, "b": 0.1}, 0.0).contradicts("b")
    assert not LabelEvidence({"a": 0.99}, 0.01).contradicts("not followed")
    assert not LabelEvidence({"a": 0.01}, 0.99).contradicts("a")  # nobody knows who it is
    assert not NO_EVIDENCE.contradicts("a")
