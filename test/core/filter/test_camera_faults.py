# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots, as a camera sees them that may have turned by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

PLACES = {"a": (-6.0, 17.0), "b": (5.0, 18.0), "c": (1.0, 26.0)}
HEIGHT_M = 30.0


def flown(sea, values=None, seconds=3.0):
    """Return the tracker of an estimator that has seen three robots."""
    world = sea.World(
        robots={name: (lambda _t, place=place: place) for name, place in PLACES.items()},
        pixel_sigma=0.5,
    )
    engine = sea.estimator(values)
    sea.play(engine, world, seconds, until_flush=False)
    return engine._pipeline.tracking


def seen(tracker):
    """Return the rows of the three robots, in the order of their names."""
    rows = {track.robot_id: row for row, track in enumerate(tracker.table.tracks)}
    return np.array([rows[f"aqua_{i}"] for i in (1, 2, 3)])


def places(tracker):
    """Return where they are (3, 2), m."""
    return tracker.table.filter.moments()[0][seen(tracker), :2]


def turned(tracker, degrees):
    """Return by how much a turn about the vertical displaces them (3, 2), m."""
    angle = math.radians(degrees)
    return angle * np.column_stack([-places(tracker)[:, 1], places(tracker)[:, 0]])


def test_a_turn_of_the_camera_is_told_from_robots_that_swerve(sea):
    tracker = flown(sea)
    joint, rows, variances = tracker.table.filter, seen(tracker), np.full(3, 0.01)
    common = turned(tracker, 2.0)
    own = common * np.array([[1.0], [-1.0], [1.0]])
    assert joint.turned_by(rows, common, variances) > 3.0
    assert joint.turned_by(rows, own, variances) < 0.0


def test_robots_are_told_by_their_formation_when_all_are_displaced(sea):
    """Three tracks that lie as the robots do, turned by 20 deg about the camera's place."""
    tracker = flown(sea)
    joint, rows = tracker.table.filter, seen(tracker)
    angle = math.radians(20.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    joint.separations = lambda old, new: (
        (places(tracker) @ turn.T)[None, new] - places(tracker)[: len(old), None],
        np.tile(0.02 * np.eye(2), (len(old), len(new), 1, 1)),
    )
    found = joint.formation(rows.tolist(), [2, 0, 1], np.zeros((2, 2)), np.ones((3, 3), bool))
    assert sorted(found.pairs) == [(0, 1), (1, 2), (2, 0)]
    assert found.moved
    assert np.degrees(np.linalg.norm(found.turn)) == pytest.approx(20.0, abs=2.0)
    kept = joint.formation(rows.tolist(), [2, 0, 1], np.zeros((2, 2)), np.eye(3, dtype=bool))
    assert kept is None or sorted(kept.pairs) != sorted(found.pairs)


def test_each_class_has_its_own_speed_in_doubt(sea):
    tracker = flown(sea, {"classes.buoy.max_speed": 0.2})
    joint = tracker.table.filter
    default = joint.motions.default_speed
    assert joint.speeds(seen(tracker)) == pytest.approx([default] * 3)
    alike = flown(sea)
    assert alike.table.filter.speeds(seen(alike)) == alike.table.filter.motions.default_speed


def test_robots_are_in_doubt_while_a_turn_may_have_displaced_them_until_they_return(sea):
    tracker = flown(sea)
    joint = tracker.table.filter
    turn = np.array([0.0, 0.0, math.radians(5.0)])
    joint.update_ambiguity(0.1)
    joint.note_displacement(turn, 1e-6 * np.eye(3), 4.0)
    assert joint.ambiguity.active
    assert joint.ambiguity.apart == 4.0
    assert np.diag(joint.ambiguity.covariance) == pytest.approx([1e-6, 1e-6, turn[2] ** 2 + 1e-6])
    joint.note_return()
    assert joint.ambiguity.apart == 0.0
    assert not joint.ambiguity.covariance.any()
    assert any("Robots are back at their positions" in one for one in joint.log.drain())
