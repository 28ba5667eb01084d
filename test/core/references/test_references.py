# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights with things of known position: what they correct, and what a wrong one does not."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, Expected
from aerial_gnss_ros.core.references.hypotheses import TUNING as HYPOTHESES
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.references import References
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.samples import Fix

pytestmark = pytest.mark.flights

OFF = (1.5, -1.1)
"""What the drone's receiver is wrong by, m: usual for a consumer one."""
PIER = (4.0, 18.0)
ROBOTS = {"aqua": lambda _t: (-3.0, 20.0), "beacon": lambda _t: PIER}


def fly(
    sea, references, seconds=12.0, sent=None, robots=None, hidden=None, values=None, jumps=None
):
    """Fly over robots whose names begin with their classes.

    Args:
        references: as stated; a position is given in metres from the origin.
        sent: of references with a topic, the path of their fixes.
        hidden: whether the detector misses a robot at a time.
        jumps: displacement of the receiver at a time, m.
    """
    world = sea.World(robots=robots or ROBOTS, gnss_bias=OFF, pixel_sigma=1.0)
    stated = {name: dict(one) for name, one in references.items()}
    for one in stated.values():
        if "position" in one:
            one["position"] = np.degrees(world.local.places(np.array([one["position"]]))).ravel()
            one["position"] = one["position"].tolist()
    engine = sea.estimator({"references": stated, **(values or {})})
    engine.add_camera(sea.stamp(0.0), sea.camera)
    results = []
    for i in range(round(seconds * 10)):
        t = i / 10
        if jumps:
            world.gnss_bias = tuple(np.add(OFF, jumps(t)))
        engine.add_fix(world.fix(t))
        engine.add_gimbal(world.gimbal(t))
        engine.add_height(world.height(t))
        for name, path in (sent or {}).items():
            if i % 2 == 0:
                latitude, longitude = world.local.places(np.array([path(t)]))
                covariance = 0.02**2 * np.eye(3)
                engine.add_reference(
                    name, Fix(sea.stamp(t), latitude[0], longitude[0], 0.0, covariance)
                )
        if i % 2 == 0:
            engine.add_detections(_boxes(sea, world, t, hidden))
        results += engine.advance(sea.stamp(t))
    return engine, results + engine.flush()


def _boxes(sea, world, t, hidden):
    names, centers = [], []
    for name, place in world.robots.items():
        latitude, longitude = world.local.places(np.array([place(t)]))
        pixels, inside = sea.project_to_image(world.pose(t), world.camera, latitude, longitude)
        if inside[0] and not (hidden and hidden(name, t)):
            names.append(name.split("_", maxsplit=1)[0])
            centers.append(pixels[0] + world.pixel_sigma * world.rng.standard_normal(2))
    return replace(sea.boxes(t, centers), class_ids=tuple(names))


def pier(position=PIER, sigma_m=0.05, **more):
    return {"pier": {"class": "beacon", "position": position, "sigma_m": sigma_m} | more}


def last(results, label="aqua_1"):
    return next(one for one in results[-1].estimates if one.robot_id == label)


def error(estimate, place):
    return math.dist(estimate.position, place)


@pytest.fixture(scope="module")
def plain(sea):
    """Return the results of a flight without references."""
    return fly(sea, {})[1]


def test_a_surveyed_point_corrects_every_robot(sea, plain):
    without = last(plain)
    engine, results = fly(sea, pier())
    robot = last(results)
    assert error(without, ROBOTS["aqua"](0)) == pytest.approx(math.hypot(*OFF), abs=0.4)
    assert error(robot, ROBOTS["aqua"](0)) < 0.3
    assert robot.sigma < 0.35
    assert without.sigma > 1.2
    assert error(last(results, "beacon_1"), PIER) < 0.1
    assert "Reference pier is beacon_1: positions refer to it." in engine.events
    receiver = {one.name: one for one in results[-1].platform}
    for name, off in zip(("gnss_east", "gnss_north"), OFF, strict=True):
        assert abs(receiver[name].value + off) < 2.0 * receiver[name].sigma
        assert receiver[name].sigma < 0.65


