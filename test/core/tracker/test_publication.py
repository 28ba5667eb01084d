# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is published: robots by their labels, with all that may be in the covariance."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.tracker.publication import published, with_white
from aerial_gnss_ros.core.values.estimates import MapDatum, State

LOCAL = LocalMap(MapDatum(0.8, 0.2, 0.0))
CERTAIN = SimpleNamespace(ambiguous=False)
NO_REFERENCES = SimpleNamespace(apply=lambda *_: None)


def table(*labels):
    """Return tracks under labels, each 10 m north of the one before, exact to 1 m."""
    tracks = [Track("aqua", 0, 5, State.CONFIRMED, name) for name in labels]
    mean = np.zeros((len(labels), 4))
    mean[:, 1] = 10.0 * np.arange(len(labels))
    joint = SimpleNamespace(
        moments=lambda: (mean.copy(), np.tile(np.eye(4), (len(labels), 1, 1))),
        add_fault_covariances=lambda *_: None,
        platform=(np.arange(float(COUNT)), np.diag([4.0, *[0.0] * 8])),
    )
    moored = SimpleNamespace(publish=lambda *_: None)
    joint.laws, joint.groups = SimpleNamespace(moored=moored), []
    joint.trajectory = SimpleNamespace(view=None)
    return SimpleNamespace(tracks=tracks, filter=joint)


def test_robots_with_labels_come_in_their_order():
    found, _ = published(table("aqua_2", "", "aqua_1"), CERTAIN, None, NO_REFERENCES, LOCAL, 3.0, 7)
    assert [(one.robot_id, one.position[1]) for one in found] == [("aqua_1", 20.0), ("aqua_2", 0.0)]
    assert found[0].latitude - found[1].latitude == pytest.approx(20.0 / 6.37e6, rel=0.01)
    assert {(one.stamp_ns, one.last_seen_ns, one.altitude) for one in found} == {(7, 5, 3.0)}
    nobody, platform = published(table("", ""), CERTAIN, None, NO_REFERENCES, LOCAL, 3.0, 7)
    assert nobody == ()
    assert [(one.name, one.sigma) for one in platform] == [("gnss_east", 2.0)]


def test_covariances_contain_another_label_and_robots_as_they_were():
    doubtful = SimpleNamespace(
        ambiguous=True, ambiguity_covariances=lambda _: {"aqua_2": np.diag([4.0, 0.0])}
    )
    fork = SimpleNamespace(apart=lambda *_: {"aqua_1": np.array([0.0, 3.0])})
    labelled = table("aqua_2", "aqua_1")
    found, _ = published(labelled, doubtful, fork, NO_REFERENCES, LOCAL, 0.0, 7)
    assert found[0].covariance.diagonal().tolist() == [1.0, 10.0, 1.0, 1.0]
    assert found[1].covariance.diagonal().tolist() == [5.0, 1.0, 1.0, 1.0]


def test_references_move_robots_and_the_receiver_s_offset():
    def apply(_tracks, mean, covariance, _stamp_ns):
        mean[:, 0] += 5.0
        covariance[:, 0, 0] = 0.25
        return np.full(COUNT, 5.0), np.diag([0.25, *[0.0] * 8])

    known, told = SimpleNamespace(apply=apply, published=None, turned=lambda *_: {}), []
    seen = table("aqua_1")
    seen.filter.add_fault_covariances = lambda _, turned: told.append(turned)
    found, platform = published(seen, CERTAIN, None, known, LOCAL, 0.0, 7)
    assert told == [known.turned]
    assert found[0].position.tolist() == [5.0, 0.0]
    assert found[0].covariance[0, 0] == 0.25
    assert [(one.name, one.value, one.sigma) for one in platform] == [("gnss_east", 5.0, 0.5)]


def test_what_is_not_white_is_shared_whatever_it_comes_from():
    seen = table("aqua_2", "", "aqua_1")
    seen.filter.given_platform = lambda: np.array([4.0, 9.0, 0.25])[:, None, None] * np.eye(2)
    doubtful = SimpleNamespace(
        ambiguous=True, ambiguity_covariances=lambda _: {"aqua_1": np.diag([8.0, 0.0])}
    )
    found, _ = published(seen, doubtful, None, NO_REFERENCES, LOCAL, 0.0, 7)
    first, second = with_white(found, seen)
    assert first.white.diagonal().tolist() == [0.25, 0.25]  # the other label's 8 m² are not in it
    assert second.white.diagonal() == pytest.approx([1.0, 1.0])  # not above what is published
    assert with_white((), seen) == ()
