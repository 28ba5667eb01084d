# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots swim at their speed, near home, apart from one another, and dive only when asked to."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.robots import Swarm, SwimPlan, fitted

T = np.arange(0.0, 120.0, 0.1)
PLACES = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])


def test_speed_is_constant_and_along_the_course():
    swarm = Swarm(PLACES, SwimPlan(), 1, 0.0, 120.0)
    path, course = swarm.positions(T)[:, :, :2], swarm.courses(T)
    velocity = np.gradient(path, 0.1, axis=1)
    speed = np.linalg.norm(velocity, axis=2)
    np.testing.assert_allclose(speed, np.tile(swarm.speeds[:, None], (1, len(T))), rtol=0.02)
    ahead = np.stack([np.cos(course), np.sin(course)], axis=2)
    assert (np.sum(velocity * ahead, axis=2) > 0.98 * speed).all()
    assert np.abs(np.gradient(course, 0.1, axis=1)).max() <= 0.5 + 1e-9
    assert ((swarm.speeds >= 0.15) & (swarm.speeds <= 0.6)).all()


@pytest.mark.parametrize("seed", range(5))
def test_they_roam_near_home_and_keep_apart(seed):
    path = Swarm(PLACES, SwimPlan(roam_m=4.0), seed, 0.0, 120.0).positions(T)[:, :, :2]
    away = np.linalg.norm(path - PLACES[:, None, :], axis=2)
    assert away.max() < 9.0
    assert away.max() > 1.0
    gaps = [np.linalg.norm(path[i] - path[j], axis=1).min() for i, j in ((0, 1), (0, 2), (1, 2))]
    assert min(gaps) > 0.5  # bodies 0.45 m wide do not pass through one another


def test_still_robots_stay_and_float():
    swarm = Swarm(PLACES, SwimPlan(slowest_mps=0.0, fastest_mps=0.0, heave_m=0.01), 2, 0.0, 120.0)
    path = swarm.positions(T)
    np.testing.assert_array_equal(path[:, :, :2], np.broadcast_to(PLACES[:, None], (3, len(T), 2)))
    assert path[:, :, 2].std() == pytest.approx(0.01, rel=0.4)
    assert swarm.names == ("aqua_1", "aqua_2", "aqua_3")


def test_beacons_stay_and_are_a_class_of_their_own():
    swarm = Swarm(PLACES, SwimPlan(beacons=1), 2, 0.0, 60.0)
    assert swarm.names == ("beacon_1", "aqua_1", "aqua_2")
    assert swarm.class_names == ("beacon", "aqua", "aqua")
    path = swarm.positions(np.array([0.0, 60.0]))[:, :, :2]
    assert (path[0] == PLACES[0]).all()
    assert (np.linalg.norm(path[1:, 1] - path[1:, 0], axis=1) > 0.0).all()
    assert [state.class_name for state in swarm.states(0.0)] == ["beacon", "aqua", "aqua"]


def test_divers_go_under_and_come_back():
    plan = SwimPlan(dives=True, dive_depth_m=3.0, dive_s=12.0, dive_every_s=40.0)
    depth = -Swarm(PLACES, plan, 3, 0.0, 120.0).positions(T)[:, :, 2]
    np.testing.assert_allclose(depth.max(axis=1), 3.0, atol=0.1)
    share_under = (depth > 0.1).mean(axis=1)
    assert ((share_under > 0.15) & (share_under < 0.35)).all()


def test_lengths_and_beginnings_of_varied_dives_are_drawn_as_stated():
    plan = SwimPlan(0.0, 0.0, 4.0, 1.0, 0.0, 0.0, True, 3.0, 50.0, 60.0, shortest_dive_s=10.0)
    t = np.arange(0.0, 1500.0, 0.05)
    places = np.array([[9.0 * i, 9.0 * j] for i in range(3) for j in range(2)])
    depth = -Swarm(places, plan, 5, 0.0, 1500.0).positions(t)[:, :, 2]
    assert np.abs(np.diff(depth)).max() < 0.06  # 1.1 m/s within 5 s at most: no jumps
    lengths, gaps = [], []
    for row in depth:
        edges = np.flatnonzero(np.diff((row > 0.0).astype(int)))[int(row[0] > 0.0) :]
        between = 0.05 * np.diff(edges)
        lengths += list(between[::2])
        gaps += list(between[1::2])
    assert len(lengths) > 140
    assert stats.kstest(lengths, stats.uniform(10.0, 40.0).cdf).pvalue > 0.01
    assert np.mean(gaps) == pytest.approx(30.0, rel=0.1)  # 60 s less 30 s under water
    assert np.std(gaps) > 10.0


def test_the_states_to_render_agree_with_the_positions():
    swarm = Swarm(PLACES, SwimPlan(), 4, -1.0, 10.0)
    for state, place in zip(swarm.states(5.0), swarm.positions([5.0])[:, 0], strict=True):
        assert (state.east, state.north, -state.depth) == pytest.approx(tuple(place))


def test_no_robots_is_a_swarm_too_and_impossible_speeds_are_refused():
    empty = Swarm(np.zeros((0, 2)), SwimPlan(), 1, 0.0, 1.0)
    assert empty.positions([0.0]).shape == (0, 1, 3)
    assert empty.states(0.0) == []
    with pytest.raises(ConfigError, match="slowest not faster"):
        SwimPlan(slowest_mps=1.0, fastest_mps=0.5)


@pytest.mark.parametrize("lengths", [{"dive_s": 50.0}, {"shortest_dive_s": 13.0}, {"dive_s": 0.0}])
def test_dives_that_do_not_fit_are_refused(lengths):
    with pytest.raises(ConfigError, match="end before the next"):
        SwimPlan(dives=True, dive_every_s=40.0, **lengths)


def test_robots_take_turns_with_the_models_and_are_called_after_them():
    swarm = Swarm(PLACES, SwimPlan(models=("torpedo", "box")), 2, 0.0, 10.0)
    assert swarm.names == ("torpedo_1", "box_1", "torpedo_2")
    assert [(s.class_name, s.model) for s in swarm.states(1.0)] == [
        ("torpedo", "torpedo"), ("box", "box"), ("torpedo", "torpedo"),
    ]  # fmt: skip


def test_longer_robots_keep_farther_apart():
    aqua, torpedo = (fitted(SwimPlan(models=(name,)), 5.0).apart_m for name in ("aqua", "torpedo"))
    assert aqua == 0.9
    assert torpedo > 1.6  # its length
