# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that stay are found out with default parameters; those that do not are not."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.casting_off import CastingOff
from aerial_gnss_ros.core.filter.moored import TUNING, MooredHypothesis
from aerial_gnss_ros.core.filter.moored_law import CURRENT, given_errors
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.swing import TUNING as SWING
from aerial_gnss_ros.core.filter.swing import Swing
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT, HEADING

pytestmark = pytest.mark.flights

RTK = {
    "noise.gnss_offset_m": 0.02,
    "tracks.find_moored": True,
    "camera.find_latency": False,  # on an even circle images tell nothing of it
}
ORBIT = {
    "drone": lambda t: (28.0 * math.cos(0.15 * t), 20.0 + 28.0 * math.sin(0.15 * t), 30.0),
    "rpy_deg": lambda t: (0.0, 47.0, math.degrees(0.15 * t) + 180.0),
    "rpy_bias_deg": (0.2, 0.3, 1.5),
    "pixel_sigma": 2.0,
}
PLACES = {"a": (2.0, 21.0), "b": (-3.0, 18.0), "c": (1.0, 15.0)}


def robots(drift=(0.0, 0.0), leaves=math.inf, speed=0.3):
    """Return robots: all go with a current, one swims off at a time."""

    def place(name):
        def at(t):
            east, north = PLACES[name]
            off = speed * max(t - leaves, 0.0) if name == "a" else 0.0
            return east + drift[0] * t + off, north + drift[1] * t

        return at

    return {name: place(name) for name in PLACES}


def flown(sea, stated=None, seconds=30.0, **motion):
    """Return the last result, its errors (n,), their sizes by its covariances, and its sigma."""
    world = sea.World(robots=robots(**motion), **ORBIT)
    engine = sea.estimator(RTK | (stated or {}))
    last = sea.play(engine, world, seconds)[-1]
    t = (last.stamp_ns - sea.stamp(0.0)) * 1e-9
    errors, sizes = [], []
    for one in last.estimates:
        off = min((one.position - place(t) for place in world.robots.values()),
                  key=lambda d: float(d @ d))  # fmt: skip
        errors.append(float(np.linalg.norm(off)))
        sizes.append(float(off @ np.linalg.solve(one.covariance[:2, :2], off)))
    assert len(errors) == len(PLACES)
    sigma = max(math.sqrt(np.trace(one.covariance[:2, :2])) for one in last.estimates)
    return last, np.array(errors), np.array(sizes), sigma


def test_robots_that_stay_are_known_as_if_stated(sea):
    last, errors, sizes, sigma = flown(sea)
    reported = {"noise.robot_acceleration": 0.0, "tracks.max_speed": 0.01}
    _, _, _, best = flown(sea, reported)
    assert last.current is None
    assert sigma < 1.5 * best
    assert errors.max() < 4.0 * best
    assert sizes.max() < 13.8


def test_one_current_for_all_is_no_platform_error_and_is_reported(sea):
    last, errors, sizes, _ = flown(sea, drift=(0.15, -0.1))
    off = last.current.velocity - (0.15, -0.1)
    assert float(off @ np.linalg.solve(last.current.covariance, off)) < 13.8
    assert last.current.covariance.trace() < 0.1**2
    assert sizes.max() < 13.8
    assert errors.max() < 0.4


def test_a_robot_that_leaves_is_followed(sea):
    _, errors, sizes, sigma = flown(sea, leaves=20.0)
    assert sizes.max() < 13.8
    assert sigma < 0.4
    assert errors.max() < 0.5


@pytest.mark.parametrize("seed", [1, 2])
def test_covariances_cover_a_robot_that_casts_off(sea, seed):
    """It swims 0.3 m/s: for a second its boxes may be noise."""
    world = sea.World(robots=robots(leaves=20.0), seed=seed, **ORBIT)
    results = sea.play(sea.estimator(RTK), world, 25.0)
    errors, sizes = [], []
    for result in results:
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        if t > 20.0:
            place = np.array(world.robots["a"](t))
            off, one = min(
                ((one.position - place, one) for one in result.estimates),
                key=lambda both: float(both[0] @ both[0]),
            )
            errors.append((t, float(np.linalg.norm(off))))
            sizes.append(float(off @ np.linalg.solve(one.covariance[:2, :2], off)))
    assert max(sizes) < 13.8
    assert np.mean(sizes) / 2.0 < 1.6
    assert max(error for t, error in errors if t > 22.0) < 0.4


