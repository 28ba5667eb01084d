# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cases in flight: every vehicle flies, planted faults are found, and results are judged."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State
from fuzz import engine, flight, messages, mutate
from fuzz.checks import FAR_M, check
from fuzz.vehicles import VEHICLES


def target(name):
    return next(one for one in messages.targets() if one.name == name)


def test_vehicles_send_every_kind_of_message():
    configs = [flight.config_of(vehicle) for vehicle in VEHICLES]
    for name, kinds in (
        ("fix", FIX),
        ("attitude", ATTITUDE),
        ("gimbal", GIMBAL),
        ("height", HEIGHT),
    ):
        assert {getattr(config, name).type for config in configs} == set(kinds), name


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_without_damage_robots_are_where_they_are(vehicle):
    aircraft = flight.in_flight(vehicle)
    results = []
    for tick in flight.flown(vehicle)[60:80]:
        for arrival in tick:
            results += aircraft.feed(arrival.name, arrival.message, arrival.log_ns)
    assert len(results) >= 19  # a latency in doubt makes images wait
    truth = flight.truth(VEHICLES[vehicle].flight)
    for result in results:
        if not VEHICLES[vehicle].judged:
            assert len(result.estimates) >= 3
            continue
        check(result, truth)
        assert [one.state for one in result.estimates] == [State.CONFIRMED] * 3
        where = np.array([
            truth.local.positions(one.latitude, one.longitude) for one in result.estimates
        ]).reshape(3, 2)  # fmt: skip
        off = np.linalg.norm(where[:, None] - truth.at(result.stamp_ns)[None], axis=2)
        assert sorted(off.argmin(axis=1)) == [0, 1, 2]
        assert off.min(axis=1).max() < FAR_M


def test_an_aircraft_is_ones_own():
    first, second = flight.in_flight("generic"), flight.in_flight("generic")
    for arrival in flight.flown("generic")[60]:
        first.feed(arrival.name, arrival.message, arrival.log_ns)
    assert second.estimator.inputs["fix"].count < first.estimator.inputs["fix"].count


def test_a_planted_fault_of_an_adapter_is_found(monkeypatch):
    true = canonical.scalar

    def raises_below_zero(msg, stamp_ns):
        value = true(msg, stamp_ns)
        if value.value < 0.0:
            raise ZeroDivisionError("planted")
        return value

    monkeypatch.setattr(canonical, "scalar", raises_below_zero)
    found = engine.run(target("messages"), 1, 0, 200).findings
    planted = [one for one in found if "ZeroDivisionError" in one.words]
    assert planted
    assert {one.kind for one in planted} == {engine.GUARDED}
    again = engine.run(target("messages"), 1, planted[0].case, 1).findings
    assert [one.words for one in again] == [planted[0].words]
    assert "height" in planted[0].words


def test_what_the_estimator_catches_itself_is_found(monkeypatch):
    def fails(_self, _frame, _samples):
        raise ZeroDivisionError("planted")

    flight.in_flight("generic")  # tracked before the fault comes
    monkeypatch.setattr(Pipeline, "result", fails)
    found = engine.run(target("bytes"), 1, 0, 3).findings
    assert [one.kind for one in found] == [engine.GUARDED] * 3
    assert "ZeroDivisionError in " in found[0].where


def test_a_planted_wrong_position_is_found(monkeypatch):
    true = flight.Truth.at
    aside = np.array([30.0, 0.0])
    monkeypatch.setattr(flight.Truth, "at", lambda self, stamp: true(self, stamp) + aside)
    assert engine.run(target("bytes"), 1, 0, 3).count(engine.WRONG) == 3


def _estimate(east=0.0, sigma=1.0, **changed):
    truth = flight.truth()
    here = truth.at(flight.START_NS)[:1] + np.array([east, 0.0])
    latitude, longitude = truth.local.places(here)
    made = RobotEstimate(
        flight.START_NS, "aqua_1", "aqua", State.CONFIRMED, float(latitude[0]), float(longitude[0]),
        math.nan, here[0], np.zeros(2), sigma**2 * np.eye(4), 0,
    )  # fmt: skip
    return FrameResult(flight.START_NS, "camera", (replace(made, **changed),), (), None)


