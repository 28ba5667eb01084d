# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whose name it may be after one encounter or several, with numbers that can be checked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.identity.label_ambiguity import LabelAmbiguity, Position
from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE


def _spot(east, variance=1.0):
    return Position(np.array([east, 0.0]), variance * np.eye(2))


SPOTS = {"a": _spot(0.0), "b": _spot(10.0), "c": _spot(30.0)}


def test_two_encounters_make_a_chain():
    """a met b, then the track called b met c: a's robot may be on any of the three."""
    met = LabelAmbiguity().after_exchange("a", "b", 0.2).after_exchange("b", "c", 0.5)
    assert met.probabilities["a"] == pytest.approx({"a": 0.8, "b": 0.1, "c": 0.1})
    assert met.probabilities["b"] == pytest.approx({"a": 0.2, "b": 0.4, "c": 0.4})
    assert met.probabilities["c"] == pytest.approx({"b": 0.5, "c": 0.5})
    added = met.covariances(SPOTS)
    assert added["a"] == pytest.approx(np.diag([0.1 * 10**2 + 0.1 * 30**2, 0.0]))
    assert added["b"] == pytest.approx(np.diag([0.2 * 10**2 + 0.4 * 20**2, 0.0]))


def test_robots_that_exchange_their_labels_keep_what_is_ambiguous():
    met = LabelAmbiguity().after_exchange("a", "b", 0.2).after_exchange("b", "c", 0.5)
    named = met.renamed({"a": "c", "c": "a"})
    assert named.probabilities["c"] == pytest.approx({"c": 0.8, "b": 0.1, "a": 0.1})
    assert named.probabilities["b"] == pytest.approx({"c": 0.2, "b": 0.4, "a": 0.4})
    assert named.probabilities["a"] == pytest.approx({"b": 0.5, "a": 0.5})


def test_three_in_a_ring():
    """Each robot went on as the next one's track, or all stayed."""
    ring = {"a": {"a": 0.6, "b": 0.4}, "b": {"b": 0.6, "c": 0.4}, "c": {"c": 0.6, "a": 0.4}}
    met = LabelAmbiguity().after_exchange("a", "d", 0.5).after_permutation(ring)
    assert met.probabilities["a"] == pytest.approx({"a": 0.3, "b": 0.2, "d": 0.5})
    assert met.probabilities["d"] == pytest.approx({"a": 0.3, "b": 0.2, "d": 0.5})
    assert met.probabilities["c"] == pytest.approx({"a": 0.4, "c": 0.6})


def test_a_second_even_chance_adds_nothing_and_certainty_is_not_published():
    assert LabelAmbiguity().after_exchange("a", "b", 0.5).after_exchange(
        "a", "b", 0.9
    ).probabilities["a"] == {
        "a": 0.5,
        "b": 0.5,
    }
    assert LabelAmbiguity().after_exchange("a", "b", 1e-4).covariances(SPOTS) == {}


def test_a_track_that_ends_stays_a_possibility():
    met = LabelAmbiguity().after_exchange("a", "b", 0.5)
    met.prune(SPOTS)
    met.prune({"a": _spot(4.0)})
    assert set(met.probabilities) == {"a"}
    added = met.covariances({"a": _spot(4.0)})
    assert added["a"] == pytest.approx(np.diag([0.5 * 6.0**2, 0.0]))


def test_a_robot_that_may_be_one_out_of_sight_is_as_badly_known():
    """Even chances, the other one 6 m off and known to 5 m: half of 6² and of 5² - 1²."""
    met = LabelAmbiguity().after_exchange("a", "b", 0.5)
    added = met.covariances({"a": _spot(0.0), "b": _spot(6.0, 25.0)})
    assert added["a"] == pytest.approx(np.diag([18.0 + 12.0, 12.0]))
    assert added["b"] == pytest.approx(np.diag([18.0, 0.0]))  # never smaller than its track's


def test_a_doubt_too_small_to_matter_is_forgotten():
    met = (
        LabelAmbiguity()
        .after_exchange("a", "b", 0.5 * EVIDENCE.forgotten)
        .after_exchange("b", "c", 2.0 * EVIDENCE.forgotten)
    )
    met.prune(SPOTS)
    assert set(met.probabilities) == {"b", "c"}


def test_a_robot_that_may_have_stayed_where_it_was():
    """By 0.2, 10 m from where its name is now, known to 3 m: 0.2 (10² + 3² - 1²)."""
    met = LabelAmbiguity().after_departure("a", _spot(10.0, 9.0), 0.2)
    met.prune({"a": _spot(0.0)})
    assert met.covariances({"a": _spot(0.0)})["a"] == pytest.approx(np.diag([21.6, 1.6]))