def test_predictions_cover_a_robot_that_casts_off_unseen(sea):
    """The detector misses all robots from when one swims off at 1 m/s."""
    world = sea.World(
        robots=robots(leaves=20.0, speed=1.0), hidden=lambda _name, t: t > 20.0, **ORBIT
    )
    results = sea.play(sea.estimator(RTK), world, 32.0)
    seen = next(one for one in reversed(results) if one.stamp_ns <= sea.stamp(20.0))
    named = {
        one.robot_id: min(PLACES, key=lambda name: math.dist(PLACES[name], one.position))
        for one in seen.estimates
    }
    sizes = []
    for result in results:
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        for one in result.estimates if t > 20.0 else ():
            off = one.position - world.robots[named[one.robot_id]](t)
            sizes.append(float(off @ np.linalg.solve(one.covariance[:2, :2], off)))
    assert len(sizes) == len(PLACES) * 60
    assert max(sizes) < 13.8


def heading(law):
    """Return what a law knows of the heading's error, and its variance."""
    return float(law.mean[HEADING]), float(law.covariance[HEADING, HEADING])


def laws(engine):
    """Return the hypotheses of a flight in which something is moored or drifts."""
    (group,) = engine._tracks.pipeline.tracking.table.filter.laws.moored._all
    return [one for one in group.both if one.law is not None]


def test_another_calibration_keeps_what_is_known_of_motion(sea):
    world = sea.World(robots=robots(), **ORBIT)
    engine = sea.estimator(RTK)
    sea.play(engine, world, 20.0, until_flush=False)
    before = [(one.law, *heading(one.law), one.evidence) for one in laws(engine)]
    filter_ = engine._tracks.pipeline.tracking.table.filter
    prior = filter_.stationary[HEADING, HEADING]
    d = math.radians(1.0)
    swim, unsure = heading(filter_.groups[0])
    engine.reconfigure(estimator_config({**sea.origin, **RTK, "calibration.heading_deg": 1.0}))
    after = laws(engine)
    assert len(after) == len(before) > 0
    for one, (law, mean, variance, evidence) in zip(after, before, strict=True):
        assert one.law is law
        moved = d * (1.0 - variance / prior)  # of an error known exactly, all is new
        assert heading(law)[0] == pytest.approx(mean - moved, rel=1e-3)
        likelier = d * (mean - swim) / prior + 0.5 * (variance - unsure) * (d / prior) ** 2
        assert one.evidence - evidence == pytest.approx(likelier, rel=1e-3)
    engine.reconfigure(estimator_config({**sea.origin, **RTK, "camera.latency_s": 0.1}))
    assert engine._tracks.pipeline.tracking.table.filter.laws.moored._all == []


def test_a_robot_that_comes_later_is_in_the_laws(sea):
    world = sea.World(robots=robots(), **ORBIT)
    engine = sea.estimator(RTK)
    sea.play(engine, world, 12.0, until_flush=False)
    world.robots["d"] = lambda _t: (4.0, 18.0)
    last = sea.play(engine, world, 10.0, begin=12.0, until_flush=False)[-1]
    assert len(last.estimates) == 4
    assert "images_failed" not in engine.happened
    for one in laws(engine):
        assert sorted(one.law.ids.tolist()) == sorted([*one.base.ids.tolist(), CURRENT])
        assert (one.places() >= 0).all()
        assert one.law.sway[one.places()].all()


def test_laws_have_the_motion_of_new_classes(sea):
    world = sea.World(robots=robots(), **ORBIT)
    engine = sea.estimator(RTK)
    sea.play(engine, world, 10.0, until_flush=False)
    classes = {"classes.aqua.acceleration": 0.02, "classes.aqua.max_speed": 0.4}
    engine.reconfigure(estimator_config({**sea.origin, **RTK, **classes}))
    assert laws(engine)
    for one in laws(engine):
        own = one.law.own
        assert np.isnan(own[:, one.law.current]).all()
        np.testing.assert_allclose(own[0, one.places()], 0.02)


MOTION = MotionModel(0.05, 0.75)
STEP_S = 0.1
PIXELS_A_METRE = 10.0
KNOWN = np.tile(1e-4 * np.eye(2), (3, 1, 1))
"""What is uncertain of three robots' places, m²."""


class Base(SimpleNamespace):
    """Stands in for the law in which all swim."""

    def __len__(self):
        return len(self.ids)


