# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several drones: they see the same robots, fly as their formation says, and err in common."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan
from aerial_gnss_ros.simulation.formation import FORMATIONS, Formation, together
from aerial_gnss_ros.simulation.sensors import sensor_plan


def drones(kind="opposite", count=2, share=0.5, seed=1, sensors=(), **plan):
    def first(flight, others):
        return Experiment(flight, default_camera(1280, 720), seed=seed, others=others)

    plan = FlightPlan(**{"kind": "orbit", "duration_s": 8.0} | plan)
    return together(first, plan, Formation(kind, count, share), seed, sensors)


def bearings(made):
    """Directions from the robots to each drone at each time, rad."""
    path = [one.flight.sample(np.linspace(0.0, 8.0, 9)).antenna for one in made.values()]
    return np.unwrap([np.arctan2(at[:, 1], at[:, 0]) for at in path])


@pytest.mark.parametrize("kind", FORMATIONS)
def test_all_drones_see_the_same_robots(kind):
    made = drones(kind, count=3)
    assert list(made) == ["a", "b", "c"]
    t = np.linspace(0.0, 8.0, 5)
    for one in made.values():
        np.testing.assert_array_equal(one.swarm.positions(t), made["a"].swarm.positions(t))
        frame = one.frames()[40]
        assert set(one.projected(frame).names) == {"aqua_1", "aqua_2", "aqua_3"}


def test_opposite_drones_stay_opposite_and_those_beside_stay_close():
    apart = np.diff(bearings(drones("opposite")), axis=0)
    assert np.cos(apart) == pytest.approx(-1.0, abs=0.1)
    apart = np.diff(bearings(drones("beside")), axis=0)
    assert np.cos(apart) == pytest.approx(math.cos(math.radians(20.0)), abs=0.1)


def test_one_drone_hovers_above_and_a_far_one_grazes():
    high = drones("above")["b"].flight.sample([4.0])
    assert high.antenna[0, 2] == pytest.approx(1.3 * 15.0, abs=0.5)
    assert np.linalg.norm(high.antenna[0, :2]) < 1.0
    down = -drones("far")["b"].flight.sample([4.0]).enu_from_camera[0, 2, 0]
    assert math.degrees(math.asin(down)) == pytest.approx(math.degrees(math.atan(0.25)), abs=2.0)


def offsets(share, sensors=()):
    """GNSS offsets of two drones over many flights, (seeds, drones, axes)."""
    found = []
    for seed in range(60):
        made = drones(kind="opposite", share=share, seed=seed, sensors=sensors, duration_s=0.2)
        errors = [[o.sensors.error(f"gnss_{axis}", np.zeros(1))[0] for axis in ("east", "north")]
                  for o in made.values()]  # fmt: skip
        found.append(errors)
    return np.array(found)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_receivers_share_the_stated_part_of_their_variance(share):
    found = offsets(share)
    assert np.sqrt((found**2).mean()) == pytest.approx(1.2, rel=0.15)
    both = (found[:, 0] * found[:, 1]).mean() / (found**2).mean()
    assert both == pytest.approx(share, abs=0.2)
    if share == 1.0:
        np.testing.assert_allclose(found[:, 0], found[:, 1])


def test_what_a_better_receiver_has_removed_is_not_shared():
    found = offsets(1.0, [sensor_plan("consumer"), sensor_plan("rtk")])
    sigmas = np.sqrt((found**2).mean(axis=(0, 2)))
    assert sigmas[0] == pytest.approx(1.2, rel=0.2)
    assert sigmas[1] == pytest.approx(0.02, rel=0.2)


def test_the_first_drone_flies_as_it_would_alone():
    alone, first = drones(count=1)["a"], drones(count=2)["a"]
    t = np.linspace(0.0, 8.0, 9)
    np.testing.assert_array_equal(alone.flight.sample(t).camera, first.flight.sample(t).camera)
    heading = alone.sensors.error("heading", t)
    np.testing.assert_array_equal(heading, first.sensors.error("heading", t))


def test_formations_that_do_not_exist_are_refused():
    with pytest.raises(ConfigError, match="a formation is one of opposite, beside, above, far"):
        Formation("circle")
    with pytest.raises(ConfigError, match="1 to 8 drones fly together, not 9"):
        Formation(count=9)
    with pytest.raises(ConfigError, match="common share must lie within 0 to 1, not 2"):
        drones(share=2.0)
