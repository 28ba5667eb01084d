# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots in several groups answer by row as if they were in one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter import blocks
from aerial_gnss_ros.core.filter.blocks import StateBlocks
from aerial_gnss_ros.core.models.platform_model import COUNT


@pytest.fixture
def five(monkeypatch):
    """Robot i stands at (i, 2 i), known to 1 m² + i; groups of two."""
    monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=2))
    groups = StateBlocks()
    groups.clear(np.eye(COUNT))
    for group, rows, columns in groups.allocate(np.arange(5)):
        places = np.stack([columns, 2.0 * columns], axis=1)
        white = np.eye(2) * (1.0 + columns)[:, None, None]
        group.add(rows, places, np.zeros((len(rows), 2, COUNT)), white, 0.5)
    return groups


def _east(groups):
    return groups.moments()[0][:, 0].tolist()


def test_rows_keep_their_order_whatever_group_they_are_in(five):
    assert len(five) == 5
    assert len(five._groups) == 3
    assert _east(five) == [0, 1, 2, 3, 4]
    assert five.moments()[1][:, 0, 0] == pytest.approx([1, 2, 3, 4, 5])


def test_rows_after_a_dropped_one_move_up_and_its_room_is_used(five):
    five.drop(np.array([1, 2, 3]))
    assert _east(five) == [0, 4]
    for group, rows, _ in five.allocate(np.arange(1)):
        group.add(rows, np.array([[9.0, 9.0]]), np.zeros((1, 2, COUNT)), np.eye(2)[None], 0.5)
    assert _east(five) == [0, 4, 9]
    assert len(five._groups) == 2


def test_offsets_between_groups_add_what_is_unsure(five):
    offsets, spread = five.separations(np.array([0, 3]), np.array([4]))
    assert offsets[:, 0].tolist() == [[4.0, 8.0], [1.0, 2.0]]
    assert spread[:, 0, 0, 0] == pytest.approx([1 + 5, 4 + 5])


def test_only_robots_named_are_loosened(five):
    five.inflate_velocities(np.array([3]), 1.0, 2.0)
    assert five.moments()[1][:, 0, 0] == pytest.approx([1, 2, 3, 4 + 4, 5])


def _crowd(size, monkeypatch):
    """Return five robots with much in common through the platform, in groups of `size`.

    Robot 0 has been followed for long: its velocity is known. Robot 4 is new.
    """
    monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=size))
    groups = StateBlocks()
    groups.clear(
        np.diag([1.4, 1.4, 0.1, 1e-4, 1e-4, 7e-4, 1e-4, 1e-4, 0.0])
    )  # the latency is known
    rng = np.random.default_rng(7)
    state, by_platform = rng.normal(size=(5, 4)), rng.normal(size=(5, 4, COUNT))
    state[4, :2] = state[0, :2] + [0.2, -0.1]
    own = np.array([np.diag([0.3, 0.2, v, v]) for v in (0.01, 0.5, 0.5, 0.5, 0.5)])
    own[0, 0, 2] = own[0, 2, 0] = 0.02
    for group, rows, columns in groups.allocate(np.arange(5)):
        group.append(rows, state[columns], by_platform[columns], own[columns])
    first = groups._groups[0]
    first.unseen[0], first.manoeuvre_noise.strength[0] = 1.5, 4.0
    first.velocity_changes._sums[:, 0] = np.arange(6.0)
    return groups


def test_a_robot_takes_over_its_history_from_another_group_as_within_one(monkeypatch):
    """With the same platform in both groups, being in two of them makes no difference."""
    found = []
    for size in (5, 2):
        groups = _crowd(size, monkeypatch)
        groups.merge(0, 4)
        assert len(groups._groups) == (1 if size == 5 else 3)
        assert len(groups) == 5
        group = groups._groups[-1]
        mean, covariance = groups.moments()
        found.append((mean[4], covariance[4], group.manoeuvre_noise.strength[-1],
                      group.velocity_changes._sums[:, -1], group.mean[:COUNT],
                      group.covariance[:COUNT, :COUNT]))  # fmt: skip
    for whole, parted in zip(*found, strict=True):  # as exact as `inverse_of_errors`
        np.testing.assert_allclose(parted, whole, rtol=1e-6, atol=1e-6)
    assert found[0][2] == 4.0
    assert found[1][1][2, 2] < 0.55 * _crowd(2, monkeypatch).moments()[1][4, 2, 2]