class StandIn:
    """Stands in for a law of n moored robots and a current."""

    def __init__(self, count):
        self.ids = np.array([*range(count), -1])
        self.sway = np.array([*[1.0] * count, 0.0])
        self.current = count
        self.variance = 0.1**2
        self.released = []

    def release(self, slot, state, covariance):
        self.sway[slot] = 0.0
        self.released.append((slot, state.copy(), covariance.copy()))

    def __len__(self):
        return len(self.ids)

    def predict(self, *_):
        """Nothing moves."""


def tried(adrift=False):
    """Return a hypothesis with a stand-in of its law, in which three robots are moored."""
    base = Base(ids=np.arange(3), own=np.full((2, 3), np.nan))
    one = MooredHypothesis(base, adrift)
    one.law, one.evidence = StandIn(3), TUNING.first_nats
    one.swing, one.leaving = Swing(4), CastingOff(4)
    for slot in range(3):
        one.leaving.begin(slot, -5.0)
    one._places = base.ids, one.law.ids, np.arange(3)
    one._synced = base.ids, one.law.ids
    return one


def outcome(innovations, fits=0.0):
    """Return what an image gave: innovations (m, 2) by their own covariance."""
    own = np.array(innovations, dtype=float)
    return SimpleNamespace(
        count=own.size,
        log_likelihood=fits,
        slots=np.arange(len(own)),
        normalised=lambda: own,
        by_place=np.tile(PIXELS_A_METRE * np.eye(2), (len(own), 1, 1)),
        given_others=lambda: (own, np.tile(np.eye(2), (len(own), 1, 1))),
    )


def shown(one, innovations, seconds):
    """Let images show the same innovations for a time; return the greatest odds to have left."""
    most = -np.inf
    for _ in range(round(seconds / STEP_S)):
        if one.law is None or one.law.released:
            break
        one.predict(STEP_S, None, None, MOTION)
        one._compare(one.law, outcome(innovations), outcome(innovations), KNOWN)
        most = max([most, *one.leaving.odds[:1]])
    return most


def test_evidence_is_what_the_law_fits_better():
    one = tried()
    still = [[0.0, 0.0]] * 3
    one._compare(one.law, outcome(still, fits=-3.0), outcome(still, fits=-5.0), KNOWN)
    assert one.evidence == pytest.approx(TUNING.first_nats + 2.0, abs=0.1)
    before = one.evidence
    one._compare(one.law, outcome(still[:2], fits=-3.0), outcome(still, fits=-5.0), KNOWN)
    assert one.evidence == before  # not the same boxes
    one._compare(one.law, outcome(still, fits=-30.0), outcome(still), KNOWN)
    assert one.law is None
    assert one.evidence == -math.inf


def test_of_a_displacement_a_law_follows_its_gain():
    one, given = tried(), []
    one.leaving.update = lambda *all_: given.append(all_) or 0.0
    still = outcome([[0.5, 0.0]] * 3)
    one._compare(one.law, still, still, 20.0 * KNOWN)
    slots, residual, spread, by_place, followed = given[0]
    assert slots.tolist() == [0, 1, 2]
    np.testing.assert_array_equal(residual, [[0.5, 0.0]] * 3)
    np.testing.assert_array_equal(spread[0], np.eye(2))
    np.testing.assert_allclose(followed, [20.0 * 1e-4 * PIXELS_A_METRE**2 * np.eye(2)] * 3)
    assert by_place[0, 0, 0] == PIXELS_A_METRE


