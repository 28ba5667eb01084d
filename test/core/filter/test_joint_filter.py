# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The joint filter in flight: groups, jumps, a spinning compass, wrong noise, honest covariance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter import blocks
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.models.platform_model import ANGLES
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

RING = {
    f"r{i}": (lambda _t, i=i: (6.0 * math.cos(i), 20.0 + 4.0 * math.sin(1.7 * i))) for i in range(6)
}
ORBIT = {
    "drone": lambda t: (28.0 * math.cos(0.15 * t), 20.0 + 28.0 * math.sin(0.15 * t), 30.0),
    "rpy_deg": lambda t: (0.0, 47.0, math.degrees(0.15 * t) + 180.0),
}
RTK = {
    "noise.gnss_offset_m": 0.02,
    "camera.find_latency": False,  # on an even circle images tell nothing of it
}


def _errors(world, results, sea):
    """Return by name the errors of the last image, each from the nearest robot, m."""
    t = (results[-1].stamp_ns - sea.stamp(0.0)) * 1e-9
    places = np.array([place(t) for place in world.robots.values()])
    return {
        e.robot_id: float(np.linalg.norm(places - e.position, axis=1).min())
        for e in results[-1].estimates
    }


def test_an_orbit_tells_the_compass_from_the_robots(sea):
    """3 deg of heading are 1.9 m at 36 m; flown round, they are nothing."""
    world = sea.World(
        robots={"a": lambda _t: (2.0, 21.0), "b": lambda _t: (-3.0, 18.0)},
        rpy_bias_deg=(0.0, 0.3, 3.0), pixel_sigma=1.0, **ORBIT,
    )  # fmt: skip
    engine = sea.estimator(RTK | {"noise.robot_acceleration": 0.01})
    start = sea.play(engine, world, 1.0, until_flush=False)
    assert min(_errors(world, start, sea).values()) > 1.0
    results = sea.play(engine, world, 40.0, begin=1.1)
    assert max(_errors(world, results, sea).values()) < 0.15
    sigmas = [math.sqrt(np.linalg.eigvalsh(e.covariance[:2, :2])[-1])
              for e in results[-1].estimates]  # fmt: skip
    assert 0.02 < max(sigmas) < 0.3


def test_of_pairs_together_each_is_as_uncertain_as_alone(sea, monkeypatch):
    alone, checked = JointFilter.compare, []

    def compare(self, seen, *rest):
        found = alone(self, seen, *rest)
        count = len(found.rows)
        together = self.compare_jointly(seen, found).reshape(count, 2, count, 2)
        every = np.arange(count)
        np.testing.assert_allclose(together[every, :, every], found.spread, rtol=1e-9)
        checked.append(count)
        return found

    monkeypatch.setattr(JointFilter, "compare", compare)
    world = sea.World(robots=RING, rpy_bias_deg=(0.3, 0.3, 3.0), pixel_sigma=1.0, **ORBIT)
    sea.play(sea.estimator(RTK), world, 2.0)
    assert max(checked) > len(RING)


def test_boxes_that_counted_too_much_are_made_good_once(sea):
    """When noise proves nine times larger, all but the prior is a ninth as well known."""
    world = sea.World(
        robots={"a": lambda _t: (2.0, 21.0), "b": lambda _t: (-3.0, 18.0)}, pixel_sigma=1.0, **ORBIT
    )  # fmt: skip
    engine = sea.estimator(RTK | {"noise.robot_acceleration": 0.01})
    sea.play(engine, world, 20.0, until_flush=False)
    joint = engine._tracks.pipeline.tracking.table.filter
    heading = ANGLES.stop - 1

    def told() -> float:
        return 1.0 / joint.platform[1][heading, heading] - 1.0 / joint.stationary[heading, heading]

    before = told()
    joint.noise.underestimated = 9.0
    sea.play(engine, world, 0.1, begin=20.1, until_flush=False)
    assert 3.0 < before / told() < 9.5  # the next boxes tell again
    assert joint.noise.take_underestimated() == 1.0