def test_a_history_from_another_group_counts_by_the_own_platform(monkeypatch):
    """Where the groups differ on the platform's errors, the robot is where its own group has it."""
    groups = _crowd(2, monkeypatch)
    before, after = groups._groups[0], groups._groups[-1]
    moved = np.array([0.5, -0.3, 0.1, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
    by_platform = before.covariance[COUNT : COUNT + 4, :COUNT] / np.where(
        np.diag(before.covariance)[:COUNT], np.diag(before.covariance)[:COUNT], 1.0
    )
    after.mean[:COUNT] += moved
    after.mean[COUNT : COUNT + 2] = before.mean[COUNT : COUNT + 2] + by_platform[:2] @ moved
    place, platform = after.mean[COUNT : COUNT + 2].copy(), after.mean[:COUNT].copy()
    groups.merge(0, 4)
    np.testing.assert_allclose(after.mean[COUNT : COUNT + 2], place, atol=1e-6)
    np.testing.assert_allclose(after.mean[:COUNT], platform, atol=1e-6)


def test_the_old_robot_stays_as_it_is_until_it_is_dropped(monkeypatch):
    groups = _crowd(2, monkeypatch)
    mean, covariance = groups.moments()
    groups.merge(0, 4)
    np.testing.assert_array_equal(groups.moments()[0][:4], mean[:4])
    np.testing.assert_array_equal(groups.moments()[1][:4], covariance[:4])
    groups.drop(np.array([0]))
    assert len(groups) == 4


@pytest.mark.parametrize("heading", [0.0, 1e-4])
def test_given_the_platform_s_errors_only_the_robots_own_part_is_left(heading, monkeypatch):
    monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=2))
    groups = StateBlocks()
    groups.clear(np.diag([4.0, 9.0, 1.0, 0.01, 0.01, heading, 0.0, 0.0, 0.0]))
    own = np.array([[[0.4, 0.1], [0.1, 0.9]], [[2.0, 0.0], [0.0, 1.0]], [[0.01, 0.0], [0.0, 0.04]]])
    by_errors = np.random.default_rng(2).normal(size=(3, 2, COUNT))
    for group, rows, taken in groups.allocate(np.arange(3)):
        group.add(rows, np.zeros((len(rows), 2)), by_errors[taken], own[taken], 0.5)
    assert groups.moments()[1][:, 0, 0].min() > 3.0
    assert groups.given_platform() == pytest.approx(own, rel=1e-5, abs=1e-5)


def test_a_rotation_leaves_robots_in_view_as_uncertain_as_references_tell(five, monkeypatch):
    """Its 4 m² become what is told where that is less; one out of view keeps them."""
    monkeypatch.setattr(blocks, "by_angles", lambda _group, slots: np.zeros((len(slots), 2, 3)))
    five.rotation_fault.doubted = True
    for group in five._groups:
        group.velocity_changes.position_covariances[:] = 4.0 * np.eye(2)
    five._groups[2].unseen[0] = 1.0
    told = {0: 1.0 * np.eye(2), 2: 9.0 * np.eye(2), 4: 1.0 * np.eye(2)}
    widened = np.zeros((5, 4, 4))
    five.add_fault_covariances(widened, lambda _by_angles, _angles: told)
    assert widened[:, 0, 0].tolist() == [1.0, 4.0, 4.0, 4.0, 4.0]
    assert five._groups[0].velocity_changes.position_covariances[0, 0, 0] == 4.0
    alone = np.zeros((5, 4, 4))
    five.add_fault_covariances(alone)
    assert alone[:, 1, 1].tolist() == [4.0] * 5
