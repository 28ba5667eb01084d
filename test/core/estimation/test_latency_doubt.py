# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A latency that nobody states is found out in flight; without one nothing changes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation import (
    latency_doubt,
    latency_trial,
    recent_images,
    time_in_motion,
)
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

STATED = {"noise.gnss_offset_m": 0.02, "noise.robot_acceleration": 0.01}
ROBOTS = {"a": lambda _t: (2.0, 18.0), "b": lambda _t: (-3.0, 22.0), "c": lambda _t: (6.0, 24.0)}


def to_and_fro(t, amplitude_m=8.0):
    """A drone that flies back and forth at up to 4 m/s."""
    return amplitude_m * math.sin(0.5 * t), 0.0, 30.0


def late_world(sea, late_s, drone=to_and_fro, **boxes):
    """A world whose images stamped t show t - late_s."""
    given = {"rpy_deg": lambda _t: (0.0, 60.0, 90.0), "robots": ROBOTS, "pixel_sigma": 2.0, **boxes}
    world = sea.World(drone=drone, **given)
    seen = sea.World(drone=lambda t: drone(t - late_s), **given)
    world.frame = seen.frame
    return world


def latency(result):
    return next((one for one in result.platform if one.name == "latency"), None)


def places(results):
    return [(one.robot_id, *one.position, *one.covariance.ravel())
            for result in results for one in result.estimates]  # fmt: skip


@pytest.mark.parametrize("late_s", [1.0, -1.3])
def test_a_latency_that_nobody_states_is_found(sea, late_s):
    engine = sea.estimator(STATED)
    results = sea.play(engine, late_world(sea, late_s), 22.0)
    found = next(one for one in reversed([latency(result) for result in results]) if one)
    assert found.sigma < 0.15
    assert abs(found.value - late_s) < 4.0 * found.sigma
    assert engine.happened["latency_doubted"] == 1
    assert any("the latency of the images is estimated" in str(one) for one in engine.events)
    before, after = (
        {
            one.robot_id
            for result in results
            for one in result.estimates
            if known is bool(latency(result))
        }
        for known in (False, True)
    )
    assert after <= before  # no robot gets a new label then
    ends = [result for result in results if result.estimates][-1].estimates
    truth = np.array([place(0.0) for place in ROBOTS.values()])
    for one in ends:
        assert np.linalg.norm(truth - one.position, axis=1).min() < 0.5


@pytest.mark.parametrize(("late_s", "after_s"), [(-1.3, 7.0), (0.8, 5.0)])
def test_images_count_from_the_first_telemetry_on(sea, late_s, after_s):
    """Telemetry for all candidates, 3 s either way and smoothed, is there from 6.6 s on."""
    engine = sea.estimator(STATED)
    drone = lambda t: (6.0 * math.sin(t), 0.0, 30.0)  # noqa: E731
    sea.play(engine, late_world(sea, late_s, drone), after_s)
    assert engine.happened["latency_doubted"] == 1


def errors(results, since_s):
    """Distances of robots from the nearest true one, from a time since the first image on, m."""
    truth = np.array([place(0.0) for place in ROBOTS.values()])
    begin_ns = results[0].stamp_ns
    return np.array([
        np.linalg.norm(truth - one.position, axis=1).min()
        for result in results if (result.stamp_ns - begin_ns) * 1e-9 > since_s
        for one in result.estimates
    ])  # fmt: skip


def test_what_images_told_before_is_not_lost(sea, monkeypatch):
    """The compass is 3 deg wrong: later images alone take long to tell that again."""
    flown = []
    for again in (True, False):
        if not again:
            nothing = replace(recent_images.TUNING, kept_ns=0)
            monkeypatch.setattr(recent_images, "TUNING", nothing)
            never = replace(latency_doubt.TUNING, known_s=0.0)
            monkeypatch.setattr(latency_doubt, "TUNING", never)
        world = late_world(sea, 1.0)
        world.rpy_bias_deg = (0.0, 0.0, 3.0)
        engine = sea.estimator(STATED)
        results = sea.play(engine, world, 24.0, images=5)
        assert engine.happened["latency_doubted"] == 1
        flown.append(float(np.sqrt(np.mean(errors(results, 14.0) ** 2))))
    assert flown[0] < 0.3
    assert flown[1] > 2.0 * flown[0]
    assert flown[1] > 0.35


