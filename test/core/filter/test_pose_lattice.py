# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses on a lattice of times: waiting, gaps, and what smoothing keeps."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.filter.pose_lattice import (
    MARGIN,
    STEP_NS,
    TUNING,
    PoseLattice,
    SampledPose,
    smoothed,
)
from aerial_gnss_ros.core.geometry.map_pose import MapPose


def test_a_parabola_is_kept_and_noise_is_not():
    t = 0.1 * np.arange(20.0)
    parabola = np.column_stack([1.0 + 2.0 * t - 3.0 * t**2, t])
    np.testing.assert_allclose(smoothed(parabola), parabola[MARGIN:-MARGIN], atol=1e-12)
    response = smoothed(np.eye(20))
    np.testing.assert_allclose((response**2).sum(axis=1), 1.0 / 3.0)


def test_it_waits_for_telemetry_that_may_come_and_leaves_gaps_open():
    asked, newest = [], [20]

    def pose_at(stamp_ns: int) -> MapPose | bool:
        node = stamp_ns // STEP_NS
        asked.append(node)
        if node > newest[0]:
            return True
        return False if node == 8 else MapPose(np.array([0.5 * node, 0.0, 9.0]), np.eye(3))

    lattice = PoseLattice(50)
    assert not lattice.fill(14, 17, pose_at, False)  # with three neighbours: up to 21
    newest[0] = 21
    assert lattice.fill(14, 17, pose_at, False)
    assert asked == [*range(11, 22), 21]  # each once, the one that lacked once more
    positions, rotations = lattice.between(14, 17, 0.25)
    np.testing.assert_allclose(positions[:, 0], 0.5 * (np.arange(14, 18) + 0.25))
    np.testing.assert_allclose(rotations, np.tile(np.eye(3), (4, 1, 1)), atol=1e-12)
    assert lattice.fill(6, 17, pose_at, False)
    positions, _ = lattice.between(6, 17, 0.0)
    np.testing.assert_array_equal(np.isnan(positions[:, 0]), np.arange(6, 18) < 12)
    assert lattice.fill(14, 30, pose_at, True)
    assert np.isnan(lattice.between(14, 30, 0.0)[0][-1, 0])


def test_the_latest_jumps_are_kept():
    lattice = PoseLattice(50)
    for k in range(TUNING.most_jumps + 2):
        lattice.note_jump(float(k))
    assert lattice.jumps_s == tuple(range(2, TUNING.most_jumps + 2))
    lattice.clear()
    assert lattice.jumps_s == ()


def test_what_interpolation_leaves_lasts_for_the_gap():
    def pose_at(stamp_ns: int) -> MapPose:
        place, turn = np.array([0.0, 0.0, 9.0]), np.eye(3)
        if stamp_ns // STEP_NS != 15:
            return MapPose(place, turn)
        return SampledPose(place, turn, 0.5 * np.arange(6.0))

    lattice = PoseLattice(50)
    assert lattice.fill(30, 33, lambda _ns: MapPose(np.zeros(3), np.eye(3)), False)
    assert lattice.interpolation(30, 33, 0.1) is None
    assert lattice.fill(10, 20, pose_at, False)
    noise = lattice.interpolation(14, 16, 0.1)
    np.testing.assert_allclose(noise, np.outer([0.0, 1.0, 0.0], 5.0 * np.arange(6.0)))
    assert lattice.interpolation(14, 16, 0.0) is None