def test_a_jump_of_the_receiver_beside_one_in_view_displaces_nothing(sea):
    """It lasts for longer than the receiver was right; the point is missed for a while."""

    def jumps(t):
        return (0.0, 8.0) if t > 6.0 else (0.0, 0.0)

    gone = lambda name, t: name == "beacon" and 10.0 < t < 12.0  # noqa: E731
    engine, results = fly(sea, pier(), seconds=20.0, jumps=jumps, hidden=gone)
    assert engine.happened["position_jumps"] == 1
    robot = last(results)
    assert error(robot, ROBOTS["aqua"](0)) < 0.3
    assert robot.sigma < 0.35
    without = last(fly(sea, {}, seconds=20.0, jumps=jumps)[1])
    assert error(without, ROBOTS["aqua"](0)) > 6.0  # nobody knows
    assert without.sigma > 4.0


def test_one_that_is_removed_in_flight_tells_no_more(sea):
    engine, _ = fly(sea, pier())
    sure = engine._tracks.pipeline.predicted(sea.stamp(12.0)).estimates
    engine.reconfigure(estimator_config(sea.origin))
    left = engine._tracks.pipeline.predicted(sea.stamp(12.0)).estimates
    assert [one.robot_id for one in left] == [one.robot_id for one in sure]
    assert max(one.sigma for one in sure) < 0.35
    assert min(one.sigma for one in left) > 1.2
    assert not engine._tracks.pipeline.tracking._references.links


def test_without_references_nothing_changes(sea, plain):
    absent = fly(sea, pier(position=(900.0, 900.0)))[1]
    for one, other in zip(plain, absent, strict=True):
        assert [e.position.tolist() for e in one.estimates] == [
            e.position.tolist() for e in other.estimates
        ]


def test_a_known_error_of_the_point_is_not_averaged_out(sea):
    robot = last(fly(sea, pier(sigma_m=1.0))[1])
    expected = 1.0 / math.sqrt(1.0 / 1.2**2 + 1.0)
    assert robot.sigma == pytest.approx(expected, rel=0.25)


@pytest.mark.parametrize("off", [8.0, 1000.0, 5e6])
def test_a_wrong_point_is_refused_said_and_does_no_harm(sea, plain, off):
    engine, results = fly(sea, pier(position=(PIER[0] + off, PIER[1])))
    assert last(results).position.tolist() == last(plain).position.tolist()
    assert last(results).covariance.tolist() == last(plain).covariance.tolist()
    said = [one for one in engine.events if "pier" in one]
    assert len(said) == 1
    assert "Reference pier is not used: beacon_1 is seen" in said[0]


def test_a_receiver_that_is_sure_refuses_a_point_that_is_a_little_off(sea):
    sure = {"noise.gnss_offset_m": 0.02, "noise.heading_deg": 0.1, "noise.height_m": 0.02,
            "noise.gimbal_pitch_deg": 0.05, "noise.gimbal_roll_deg": 0.05}  # fmt: skip
    east = PIER[0] + OFF[0] + 1.0
    engine, _ = fly(sea, pier(position=(east, PIER[1] + OFF[1])), values=sure)
    assert any("is not used" in one for one in engine.events)
    engine, _ = fly(sea, pier(position=(east - 1.0, PIER[1] + OFF[1])), values=sure)
    assert not any("is not used" in one for one in engine.events)


def test_of_two_that_contradict_one_another_the_likelier_is_used(sea):
    robots = ROBOTS | {"post": lambda _t: (0.0, 16.0)}
    both = pier() | {"post": {"class": "post", "position": (8.0, 16.0), "sigma_m": 0.05}}
    engine, results = fly(sea, both, robots=robots)
    assert error(last(results), ROBOTS["aqua"](0)) < 0.3
    assert any("Reference post is not used" in one and "pier" in one for one in engine.events)


def test_two_that_agree_outvote_a_receiver_that_is_far_off(sea):
    """5 m off, where one point alone would not be believed."""
    robots = ROBOTS | {"post": lambda _t: (0.0, 16.0)}
    away = np.array([5.0, 0.0])
    points = {
        name: {"class": name, "position": tuple(np.add(robots[name](0), away)), "sigma_m": 0.05}
        for name in ("beacon", "post")
    }
    _, results = fly(sea, points, robots=robots)
    assert error(last(results), np.add(ROBOTS["aqua"](0), away)) < 0.4