def test_a_trial_is_published_once_it_has_caught_up(sea, monkeypatch):
    slow = replace(latency_trial.TUNING, catch_up_hz=20.0)
    monkeypatch.setattr(latency_trial, "TUNING", slow)
    engine, waited = sea.estimator(STATED), []
    take_over = engine._tracks._take_over
    engine._tracks._take_over = lambda trial: waited.append(len(trial.waiting)) or take_over(trial)
    sea.play(engine, late_world(sea, 1.0), 30.0, images=5)
    assert waited == [0, 0]  # with a latency that is not known, and with one that is


def test_each_box_is_used_or_refused_once(sea):
    """Also those that were pending when another tracker began to be published."""
    engine = sea.estimator(STATED)
    sea.play(engine, late_world(sea, 1.0, clutter=3.0, missed=0.1), 20.0, images=5)
    assert engine.happened["latency_doubted"] == 1
    assert engine.boxes == engine.used + engine.counts.total()


@pytest.mark.parametrize(("telemetry", "estimated"), [(1, True), (2, False), (3, False)])
def test_telemetry_with_stamps_of_images_is_late(sea, telemetry, estimated):
    """Two images a second, and telemetry with each other stamp, each one, or others."""
    engine = sea.estimator(STATED)
    world = late_world(sea, -0.3, lambda t: (0.5 * t, 0.0, 30.0))
    results = sea.play(engine, world, 9.0, images=2, telemetry=telemetry)
    assert bool(engine.happened["latency_doubted"]) is estimated
    assert any("stamps of images" in str(one) for one in engine.events) is estimated
    found = next((one for one in reversed([latency(result) for result in results]) if one), None)
    assert (found is not None) is estimated
    assert found is None or (abs(found.value + 0.3) < 3.0 * found.sigma and found.sigma < 0.5)


def test_the_configured_latency_is_kept_to_the_last_bit(sea):
    """Only covariances contain others, and only until they are ruled out."""
    flown = []
    for stated in (STATED, STATED | {"camera.find_latency": False}):
        engine = sea.estimator(stated)
        flown.append(sea.play(engine, late_world(sea, 0.0), 18.0))
        assert not engine.happened["latency_doubted"]
    assert places(flown[0])
    for result, alone in zip(*flown, strict=True):
        for one, other in zip(result.estimates, alone.estimates, strict=True):
            assert one.position.tolist() == other.position.tolist()
            assert one.velocity.tolist() == other.velocity.tolist()
            assert one.sigma >= other.sigma
    assert places(flown[0][-20:]) == places(flown[1][-20:])


def test_positions_contain_a_latency_that_is_not_found_yet(sea):
    """The camera was up to 5 m elsewhere."""
    beyond = []
    truth = np.array([place(0.0) for place in ROBOTS.values()])
    for find in (True, False):
        engine = sea.estimator(STATED | {"camera.find_latency": find})
        results = sea.play(engine, late_world(sea, 1.5), 5.0, images=5)
        assert not engine.happened["latency_doubted"]
        off = [
            np.linalg.norm(truth - one.position, axis=1).min() / one.sigma
            for result in results for one in result.estimates if one.state is State.CONFIRMED
        ]  # fmt: skip
        beyond.append(float(np.mean(np.square(off))))
    assert beyond[1] > 4.0 * beyond[0]


def circling(sea, late_s, until_s=1e9):
    """A world seen late by a drone on an even circle, which then flies back and forth instead."""

    def drone(t):
        turn = min(t, until_s) * math.radians(6.0)
        aside = 8.0 * math.sin(0.5 * max(t - until_s, 0.0))
        return 2.0 + 25.0 * math.cos(turn) + aside, 21.0 + 25.0 * math.sin(turn), 30.0

    def rpy_deg(t):
        return 0.0, 50.0, 6.0 * min(t, until_s) - 180.0

    given = {"robots": ROBOTS, "pixel_sigma": 2.0}
    world = sea.World(drone=drone, rpy_deg=rpy_deg, **given)
    seen = sea.World(
        drone=lambda t: drone(t - late_s), rpy_deg=lambda t: rpy_deg(t - late_s), **given
    )
    world.frame = seen.frame
    return world