def test_a_robot_leaves_by_small_innovations_that_add_up():
    one = tried()
    going = [[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]
    assert shown(one, going, seconds=1.0) < 0.0
    assert not one.law.released
    one.evidence, fits = 0.0, 0.5
    for _ in range(100):  # the law fits as much worse as the robot's boxes say
        if one.law.released:
            break
        one.predict(STEP_S, None, None, MOTION)
        one._compare(one.law, outcome(going, fits=-fits), outcome(going), KNOWN)
    [(slot, state, covariance)] = one.law.released
    assert slot == 0
    assert 0.0 < state[0] < 0.2
    assert covariance[0, 0] > 0.0
    assert one.leaving.odds[0] == -np.inf
    assert -10.0 < one.evidence < -4.0  # that it was likely to leave, and no more


def test_white_innovations_are_no_reason_to_leave():
    one, rng = tried(), np.random.default_rng(3)
    for _ in range(600):
        one.predict(STEP_S, None, None, MOTION)
        own = outcome(rng.standard_normal((3, 2)))
        one._compare(one.law, own, own, KNOWN)
    assert not one.law.released
    assert one.law.variance == 0.1**2


def test_where_most_seem_to_leave_the_hypothesis_is_wrong():
    one = tried()
    shown(one, [[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]], seconds=10.0)
    assert one.law is None


@pytest.mark.parametrize(("innovation", "larger"), [(0.6, True), (0.02, False)])
def test_the_swing_is_as_large_as_boxes_tell(innovation, larger):
    one = tried()
    for _ in range(40):
        one.predict(STEP_S, None, None, MOTION)
        own = outcome([[innovation, innovation]] * 3)
        one._compare(one.law, own, own, KNOWN)
        one.leaving.log_odds[:] = -np.inf  # only the swing is asked for here
    one._ask = lambda: None
    one.predict(2.0 * TUNING.asked_every_s, None, None, MOTION)
    nobody = SimpleNamespace(slots=[])
    one.update(nobody, None, None, None, 1.0)
    assert one.law.variance == pytest.approx(
        0.1**2 * SWING.larger if larger else 0.1**2 / SWING.larger
    )


def test_that_robots_stay_begins_as_that_they_drift_by_nothing():
    drifting, still = tried(adrift=True), tried()
    drifting.evidence, still.law = 3.0, None
    drifting.law.without_current = lambda: "still"
    drifting.law.still_odds = lambda: -5.0
    still.begin_as(drifting, -4.0)
    assert still.law is None
    drifting.law.still_odds = lambda: -1.5
    still.begin_as(drifting, -4.0)
    assert (still.law, still.evidence) == ("still", 1.5)
    assert still.swing is not drifting.swing
    assert still.leaving is not drifting.leaving


def test_a_robot_is_asked_for_once_it_was_watched_for_long_enough():
    one = tried()
    one.predict(0.9 * TUNING.watched_s, None, None, MOTION)
    one.base.ids = np.arange(4)  # another one comes
    one.law = None
    one.predict(0.2 * TUNING.watched_s, None, None, MOTION)
    swimming = SimpleNamespace(ids=np.arange(4), unseen=np.array([0.0, 1.0, 0.0, 0.0]), sway=None)
    assert one._eligible(swimming) == [0, 2]


def test_one_robot_alone_is_not_known_to_stay_or_drift():
    for adrift in (False, True):
        one = tried(adrift)
        one.law.sway[2:] = 0.0
        one.predict(STEP_S, None, None, MOTION)
        assert one.law is not None
        one.law.sway[1:] = 0.0
        one.predict(STEP_S, None, None, MOTION)
        assert one.law is None


def test_boxes_of_a_robot_without_a_label_count_in_all_laws(sea):
    world = sea.World(robots={**robots(), "late": lambda _t: (6.0, 24.0)}, **ORBIT)
    world.hidden = lambda name, t: name == "late" and t < 12.0
    engine = sea.estimator(RTK)
    sea.play(engine, world, 12.2, until_flush=False)
    table = engine._tracks.pipeline.tracking.table
    base, times = table.filter.groups[0], table.filter.laws.times
    (row,) = [i for i, track in enumerate(table.tracks) if not track.robot_id]
    (slot,) = np.flatnonzero(base.rows == row)

    def unsure(law, slot):
        """Variance of where a robot is if the platform were known, m²."""
        _, own, with_errors = law.positions()
        return np.trace(given_errors(own, with_errors, law.covariance[:COUNT, :COUNT])[slot])

    assert len(laws(engine)) > 0
    for law, place in [
        (times._law, slot),
        *((one.law, one.places()[slot]) for one in laws(engine)),
    ]:
        assert unsure(law, place) < 1.5 * unsure(base, slot)


@pytest.mark.parametrize("adrift", [False, True])
def test_two_robots_begin_a_law(adrift):
    base = JointState(0.01 * np.eye(COUNT))
    one = MooredHypothesis(base, adrift)
    for count in (1, 2):
        begin(base, 1)
        one.predict(2.0 * TUNING.watched_s, None, None, MOTION)
        base.unseen[:] = 0.0
        one._ask()
        assert (one.law is not None) == (count == 2)


def begun(count, adrift=False, variance=0.01):
    """Return robots that seem to stay, and a hypothesis of which a law has begun with them.

    Args:
        count: number of robots.
        adrift: whether they may drift.
        variance: of the platform's errors.
    """
    base = JointState(variance * np.eye(COUNT))
    begin(base, count)
    one = MooredHypothesis(base, adrift)
    one.predict(2.0 * TUNING.watched_s, None, None, MOTION)
    base.unseen[:] = 0.0
    one._ask()
    return base, one


def test_the_law_has_the_robots_that_the_base_has():
    base, one = begun(3, adrift=True)
    assert one.law.sway.tolist() == [1.0, 1.0, 1.0, 0.0]
    one.swing.sums[:, 0] = [1.0, 2.0, 3.0, 4.0]
    one.leaving.log_odds[:, 0] = [-1.0, -2.0, -3.0, -np.inf]
    begin(base, 2)
    base.own[:, 4] = 0.2, 0.5  # its class has its own motion
    base.drop(np.array([1]))
    one._sync(one.law)
    assert set(one.law.ids.tolist()) == {*base.ids.tolist(), CURRENT}
    assert one.law.ids[one.places()].tolist() == base.ids.tolist()
    np.testing.assert_array_equal(one.law.own[:, one.places()], base.own)
    assert one.swing.sums[one.places(), 0].tolist() == [1.0, 3.0, 0.0, 0.0]
    assert one.leaving.log_odds[one.places(), 0].tolist() == [-1.0, -3.0, -np.inf, -np.inf]
    assert one.swing.sums[one.law.current, 0] == 4.0


def begin(base, count):
    """Add robots that are known to be slow."""
    own = np.tile(np.diag([0.01, 0.01, 1e-4, 1e-4]), (count, 1, 1))
    places = np.random.default_rng(len(base)).normal(0.0, 10.0, (count, 2))
    state = np.column_stack([places, np.zeros((count, 2))])
    base.append(np.arange(count) + len(base), state, np.zeros((count, 4, COUNT)), own)


@pytest.mark.parametrize(
    ("off_m", "gains", "stays"),
    [(0.0, True, True), (0.3, True, True), (1.5, False, False)],
    ids=["there", "near", "elsewhere"],
)
def test_a_moored_robot_that_is_found_again_stays_so(off_m, gains, stays):
    """The base expects it within 3 m, the law within 0.2 m; it may have left in the meantime."""
    base, one = begun(2, variance=1e-6)
    one.law.variance, one.evidence = 0.1**2, 0.0
    one.leaving.predict(10.0, 0.05**2)
    place = base.robots[0, :2] + [off_m, 0.0]
    own = np.diag([0.01, 0.01, 0.25, 0.25])[None]
    base.append(np.array([2]), np.array([[*place, 0.0, 0.0]]), np.zeros((1, 4, COUNT)), own)
    base.covariance[COUNT, COUNT] = base.covariance[COUNT + 1, COUNT + 1] = 9.0
    given, judged = [], one.leaving.update
    one.leaving.update = lambda *all_: given.append(all_) or judged(*all_)
    one.join(0, 2, 0.1, base.tie(0, 2, 0.1))
    _, _, spread, by_place, followed = given[0]
    # Place, new track and what they may be apart have 0.1 m each: the law follows a third.
    np.testing.assert_allclose(spread[0], 0.03 * np.eye(2), atol=1e-4)
    np.testing.assert_allclose(followed[0], np.eye(2) / 3.0, atol=1e-3)
    np.testing.assert_array_equal(by_place, [np.eye(2)])
    assert (one.evidence > 3.0) == gains
    number = base.ids[2]
    base.drop(np.array([0]))
    one._sync(one.law)
    assert one.law.ids.tolist()[0] == number
    assert len(one.law) == 3
    assert np.count_nonzero(one.law.sway) == 2
    assert (one.leaving.odds[0] < 0.0) == stays
    states, own = one.law.published()
    shown, spread = one.leaving.mix(np.array([0]), states[:1], own[:1])
    off = shown[0, :2] - place
    assert off @ np.linalg.solve(spread[0, :2, :2], off) < 9.0


def test_a_swimming_robot_that_is_found_again_swims_in_the_law():
    base, one = begun(3, variance=1e-6)
    one.law.sway[0] = 0.0
    before = one.evidence
    begin(base, 1)
    one.join(0, 3, 0.1, base.tie(0, 3, 0.1))
    assert one.evidence == before
    assert len(one.law) == 5
    MooredHypothesis(base, adrift=True).join(1, 3, 0.1, 0.0)  # no law is tried