def test_a_boat_with_a_receiver_of_its_own_corrects_while_it_moves(sea):
    robots = {"aqua": ROBOTS["aqua"], "boat": lambda t: (2.0 + 0.4 * t, 17.0)}
    stated = {"rtk": {"class": "boat", "topic": "rtk/fix"}}
    _, results = fly(sea, stated, robots=robots, sent={"rtk": robots["boat"]})
    assert error(last(results), ROBOTS["aqua"](0)) < 0.3
    assert last(results).sigma < 0.4


def test_a_boat_whose_fix_is_elsewhere_is_refused(sea):
    robots = {"aqua": ROBOTS["aqua"], "boat": lambda t: (2.0 + 0.4 * t, 17.0)}
    stated = {"rtk": {"class": "boat", "topic": "rtk/fix"}}
    engine, results = fly(sea, stated, robots=robots, sent={"rtk": lambda _t: (60.0, 0.0)})
    assert error(last(results), ROBOTS["aqua"](0)) == pytest.approx(math.hypot(*OFF), abs=0.4)
    assert any("Reference rtk is not used" in one for one in engine.events)


def test_after_it_leaves_the_view_the_error_grows_no_faster_than_the_receiver_drifts(sea):
    alone = {"tracks.find_moored": False}  # a robot that stays would tell of the drift
    hidden = lambda name, t: name == "beacon" and t > 12.0  # noqa: E731
    _, results = fly(sea, pier(), 42.0, hidden=hidden, values=alone)
    sigmas = [last([one]).sigma for one in (results[57], results[207])]
    drift = 1.2 * math.sqrt(1.0 - math.exp(-2.0 * 30.0 / 300.0))
    assert error(last(results), ROBOTS["aqua"](0)) < 0.6
    # Compass, gimbal and height drift, too.
    assert 0.95 * drift < sigmas[1] <= math.hypot(sigmas[0], drift) + 0.05


def test_what_is_moored_may_swing(sea):
    _, results = fly(sea, pier(sigma_m=0.2, radius_m=4.0, position=(PIER[0] + 1.0, PIER[1])))
    assert last(results).sigma > 0.9


def test_one_of_a_class_that_others_have_is_not_mistaken(sea):
    """Two buoys 1.5 m apart, one of them known, and a receiver that is wrong by as much."""
    robots = {"aqua": ROBOTS["aqua"], "buoy": lambda _t: (4.0, 18.0),
              "buoy_b": lambda _t: (4.0 - OFF[0], 18.0 - OFF[1])}  # fmt: skip
    stated = {"mark": {"class": "buoy", "position": (4.0, 18.0), "sigma_m": 0.1}}
    engine, results = fly(sea, stated, robots=robots)
    assert last(results).sigma > 0.8
    assert any("give it a class of its own" in one for one in engine.events)


def test_the_middle_of_a_box_above_the_water_seems_farther_off(sea):
    """A beacon 2 m high is seen where its ray meets the water, 2/28 of the way beyond."""
    seen = np.array(PIER) * 30.0 / 28.0
    robots = {"aqua": ROBOTS["aqua"], "beacon": lambda _t: tuple(seen)}
    _, results = fly(sea, pier(height_m=2.0), robots=robots)
    assert error(last(results), ROBOTS["aqua"](0)) < 0.3
    assert last(results).state is State.CONFIRMED


def test_of_a_class_that_swims_the_one_that_stays_is_the_reference(sea):
    """A receiver 1.9 m off, and a swimmer that passes where the reference should seem to be."""
    robots = {"aqua": lambda t: (8.0 - 0.3 * t, 16.0 - 0.1 * t), "aqua_b": lambda _t: PIER}
    stated = {"mark": {"class": "aqua", "position": PIER, "sigma_m": 0.05}}
    engine, results = fly(sea, stated, 20.0, robots=robots)
    used = [one for one in engine.events if one.startswith("Reference mark is aqua_")]
    assert len({one for one in used if " not " not in one}) == 1
    places = [one.position for one in results[-1].estimates]
    assert min(math.dist(place, PIER) for place in places) < 0.2
    assert min(math.dist(place, robots["aqua"](20.0)) for place in places) < 0.5