def squared_error(one):
    """Squared error of a robot that stays, in units of its covariance."""
    off = np.array([robot(0.0) for robot in ROBOTS.values()]) - one.position
    nearest = off[np.linalg.norm(off, axis=1).argmin()]
    return nearest @ np.linalg.solve(one.covariance[:2, :2], nearest)


@pytest.fixture
def soon(monkeypatch):
    """Half a minute in motion is long: short flights show what happens then."""
    tuning = replace(time_in_motion.TUNING, often_s=30.0)
    monkeypatch.setattr(time_in_motion, "TUNING", tuning)


@pytest.mark.usefixtures("soon")
def test_positions_contain_a_latency_that_no_image_can_tell(sea):
    """On an even circle images look the same at any latency, turned about the circle's centre."""
    beyond = []
    for find in (True, False):
        engine = sea.estimator(STATED | {"camera.find_latency": find})
        results = sea.play(engine, circling(sea, 1.4), 45.0, images=5)
        assert not engine.happened["latency_doubted"]
        assert any("not told yet" in str(one) for one in engine.events) is find
        last = [one for one in results if one.estimates][-1].estimates
        beyond.append(np.mean([squared_error(one) for one in last]))
    assert beyond[0] < 30.0
    assert beyond[1] > 4.0 * beyond[0]


@pytest.mark.usefixtures("soon")
def test_images_that_tell_later_close_the_question(sea):
    engine = sea.estimator(STATED)
    world = circling(sea, 0.0, until_s=35.0)
    sea.play(engine, world, 35.0, images=5, until_flush=False)
    assert engine._tracks._doubt.long_open
    results = sea.play(engine, world, 20.0, images=5, begin=35.1)
    assert not engine._tracks._doubt.open
    assert not engine.happened["latency_doubted"]
    assert errors(results, 15.0).max() < 0.5


def test_a_doubt_that_ends_leaves_nothing_behind(sea, monkeypatch):
    """The other latency is tried from the first image on, and never believed."""
    tuning = replace(latency_doubt.TUNING, tried_nats=-50.0, dropped_nats=-60.0, doubted_nats=60.0)
    monkeypatch.setattr(latency_doubt, "TUNING", tuning)
    flown = []
    for find in (True, False):
        engine, world = sea.estimator(STATED | {"camera.find_latency": find}), late_world(sea, 0.0)
        tried = sea.play(engine, world, 8.0, images=5, until_flush=False)
        doubt = engine._tracks._doubt
        assert (doubt is not None and doubt.trial is not None) is find
        if doubt is not None:
            doubt.close()
        flown.append((tried, sea.play(engine, world, 2.0, begin=8.1, images=5)))
    (tried, left), (alone, never) = flown
    assert places(left)
    assert places(left) == places(never)
    for one, other in zip(tried, alone, strict=True):
        assert [e.robot_id for e in one.estimates] == [e.robot_id for e in other.estimates]
        assert one.rejections == other.rejections
    assert [e.sigma for e in tried[-1].estimates] != [e.sigma for e in alone[-1].estimates]


def test_what_surrounds_the_tracker_also_sees_the_other_latency(sea):
    engine, seen = sea.estimator(STATED), []

    def tapped(tracking):
        update = tracking.update

        def tap(frame, *given):
            seen.append(frame.latency)
            return update(frame, *given)

        tracking.update = tap
        return tracking

    engine.wrap_tracking(tapped)
    sea.play(engine, late_world(sea, 1.0), 18.0, images=5)
    assert engine.happened["latency_doubted"] == 1
    assert seen[0] is None
    assert seen[-1] is not None


def test_switched_off_it_is_not_doubted(sea):
    engine = sea.estimator(STATED | {"camera.find_latency": False})
    results = sea.play(engine, late_world(sea, 1.0), 18.0)
    assert not any(latency(result) for result in results)


