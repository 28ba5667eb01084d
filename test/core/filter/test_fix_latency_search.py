# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Candidates for the latency of the fix move the camera level, and do not turn it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.fix_latency_search import FixLatencySearch, NearLatencySearch
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers


def search(kind, values=None):
    config = estimator_config(values or {})
    return kind(config, TelemetryBuffers(config))


@pytest.mark.parametrize("latency_s", [0.0, 0.7, -2.9])
def test_candidates_reach_half_a_second_either_way(latency_s):
    for kind in (FixLatencySearch, NearLatencySearch):
        found = search(kind, {"camera.latency_s": latency_s}).corrections
        np.testing.assert_allclose(found[[0, -1]], [-0.5, 0.5], atol=1e-9)
        assert np.abs(found).min() < 1e-9


def test_a_search_goes_on_where_the_latency_of_images_is_set_to_its_limit():
    former = search(FixLatencySearch)
    one = search(FixLatencySearch, {"camera.latency_s": 2.9})
    one.follow(former)
    assert len(one.corrections) == len(one.evidence.gains()) == len(former.corrections)


def test_places_are_of_other_times_and_all_else_is_of_the_image():
    one = search(FixLatencySearch)
    positions = np.stack([np.arange(11.0), 2.0 * np.arange(11.0), 30.0 + np.arange(11.0)], axis=1)
    rotations = np.array([rotation_matrix(np.array([0.0, 0.0, 0.1 * i])) for i in range(11)])
    places, turns = one._cameras(SimpleNamespace(part=slice(0, 11)), positions, rotations)
    np.testing.assert_array_equal(places[:, :2], positions[:, :2])
    np.testing.assert_array_equal(places[:, 2], np.full(11, 35.0))
    np.testing.assert_array_equal(turns, np.broadcast_to(rotations[5], (11, 3, 3)))
    assert positions[0, 2] == 30.0  # what the lattice keeps is not changed