def test_groups_of_robots_lose_little(sea, monkeypatch):
    """Two robots a group instead of all six in one: the same names, nearly the same covariance."""
    last = {}
    for size in (32, 2):
        monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=size))
        world = sea.World(robots=RING, rpy_bias_deg=(0.2, 0.3, 1.5), pixel_sigma=2.0, **ORBIT)
        engine = sea.estimator(RTK)
        results = sea.play(engine, world, 20.0)
        last[size] = results[-1].estimates
        assert max(_errors(world, results, sea).values()) < 0.8
    assert [e.robot_id for e in last[2]] == [e.robot_id for e in last[32]]
    area = {
        size: np.mean([np.linalg.det(e.covariance[:2, :2]) ** 0.25 for e in estimates])
        for size, estimates in last.items()
    }
    assert area[32] <= area[2] < 1.6 * area[32]


def test_a_jump_of_the_receiver_and_back_changes_nothing(sea):
    world = sea.World(robots=RING, pixel_sigma=1.0)
    engine = sea.estimator()
    sea.play(engine, world, 4.0, until_flush=False)
    world.gnss_bias = (30.0, -40.0)
    during = sea.play(engine, world, 1.0, begin=4.1, until_flush=False)
    assert {e.state for e in during[-1].estimates} == {State.CONFIRMED}
    assert max(_errors(world, during[-1:], sea).values()) < 0.5  # the jump is taken out
    world.gnss_bias = (0.0, 0.0)
    results = sea.play(engine, world, 2.0, begin=5.3)
    assert len({e.robot_id for r in during + results for e in r.estimates}) == 6
    assert {e.state for e in results[-1].estimates} == {State.CONFIRMED}
    assert max(_errors(world, results, sea).values()) < 0.5
    assert any("jumped by 50.0 m" in sentence for sentence in engine.events)
    assert any("and is back" in sentence for sentence in engine.events)


def test_a_jump_that_stays_is_followed_but_not_trusted(sea):
    world = sea.World(robots=RING, pixel_sigma=1.0)
    engine = sea.estimator()
    sea.play(engine, world, 4.0, until_flush=False)
    world.gnss_bias = (30.0, -40.0)
    results = sea.play(engine, world, 8.0, begin=4.1)
    assert len(results[-1].estimates) == 6
    for estimate in results[-1].estimates:
        assert estimate.state is State.CONFIRMED
        assert estimate.robot_id in {f"aqua_{i}" for i in range(1, 7)}
        error = estimate.position - (30.0, -40.0)  # where they seem to be now, near the ring
        assert np.linalg.norm(error - (0.0, 20.0)) < 8.0
        # 50 m of error lie within two sigma of what is said
        assert math.sqrt(np.linalg.eigvalsh(estimate.covariance[:2, :2])[-1]) > 25.0


def test_a_spinning_compass_makes_no_confident_position(sea):
    world = sea.World(robots=RING, pixel_sigma=1.0)
    engine = sea.estimator()
    sea.play(engine, world, 4.0, until_flush=False)
    steady = world.rpy_bias_deg
    spun = []
    for i in range(40):
        world.rpy_bias_deg = (0.0, 0.0, 9.0 * i)
        spun += sea.play(engine, world, 0.1, begin=4.2 + 0.2 * i, until_flush=False)
    world.rpy_bias_deg = steady
    results = sea.play(engine, world, 3.0, begin=12.4)
    for result in spun:
        for estimate in result.estimates:
            error = min(
                np.linalg.norm(estimate.position - np.array(place(0.0)))
                for place in world.robots.values()
            )
            sigma = math.sqrt(np.linalg.eigvalsh(estimate.covariance[:2, :2])[-1])
            assert error < 4.0 * sigma
    assert {e.state for e in results[-1].estimates} == {State.CONFIRMED}
    assert {e.robot_id for e in results[-1].estimates} == {f"aqua_{i}" for i in range(1, 7)}