def test_a_point_that_moves_is_none_and_that_is_said(sea):
    robots = ROBOTS | {"beacon": lambda t: (4.0, 18.0 + 0.25 * max(t - 5.0, 0.0))}
    engine, results = fly(sea, pier(), 20.0, robots=robots)
    said = [one for one in engine.events if "pier" in one]
    assert said[0] == "Reference pier is beacon_1: positions refer to it."
    assert "Reference pier is not used: beacon_1 has moved by " in said[1]
    assert error(last(results), ROBOTS["aqua"](0)) == pytest.approx(math.hypot(*OFF), abs=0.4)
    assert last(results).sigma > 1.2


def test_a_receiver_that_wanders_is_no_motion_of_the_point(sea):
    """By 2.6 m within 4 s, which its stated correlation time hardly allows; all seem to move."""

    def wanders(place):
        return lambda t: (place[0] - 0.65 * min(max(t - 5.0, 0.0), 4.0), place[1])

    places = {"aqua": ROBOTS["aqua"](0), "beacon": PIER, "aqua_b": (0.0, 16.0)}
    robots = {name: wanders(place) for name, place in places.items()}
    engine, results = fly(sea, pier(), 16.0, robots=robots)
    assert [one for one in engine.events if "pier" in one] == [
        "Reference pier is beacon_1: positions refer to it."
    ]
    assert error(last(results), ROBOTS["aqua"](0)) < 0.3


@pytest.mark.parametrize(("probability", "taken"), [(0.996, 1), (0.98, 0), (0.94, 0)])
def test_what_another_tracker_recognised_need_not_be_sure_here(probability, taken):
    """A moving one, of 0.1 m, so far off that it is right with that probability."""
    mean, covariance = np.zeros(COUNT + 4), np.eye(COUNT + 4)
    law = PositionLaw(np.arange(1), mean, covariance)
    source = SimpleNamespace(
        laws=[law], believed=np.zeros(2), stationary=np.eye(COUNT), decay=lambda _s: np.ones(COUNT)
    )
    near, far = 1.0 + 0.01, 1.0 + 0.01 + HYPOTHESES.nearby_m**2
    share = HYPOTHESES.wrong_share
    nats = math.log(probability / (1.0 - probability)) - math.log((1.0 - share) / share)
    east = math.sqrt(2.0 * (math.log(far / near) - nats) / (1.0 / near - 1.0 / far))
    tracks = [SimpleNamespace(robot_id="boat_1", class_id="boat", last_seen_ns=10**9)]
    boat = Expected("rtk", "boat", np.array([east, 0.0]), 0.01 * np.eye(2), moves=True)
    for recognised, expected in (({}, taken), ({"rtk": "boat_1"}, int(probability > 0.95))):
        references = References(source, Events())
        references.recognised = recognised
        references.update(tracks, [boat], 10**9)
        assert len(references.links) == expected


def test_a_rotation_is_known_but_for_what_the_references_do_not_show():
    """The conditional normal law of positions and angles together, about the published mean."""
    rng = np.random.default_rng(5)
    root = 0.3 * rng.standard_normal((COUNT + 8, COUNT + 8))
    law = PositionLaw(np.arange(2), rng.standard_normal(COUNT + 8), root @ root.T)
    place, spread = np.array([1.0, 2.0]), 0.05**2 * np.eye(2)
    references = References(SimpleNamespace(laws=[law]), Events())
    by_angles, angles = 10.0 * rng.standard_normal((2, 2, 3)), np.diag([0.1, 0.2, 0.05])
    assert references.turned(by_angles, angles) == {}
    references._in_view = [(Candidate("pier", place, spread, (0,)), 0)]
    found = references.turned(by_angles, angles)
    own = law.places([0, 1])
    moved = by_angles.reshape(4, 3)
    wide = law.covariance[np.ix_(own, own)] + moved @ angles @ moved.T
    gain = wide[:, :2] @ np.linalg.inv(wide[:2, :2] + spread)
    mean = law.mean[own] + gain @ (place - law.mean[own[:2]])
    covariance = wide - gain @ wide[:2]
    states, blocks = law.known([0], place[None], spread[None]).states()
    apart = mean[2:] - states[1, :2]
    expected = covariance[2:, 2:] + np.outer(apart, apart) - blocks[1, :2, :2]
    assert found[1] == pytest.approx(expected)