def test_boxes_tell_it_without_a_robot_that_could_be_fitted(sea):
    """No track is confirmed, so that no box has a label."""
    engine = sea.estimator(STATED | {"tracks.confirm_hits": 100, "tracks.confirm_window_s": 3.0})
    results = sea.play(engine, late_world(sea, 1.5), 18.0, images=5, until_flush=False)
    assert not any(result.estimates for result in results)
    found = next(one for one in reversed([latency(result) for result in results]) if one)
    assert found.sigma < 0.5
    assert abs(found.value - 1.5) < 3.0 * found.sigma


def jumps_and_jumps_back(t):
    return 0.0, -8.0 * (6.0 < t < 9.0), 0.0


def turns_by_itself(t):
    return 0.0, 0.0, 20.0 * min(max(t - 6.0, 0.0), 4.0)


@pytest.mark.parametrize("wrong_deg", [jumps_and_jumps_back, turns_by_itself])
@pytest.mark.parametrize("drone", [lambda _t: (0.0, 0.0, 30.0), to_and_fro], ids=["hover", "flies"])
def test_telemetry_that_is_wrong_is_no_latency(sea, drone, wrong_deg):
    world = late_world(sea, 0.0, drone)
    gimbal = world.gimbal

    def wrong(t):
        world.rpy_bias_deg = wrong_deg(t)
        return gimbal(t)

    world.gimbal = wrong
    engine = sea.estimator(STATED)
    sea.play(engine, world, 16.0, images=5)
    assert not engine.happened["latency_doubted"]


def test_pictures_that_jump_are_no_latency(sea):
    """Boxes are off by 150 px for three seconds: at all latencies alike."""
    world = late_world(sea, 0.0, lambda t: (2.0 * math.sin(0.3 * t), 0.0, 30.0))
    frame = world.frame

    def jumping(t):
        shown = frame(t)
        return replace(shown, centers=shown.centers + 150.0 * (8.0 < t < 11.0))

    world.frame = jumping
    engine = sea.estimator(STATED)
    sea.play(engine, world, 20.0, images=5)
    assert not engine.happened["latency_doubted"]


def test_a_steady_camera_tells_nothing(sea):
    engine = sea.estimator(STATED)
    still = lambda _t: (0.0, 0.0, 30.0)  # noqa: E731
    results = sea.play(engine, late_world(sea, 1.0, still), 15.0)
    assert not any(latency(result) for result in results)


def test_a_calibration_in_flight_does_not_end_the_search(sea):
    engine, world = sea.estimator(STATED), late_world(sea, 1.0)
    sea.play(engine, world, 18.0, until_flush=False)
    assert engine.happened["latency_doubted"] == 1
    engine.reconfigure(estimator_config({**sea.origin, **STATED, "calibration.height_m": 0.1}))
    results = sea.play(engine, world, 3.0, begin=18.1)
    assert latency(results[-1]) is not None


def test_a_failure_once_the_latency_is_found_leaves_it_found(sea, monkeypatch):
    known = latency_doubt.LatencyDoubt._known

    def fails(doubt):
        assert not doubt.doubted
        return known(doubt)

    monkeypatch.setattr(latency_doubt.LatencyDoubt, "_known", fails)
    never = replace(latency_doubt.TUNING, known_s=0.0)
    monkeypatch.setattr(latency_doubt, "TUNING", never)
    engine, world = sea.estimator(STATED), late_world(sea, 1.0)
    sea.play(engine, world, 18.0, images=5, until_flush=False)
    assert engine.happened["latency_doubted"] == 1
    engine.reconfigure(estimator_config({**sea.origin, **STATED, "calibration.height_m": 0.1}))
    results = sea.play(engine, world, 3.0, begin=18.1, images=5)
    assert engine._tracks.pipeline.latency.found is not None
    assert results[-1].estimates


def test_a_latency_is_known_no_better_than_stamps_of_telemetry(sea):
    """Telemetry once a second has stamps of images, of which there are two a second."""
    engine = sea.estimator(STATED)
    results = sea.play(engine, late_world(sea, 1.0), 40.0, images=2, telemetry=1)
    found = next(one for one in reversed([latency(result) for result in results]) if one)
    assert abs(found.value - 1.0) < 3.0 * found.sigma
    assert 0.5 / math.sqrt(12.0) < found.sigma < 0.3
