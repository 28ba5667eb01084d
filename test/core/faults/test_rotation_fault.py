# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera that turns is distinguished from robots that swim, or the ambiguity is published."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.rotation_fault import RobotsInView, RotationFault
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation
from aerial_gnss_ros.core.faults.velocity_changes import VelocityChanges
from aerial_gnss_ros.core.filter import blocks
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.measurement_model import pose_jacobian
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

PLACES = np.array([[4.0, 18.0, -30.0], [-6.0, 22.0, -30.0], [1.0, 30.0, -30.0]])
BY_ANGLES = pose_jacobian(PLACES)[:, :, 3:]


def _laws(*counts):
    """Return what is known of the velocities of so many robots in each of some joint laws."""
    laws = [VelocityChanges() for _ in counts]
    for law, count in zip(laws, counts, strict=True):
        law.add(count)
    return laws


def _flown(turning, laws, by_angles, changed, loosened, seconds, rng):
    """Yield the time while a plain filter follows robots whose boxes are off by 5 cm.

    Args:
        turning: is called, as by the joint filter.
        laws: of the robots one after another; called likewise.
        by_angles: (n, 2, 3) how places move with the camera's angles, m/rad.
        changed: (n, 2) of time (s): by how much velocities have changed, m/s.
        loosened: robots whose velocities become uncertain by 0.75 m/s, by image.
        seconds: how long.
        rng: of the stated acceleration and the boxes.
    """
    dt, count, of_box, q = 0.1, len(by_angles), 0.05**2, 0.05**2
    ends = np.cumsum([len(law.position_covariances) for law in laws])
    shares = [
        np.arange(end - len(law.position_covariances), end)
        for law, end in zip(laws, ends, strict=True)
    ]
    assert ends[-1] == count
    step = np.array([[1.0, dt], [0.0, 1.0]])
    noise = q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    P = np.tile(np.diag([of_box, 0.05**2]), (count, 1, 1))
    place, velocity = np.zeros((count, 2)), np.zeros((count, 2))
    mean = np.zeros((count, 2, 2))  # of each robot and axis: place, velocity
    for image in range(round(seconds / dt)):
        more = math.sqrt(q * dt) * rng.standard_normal((count, 2))
        place += dt * (velocity + 0.5 * more + changed(image * dt))
        velocity += more
        P, mean = step @ P @ step.T + noise, mean @ step.T
        turning.predict(dt, 1.0)
        hit = loosened.get(image, [])
        P[hit] += 0.75**2 * np.array([[0.25, 0.5], [0.5, 1.0]])
        gain = P[:, :, 0] / (P[:, 0, 0] + of_box)[:, None]
        off = place + 0.05 * rng.standard_normal((count, 2)) - mean[:, :, 0]
        expected = 2.0 * gain[:, 1] * P[:, 1, 0]
        mean += off[:, :, None] * gain[:, None, :]
        P = P - gain[:, :, None] * P[:, :1, :]
        seen = []
        for law, share in zip(laws, shares, strict=True):
            slots = share - share[0]
            law.predict(dt, q * dt)
            law.note_inflation(slots[np.isin(share, hit)], 0.75**2)
            law.update(slots, gain[share, 1, None] * off[share], expected[share])
            seen.append(RobotsInView(law, slots, by_angles[share], 2.0 * P[share, 1, 1], 1.5))
        if turning.due:
            turning.judge(seen)
        yield image * dt


