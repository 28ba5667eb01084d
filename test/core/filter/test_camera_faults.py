# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots, as a camera sees them that may have turned by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytestmark = pytest.mark.flights

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
    return engine._tracks.pipeline.tracking


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


def test_a_turn_of_the_camera_is_distinguished_from_robots_that_swerve(sea):
    tracker = flown(sea)
    joint, rows, variances = tracker.table.filter, seen(tracker), np.full(3, 0.01)
    common = turned(tracker, 2.0)
    own = common * np.array([[1.0], [-1.0], [1.0]])
    assert joint.turned_by(rows, common, variances) > 3.0
    assert joint.turned_by(rows, own, variances) < 0.0


def test_robots_are_identified_by_their_formation_when_all_are_displaced(sea):
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


def dived(sea, up_m=0.0, heading_deg=0.0, dive_s=7.0, surface_s=10.0, back_s=99.0, clutter=0.0):
    """Return positions, true ones by name, and the engine: height or compass jump at 8 s."""
    robots = {name: (lambda _t, place=place: place) for name, place in PLACES.items()}
    world = sea.World(robots=robots, pixel_sigma=0.5)
    world.hidden = lambda _name, t: dive_s <= t < surface_s
    engine, height = sea.estimator(), world.height
    before = sea.play(engine, world, 8.0, images=10, until_flush=False)
    own = {
        one.robot_id: min(PLACES.values(), key=lambda at, one=one: np.hypot(*(one.position - at)))
        for one in before[60].estimates
    }
    assert len(own) == 3
    world.clutter = clutter
    wrong = lambda t: float(8.05 < t < back_s)  # noqa: E731
    world.height = lambda t: type(height(t))(height(t).stamp_ns, height(t).value + up_m * wrong(t))
    gimbal = world.gimbal

    def orientation(t):
        world.rpy_bias_deg = (0.0, 0.0, heading_deg * wrong(t))
        return gimbal(t)

    world.gimbal = orientation
    after = sea.play(engine, world, 6.0, begin=8.1, images=10)
    return after, own, engine._tracks.pipeline.tracking


@pytest.mark.parametrize(("up_m", "heading_deg"), [(4.0, 0.0), (-4.0, 0.0), (0.0, 25.0)])
def test_covariances_contain_a_jump_of_which_no_robot_in_view_tells(sea, up_m, heading_deg):
    """Robots dive, height or compass jump, and robots surface: where, nobody can know."""
    after, own, _ = dived(sea, up_m, heading_deg)
    for result in after:
        for one in result.estimates:
            if one.robot_id in own:
                error = one.position - own[one.robot_id]
                assert error @ np.linalg.solve(one.covariance[:2, :2], error) < 9.0


def test_a_height_displaces_robots_in_proportion_to_their_distance(sea):
    """By 4 m of 30 m: the farthest robot by 4/30 of its distance from the drone."""
    _, _, tracker = dived(sea, up_m=4.0, surface_s=99.0)
    farthest = max(np.hypot(*place) for place in PLACES.values())
    apart = math.sqrt(tracker.table.filter.ambiguity.apart)
    assert apart == pytest.approx(4.0 / 30.0 * farthest, rel=0.2)


@pytest.mark.parametrize(
    "more", [{"dive_s": 8.05}, {"dive_s": 6.0, "clutter": 5.0}], ids=["no box", "only false boxes"]
)
def test_an_image_without_a_robot_that_could_be_in_view_tells_nothing(sea, more):
    _, _, tracker = dived(sea, up_m=4.0, surface_s=99.0, **more)
    assert tracker.table.filter._climbed == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("up_m", "more"),
    [(4.0, {"back_s": 9.0}), (4.0, {"back_s": 12.0}), (0.7, {}), (4.0, {"dive_s": 9.0})],
    ids=["back unseen", "back in view", "as stated", "in view"],
)
def test_a_height_that_is_right_again_or_was_seen_to_jump_adds_nothing(sea, up_m, more):
    _, _, tracker = dived(sea, up_m, **more)
    assert tracker.table.filter._climbed == pytest.approx(0.0, abs=0.8)
    assert not tracker.table.filter.ambiguity._climbed


@pytest.mark.parametrize(("step_m", "matters"), [(0.8, False), (-0.8, False), (1.2, True)])
def test_a_jump_of_the_height_counts_beyond_three_sigmas(sea, step_m, matters):
    """Of 0.39 m each, for 0.3 m stated: covariances contain smaller ones."""
    joint = flown(sea).table.filter
    joint.trajectory.motion.height_jump = step_m
    joint.note_jump(unseen=False)
    assert not joint.ambiguity.apart
    joint.note_jump(unseen=True)
    assert bool(joint.ambiguity.apart) is matters


@pytest.mark.parametrize("unseen", [True, False])
def test_a_jump_of_the_orientation_that_robots_see_is_theirs_to_judge(sea, unseen):
    joint = flown(sea).table.filter
    joint.ambiguity.update_jump(np.radians([0.0, 0.0, 25.0]), 0.1)
    joint.orientation_jumped = True
    joint.note_jump(unseen)
    assert joint.ambiguity.covariance.any() == unseen


def test_robots_and_all_laws_move_to_another_place_of_the_receiver(sea):
    joint = flown(sea).table.filter
    before, told = joint.moments()[0].copy(), []
    joint.laws.shift = lambda jump: told.append(jump.tolist())
    joint._follow_jump(np.array([3.0, -4.0, 0.0]))
    np.testing.assert_allclose(
        joint.moments()[0][:, :2] - before[:, :2], [[3.0, -4.0]] * len(before)
    )
    assert told == [[3.0, -4.0]]