def _kind(result):
    try:
        check(result, flight.truth())
    except engine.Broken as broken:
        return broken.kind
    return None


def test_wrong_is_far_from_all_robots_and_confident():
    away = 400.0  # farther than the other robots
    assert _kind(_estimate()) is None
    assert _kind(_estimate(east=4.9, sigma=0.01)) is None
    assert _kind(_estimate(east=away, sigma=away / 3.9)) is None
    assert _kind(_estimate(east=away, sigma=away / 4.2)) == engine.WRONG
    assert _kind(_estimate(east=-away, sigma=1.0)) == engine.WRONG


@pytest.mark.parametrize(
    "changed",
    [
        {"position": np.array([math.nan, 0.0])},
        {"velocity": np.array([0.0, math.inf])},
        {"covariance": np.diag([1.0, 1.0, math.nan, 1.0])},
        {"covariance": np.diag([1.0, -1e-3, 1.0, 1.0])},
        {"covariance": np.diag([1.0, 0.0, 1.0, 1.0])},
        {"covariance": np.diag([1.0, 1.0, 1.0, -1e-3])},
        {"covariance": np.eye(4) + np.eye(4, k=1) * 0.1},
        {"latitude": 1.6},
        {"latitude": math.nan},
        {"longitude": -3.2},
        {"altitude": math.inf},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_numbers_that_are_none_are_found(changed):
    assert _kind(_estimate(**changed)) == engine.NOT_FINITE


def test_fields_stay_of_their_types():
    """What a topic can bring is damaged, no more: a serializer accepts every damaged message."""
    store, rng = flight.typestore(), random.Random(1)
    for vehicle in VEHICLES:
        for arrival in flight.flown(vehicle)[60]:
            for leaf in messages.leaves(arrival.msgtype, arrival.message):
                message = store.deserialize_cdr(arrival.raw, arrival.msgtype)
                messages.set_field(rng, message, leaf)
                store.serialize_cdr(message, arrival.msgtype)
    assert arrival.raw == bytes(store.serialize_cdr(arrival.message, arrival.msgtype))


def test_numbers_become_what_hurts():
    rng = random.Random(1)
    made = [mutate.number(rng, 13.2) for _ in range(3000)]
    assert any(map(math.isnan, made))
    assert {math.inf, -math.inf, 0.0, 1e308, -13.2} <= set(made)
    whole = [mutate.whole(rng, 5, "int8") for _ in range(3000)]
    assert (min(whole), max(whole)) == (-128, 127)
    assert min(mutate.whole(rng, 0, "uint32") for _ in range(1000)) == 0


def test_a_box_that_is_put_into_images_is_no_wrong_position():
    """One that stays for three images is a robot as far as anyone can know; one image is not."""
    phantoms = flight.Phantoms("generic")
    for tick in (60, 61, 62):
        true = flight.flown("generic")[tick][-1]
        message = flight.typestore().deserialize_cdr(true.raw, true.msgtype)
        phantoms.add(tick, true.message, true.message)
        assert not len(phantoms.places)
        message.detections[0].bbox.center.position.x = 20.0
        message.detections[0].bbox.center.position.y = 100.0
        phantoms.add(tick, message, true.message)
    place = phantoms.places[-1]
    off = place - flight.truth().at(flight.START_NS + 6_200_000_000)
    assert np.linalg.norm(off, axis=1).min() > 5.0
    latitude, longitude = flight.truth().local.places(place[None])
    put = _estimate(latitude=float(latitude[0]), longitude=float(longitude[0]), sigma=0.5)
    assert _kind(put) == engine.WRONG
    check(put, flight.truth(), phantoms.places)