STRAYS = {image: [image // 17 % 2] for image in range(20, 2000, 17)}
"""One of two robots every 1.7 s whose box was beside it once."""


def test_robots_that_were_taken_for_swerving_are_no_turn(monkeypatch):
    """What they were loosened by hides neither what is stated nor how they are found again.

    From 10 m, where 5 cm are 0.3 deg: the nearest to a turn that 1,000 s come.
    """
    near, gains = BY_ANGLES[:2] / 3.0, []

    def heard(*given):
        found = fit_rotation(*given)
        gains.append(found[2])
        return found

    monkeypatch.setattr("aerial_gnss_ros.core.faults.rotation_fault.fit_rotation", heard)
    for seed in range(10):
        rng = np.random.default_rng(seed)
        list(_flown(RotationFault(), _laws(2), near, lambda _t: 0.0, STRAYS, 100.0, rng))
    assert len(gains) > 1500
    assert max(gains) < 0.0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_turn_is_distinguished_from_robots_that_were_loosened_when_it_began(axis):
    """What they are loosened by when their boxes begin to be off does not explain it."""
    turn = np.radians(2.0 * np.eye(3)[axis])
    turning, loosened = RotationFault(), STRAYS | {104: [0, 1, 2]}
    times = _flown(
        turning,
        _laws(3),
        BY_ANGLES,
        lambda t: -BY_ANGLES @ turn * (t > 10.0),
        loosened,
        16.0,
        np.random.default_rng(axis),
    )
    began = next(t for t in times if turning.rotating)
    assert 10.0 < began < 13.0
    assert list(times)
    assert turning.rate == pytest.approx(turn, abs=np.radians(0.7))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_turn_that_went_back_and_ended_leaves_little_doubt(axis):
    """The rate at which it turned follows from its stop, and the angle from the rate."""
    turn = np.radians(2.0 * np.eye(3)[axis])

    def changed(t):
        return -BY_ANGLES @ turn * (float(10.0 < t <= 18.0) - float(18.0 < t <= 26.0))

    turning, laws, sigmas = RotationFault(), _laws(3), {}
    for t in _flown(turning, laws, BY_ANGLES, changed, {}, 40.0, np.random.default_rng(axis)):
        sigmas[round(t, 1)] = np.linalg.norm(laws[0].position_covariances, axis=(1, 2)).max() ** 0.5
    assert not sigmas[9.9]
    far = np.linalg.norm(BY_ANGLES @ turn, axis=1).max() * 8.0
    assert 0.8 * far < sigmas[18.0] < 2.0 * far
    assert sigmas[30.0] < 0.5 * sigmas[18.0]
    assert not turning.rotating


@pytest.mark.parametrize("noise", [1.0, 30.0])
def test_what_larger_noise_may_have_caused_is_no_turn(noise):
    class Doubting(RotationFault):
        def judge(self, seen):
            super().judge(seen, noise=noise)

    turning, moves = Doubting(), -BY_ANGLES @ np.radians([0.0, 0.0, 1.2])
    rng = np.random.default_rng(2)
    list(_flown(turning, _laws(3), BY_ANGLES, lambda t: moves * (t > 10.0), {}, 14.0, rng))
    assert turning.rotating == (noise == 1.0)


@pytest.mark.parametrize("counts", [(1, 1, 1), (2, 1)])
def test_robots_in_several_laws_tell_of_one_camera_as_in_one(counts):
    """None of the laws alone has robots enough to detect this turn."""
    turn, found = np.radians([0.0, 0.0, 1.2]), []

    def reported(laws, share=BY_ANGLES):
        turning, moves = RotationFault(), -share @ turn
        rng = np.random.default_rng(2)
        list(_flown(turning, laws, share, lambda t: moves * (t > 10.0), {}, 14.0, rng))
        return turning

    for law, share in zip(_laws(*counts), np.split(BY_ANGLES, np.cumsum(counts)[:-1]), strict=True):
        assert not reported([law], share).rotating
    for laws in (_laws(3), _laws(*counts)):
        turning = reported(laws)
        found.append((turning.rate, np.concatenate([law.position_covariances for law in laws]),
                      np.concatenate([law.velocity_covariances for law in laws])))  # fmt: skip
    assert found[0][0] == pytest.approx(turn, abs=np.radians(0.4))
    for whole, parted in zip(*found, strict=True):
        np.testing.assert_allclose(parted, whole, rtol=1e-9, atol=1e-15)


def test_one_law_whose_robots_swim_as_a_turn_would_have_it_is_no_turn():
    """Those of another law stay where they are: the first alone would indicate a turn."""
    turn = np.radians([0.0, 0.0, 2.0])
    moves = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])[:, None]
    by_angles = np.concatenate([BY_ANGLES, BY_ANGLES[::-1] * 1.1])
    turns = []
    for laws, taken in ((_laws(3), 3), (_laws(3, 3), 6)):
        turning, share = RotationFault(), by_angles[:taken]
        swims = -moves[:taken] * (share @ turn)
        list(_flown(turning, laws, share, lambda t, swims=swims: swims * (t > 10.0), {}, 14.0,
                    np.random.default_rng(4)))  # fmt: skip
        turns.append(turning.rotating)
    assert turns == [True, False]