@pytest.mark.parametrize("turn_deg_s", [-60.0, 20.0, 36.0])
def test_a_gimbal_that_turns_by_itself_makes_no_robot_fast(sea, turn_deg_s):
    """Two robots cannot outvote it; but no robot is as fast as it makes them."""
    robots = {"a": lambda _t: (2.0, 21.0), "b": lambda t: (-3.0 + 0.3 * t, 10.0)}
    # Values that are equal to the last bit between two steps would only be old ones.
    rpy_deg = lambda t: (1e-6 * t, 60.0, 90.0)  # noqa: E731
    world = sea.World(robots=robots, rpy_deg=rpy_deg, pixel_sigma=1.0)
    engine = sea.estimator()
    before = sea.play(engine, world, 6.0, until_flush=False)
    of = {
        e.robot_id: min(robots, key=lambda name: np.linalg.norm(e.position - robots[name](6.0)))
        for e in before[-1].estimates
    }
    spun = []
    for i in range(40):
        world.rpy_bias_deg = (0.0, 0.0, 0.2 * turn_deg_s * i)
        spun += sea.play(engine, world, 0.1, begin=6.2 + 0.2 * i, until_flush=False)
    world.rpy_bias_deg = (0.0, 0.0, 0.0)
    results = sea.play(engine, world, 4.0, begin=14.4)
    for result in spun + results:
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        for estimate in result.estimates:
            place = np.array(robots[of[estimate.robot_id]](t))
            offset = estimate.position - place
            squared = offset @ np.linalg.solve(estimate.covariance[:2, :2], offset)
            assert squared < 25.0
    assert {e.robot_id for e in results[-1].estimates} == {"aqua_1", "aqua_2"}
    assert {e.state for e in results[-1].estimates} == {State.CONFIRMED}


def test_false_boxes_are_seldom_a_camera_that_turns(sea):
    """One robot dives after the other; for 7 s false boxes are all there is."""
    robots = {"a": lambda _t: (2.0, 21.0), "b": lambda t: (-3.0 + 0.3 * t, 10.0)}
    world = sea.World(robots=robots, pixel_sigma=1.0, missed=0.15, clutter=1.5, seed=3)
    world.hidden = lambda name, t: 0.0 < t - {"a": 15.0, "b": 18.0}[name] < 10.0
    engine = sea.estimator()
    results = sea.play(engine, world, 40.0, images=15)
    spread = np.array([
        np.trace(one.covariance[:2, :2])
        for result in results for one in result.estimates if one.state is State.CONFIRMED
    ])  # fmt: skip
    assert np.mean(spread > 3.0 * np.median(spread)) < 0.02


@pytest.mark.parametrize(("factor", "alarms"), [(1.0, False), (2.0, True)])
def test_the_monitor_tells_noise_that_is_understated_by_two(sea, factor, alarms):
    world = sea.World(robots=RING, pixel_sigma=2.0 * factor, seed=5)
    engine = sea.estimator({"noise.gimbal_white_deg": 0.0, "noise.gnss_white_m": 0.0,
                            "noise.height_white_m": 0.0})  # fmt: skip
    sea.play(engine, world, 15.0)
    assert any("times as far" in sentence for sentence in engine.events) is alarms


@pytest.mark.parametrize("factor", [1.0, 5.0])
def test_compass_and_gimbal_are_doubted_where_boxes_are_noisier_than_stated(sea, factor):
    """A hover tells little of them."""
    world = sea.World(robots=RING, pixel_sigma=2.0 * factor, seed=3)
    results = sea.play(sea.estimator(), world, 12.0, images=5)
    sigmas = {error.name: error.sigma for error in results[-1].platform}
    for name, stated in (("heading", 1.5), ("roll", 0.4), ("pitch", 0.4)):
        assert (sigmas[name] > 1.3 * math.radians(math.sqrt(5.0 / 3.0) * stated)) == (factor > 1.0)


def test_a_biased_compass_is_named(sea):
    world = sea.World(robots=RING, rpy_bias_deg=(0.0, 0.0, 9.0), pixel_sigma=1.0, **ORBIT)
    engine = sea.estimator(RTK)
    sea.play(engine, world, 40.0)
    assert any("heading seems to need a correction of" in sentence for sentence in engine.events)
    assert any(
        "heading seems to need a correction of" in sentence for sentence in engine.health.complaints
    )


@pytest.mark.parametrize("late_s", [0.5, -0.5])
def test_a_latency_that_nobody_stated_is_noticed(sea, late_s):
    """A drone that swings to and fro at 6 m/s: half a second is 3 m back and forth."""
    drone = lambda t: (12.0 * math.sin(0.5 * t), 0.0, 30.0)  # noqa: E731
    world = sea.World(drone=drone, robots=RING, pixel_sigma=1.0)
    seen = sea.World(drone=lambda t: drone(t - late_s), robots=RING, pixel_sigma=1.0)
    world.frame = seen.frame
    engine = sea.estimator(RTK | {"camera.find_latency": False, "fix.find_latency": False})
    sea.play(engine, world, 20.0, telemetry=50)
    assert any("camera.latency_s" in sentence for sentence in engine.health.complaints)


def test_nothing_measured_twice_and_nothing_not_a_number(sea):
    """A hundred robots, NaN boxes among them: estimates stay finite and positive definite."""
    rng = np.random.default_rng(2)
    places = rng.uniform((-18.0, 8.0), (18.0, 40.0), (100, 2))
    world = sea.World(
        robots={str(i): (lambda _t, i=i: tuple(places[i])) for i in range(100)}, pixel_sigma=1.0
    )
    plain = world.frame

    def frame(t):
        seen = plain(t)
        centers = np.vstack([seen.centers, [[np.nan, 100.0], [np.inf, -np.inf]]])
        return sea.boxes(t, centers)

    world.frame = frame
    results = sea.play(sea.estimator(), world, 2.0)
    assert len(results[-1].estimates) > 60
    for estimate in results[-1].estimates:
        assert np.isfinite(estimate.position).all()
        assert np.linalg.eigvalsh(estimate.covariance).min() > 0.0


@pytest.mark.parametrize("late_s", [0.4, -0.3])
def test_a_drone_that_turns_back_tells_the_latency(sea, late_s):
    """Images stamped t show t - late: found to 0.05 s from robots that stay."""
    drone = lambda t: (12.0 * math.sin(0.5 * t), 0.0, 30.0)  # noqa: E731
    world = sea.World(
        drone=drone, robots={"a": lambda _t: (2.0, 18.0), "b": lambda _t: (-3.0, 22.0)},
        pixel_sigma=1.0,
    )  # fmt: skip
    seen = sea.World(drone=lambda t: drone(t - late_s), robots=world.robots, pixel_sigma=1.0)
    world.frame = seen.frame
    engine = sea.estimator(RTK | {"noise.latency_s": 0.5, "noise.robot_acceleration": 0.01})
    results = sea.play(engine, world, 30.0, telemetry=50)
    while not results[-1].platform:  # the last images lack telemetry that would come later
        results.pop()
    found = {error.name: error for error in results[-1].platform}["latency"]
    assert found.value == pytest.approx(late_s, abs=0.05)
    assert found.sigma < 0.05
    assert max(_errors(world, results, sea).values()) < 0.5


def test_moored_robots_are_sought_unless_that_is_switched_off():
    assert JointFilter(estimator_config({})).laws.moored is not None
    assert JointFilter(estimator_config({"tracks.find_moored": False})).laws.moored is None