def test_robots_in_sight_are_judged_as_stated_while_another_is_not():
    """The noise of a step in which one robot loses its course allows the others nothing."""
    joint = JointState(np.eye(COUNT) * 1e-6)
    places = np.array([[0.0, 20.0], [5.0, 22.0], [9.0, 18.0]])
    joint.add(np.arange(3), places, np.zeros((3, 2, COUNT)), np.tile(np.eye(2), (3, 1, 1)), 0.75)
    joint.unseen = np.array([0.0, 0.0, 0.45])
    noise = SimpleNamespace(decay=lambda _s: np.ones(COUNT))
    heard = []
    joint.velocity_changes.note_inflation = lambda _slots, variance: heard.append(variance)
    joint.predict(0.1, noise.decay(0.1), np.eye(COUNT) * 1e-6, MotionModel(0.05, 0.75))
    assert heard[0] == pytest.approx([0.0, 0.0, 0.75**2 * (1.0 - np.exp(-0.05))], abs=2e-4)


ROBOTS = {
    "a": lambda _t: (2.0, 21.0),
    "b": lambda t: (-3.0 + 0.2 * t, 14.0),
    "c": lambda t: (-6.0, 24.0 - 0.1 * t),
}


def _squares(world, results, sea, of):
    """Return squared normalised errors of robots in sight, and their sigmas (m)."""
    squares, sigmas = [], []
    for result in results:
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                error = one.position - world.robots[of[one.robot_id]](t)
                squares.append(error @ np.linalg.solve(one.covariance[:2, :2], error))
                sigmas.append(math.sqrt(0.5 * np.trace(one.covariance[:2, :2])))
    return np.array(squares), np.array(sigmas)


@pytest.mark.parametrize(
    ("axis", "robots_a_law"), [(1, 32), (2, 32), (2, 1)], ids=["pitch", "yaw", "yaw, many laws"]
)
def test_a_runaway_slower_than_robots_is_published_as_doubt(sea, axis, robots_a_law, monkeypatch):
    """2 deg/s for 8 s at 34 m is some 10 m: robots seem to swim, and nobody can say it is wrong."""
    monkeypatch.setattr(blocks, "TUNING", replace(blocks.TUNING, block_robots=robots_a_law))
    # A gimbal whose values are equal to the last bit between two steps would only repeat old ones.
    rpy_deg = lambda t: (1e-6 * t, 60.0, 90.0)  # noqa: E731
    world = sea.World(robots=ROBOTS, rpy_deg=rpy_deg, pixel_sigma=1.5)
    engine = sea.estimator({"noise.gnss_offset_m": 0.02})
    before = sea.play(engine, world, 8.0, images=10, until_flush=False)
    of = {
        e.robot_id: min(ROBOTS, key=lambda name: np.linalg.norm(e.position - ROBOTS[name](8.0)))
        for e in before[-1].estimates
    }
    assert not engine.health.complaints
    calm = _squares(world, before[20:], sea, of)[1].max()
    parts = {}
    for name, begin, length, angle in (
        ("runs", 8.2, 40, lambda i: 0.4 * i),
        ("back", 16.2, 40, lambda i: 16.0 - 0.4 * i),
        ("right", 24.2, 20, lambda _i: 0.0),
    ):
        parts[name] = []
        for i in range(length):
            bias = [0.0, 0.0, 0.0]
            bias[axis] = angle(i)
            world.rpy_bias_deg = tuple(bias)
            parts[name] += sea.play(
                engine, world, 0.1, begin=begin + 0.2 * i, images=10, until_flush=False
            )
        squares, sigmas = _squares(world, parts[name], sea, of)
        assert np.quantile(squares, 0.98) < 13.8  # one in a thousand, if the covariance is right
        parts[name] = sigmas
    assert any("if the camera had rotated" in sentence for sentence in engine.health.complaints)
    assert parts["runs"][-3:].min() > 2.0  # m
    # The way back takes some away; of a yaw nothing, since a compass deviates by heading.
    left = 1.25 if axis == 2 else 0.8
    assert calm < parts["right"][-1] < left * parts["runs"].max()


def test_tracks_that_tell_nothing_are_displaced_with_the_camera():
    """One that becomes a robot at an image is as uncertain as those that told of the turn."""
    turning, moves = RotationFault(), -BY_ANGLES @ np.radians([0.0, 0.0, 1.2])
    laws, rng = _laws(3), np.random.default_rng(2)
    list(_flown(turning, laws, BY_ANGLES, lambda t: moves * (t > 10.0), {}, 14.0, rng))
    late = _laws(3)[0]
    unknown = np.full(3, 0.1)
    there = RobotsInView(late, np.arange(3), BY_ANGLES, unknown, np.full(3, 1.0))
    turning.judge([], [there])
    expected = BY_ANGLES @ turning.covariance @ BY_ANGLES.swapaxes(1, 2)
    assert np.trace(expected[0]) > 0.01
    np.testing.assert_allclose(
        late.position_covariances, expected + turning.ambiguity.apart * np.eye(2)
    )
