# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The joint filter's prediction and correction against a Kalman filter from the textbook."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, LATENCY, PlatformModel

sys.path.insert(0, str(Path(__file__).parent))

from three_robots import MODEL, PLACES, crowd, sight


def textbook_step(
    unseen: float, seconds: float, motion: MotionModel
) -> tuple[np.ndarray, np.ndarray]:
    """Van Loan's integral (1978) of one robot's motion: straight on, turning, cruising."""
    held = 2.0 if unseen == 0.0 else MOTION_MODEL.held_s
    straight = min(max(held - unseen, 0.0), seconds)
    parts = [(straight, 0.0, motion.acceleration**2)]
    turning = min(max(held + MOTION_MODEL.turn_s - unseen - straight, 0.0), seconds - straight)
    for time, length in (
        (MOTION_MODEL.turn_s, turning),
        (MOTION_MODEL.cruise_s, seconds - straight - turning),
    ):
        parts.append((length, 1.0 / time, 2.0 * motion.speed_sigma**2 / time))
    transition, noise = np.eye(2), np.zeros((2, 2))
    for length, rate, density in parts:
        A = np.array([[0.0, 1.0], [0.0, -rate]])
        big = np.block([[-A, np.diag([0.0, density])], [np.zeros((2, 2)), A.T]]) * length
        exponential = expm(big)
        step = exponential[2:, 2:].T
        transition = step @ transition
        noise = step @ noise @ step.T + step @ exponential[:2, 2:]
    return np.kron(transition, np.eye(2)), np.kron(noise, np.eye(2))


@pytest.mark.parametrize("seconds", [0.033, 0.7, 5.0])
def test_prediction_is_that_of_the_textbook(seconds):
    joint, motion = crowd(), MotionModel(0.05, 0.75)
    joint.unseen = np.array([0.0, 0.3, 20.0])
    steps = [textbook_step(float(unseen), seconds, motion) for unseen in joint.unseen]
    keep = np.exp(-seconds / np.array([300.0] * 2 + [500.0] * 4 + [300.0] * 2 + [3600.0]))
    F = block_diag(np.diag(keep), *(step[0] for step in steps))
    Q = block_diag(np.diag(1.0 - keep**2) @ MODEL.stationary(None), *(step[1] for step in steps))
    mean, covariance = F @ joint.mean, F @ joint.covariance @ F.T + Q
    joint.predict(seconds, MODEL.decay(seconds), MODEL.stationary(None), motion)
    np.testing.assert_allclose(joint.mean, mean, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(joint.covariance, covariance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(joint.unseen, np.array([0.0, 0.3, 20.0]) + seconds)


def test_an_error_that_is_switched_off_stays_zero():
    model = PlatformModel(Noise(), "earth")
    joint = JointState(model.stationary(None))
    joint.add(np.arange(1), PLACES[:1], np.ones((1, 2, COUNT)), np.eye(2)[None], 0.5)
    for _ in range(3):
        joint.predict(0.1, model.decay(0.1), model.stationary(None), MotionModel(0.05, 0.75))
        pixels = linearise(sight(), joint.mean[:COUNT], joint.robots[:, :2]).pixels + 3.0
        correct(joint, np.arange(1), pixels, sight(), model)
    assert joint.mean[LATENCY] == 0.0
    assert not joint.covariance[LATENCY].any()


def test_a_robot_that_surfaces_brings_its_old_knowledge():
    joint = crowd()
    joint.mean[COUNT : COUNT + 4] = [1.0, 1.0, 0, 0]
    joint.mean[COUNT + 4 : COUNT + 8] = [1.3, 0.9, 0, 0]
    H = np.zeros((2, COUNT + 12))
    H[:, COUNT : COUNT + 2], H[:, COUNT + 4 : COUNT + 6] = np.eye(2), -np.eye(2)
    P = joint.covariance.copy()
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + 0.01 * np.eye(2))
    mean, covariance = joint.mean - K @ H @ joint.mean, P - K @ H @ P
    joint.tie(0, 1, 0.1)
    np.testing.assert_allclose(joint.mean, mean, atol=1e-12)
    np.testing.assert_allclose(joint.covariance, covariance, atol=1e-12)


def test_robots_go_along_with_a_jump_and_the_law_says_nothing_of_it():
    joint = crowd()
    joint.camera = np.array([1.0, 2.0, 30.0])
    before, robots = joint.covariance.copy(), joint.robots.copy()
    joint.shift(np.array([30.0, 40.0]))
    np.testing.assert_allclose(joint.robots - robots, [[30.0, 40.0, 0.0, 0.0]] * len(robots))
    np.testing.assert_allclose(joint.camera, [31.0, 42.0, 30.0])
    np.testing.assert_array_equal(joint.covariance, before)


def test_an_error_known_from_elsewhere_leaves_what_is_known_given_it():
    """Only the latency's own law changes: what holds for each latency stays."""
    joint = crowd()
    others = np.flatnonzero(np.arange(len(joint.mean)) != LATENCY)

    def given_latency(latency: float) -> tuple[np.ndarray, np.ndarray]:
        P, mean = joint.covariance, joint.mean
        by_latency = P[others, LATENCY] / P[LATENCY, LATENCY]
        return (
            mean[others] + by_latency * (latency - mean[LATENCY]),
            P[np.ix_(others, others)] - np.outer(by_latency, P[LATENCY, others]),
        )

    before = given_latency(0.4)
    for mean, sigma in ((0.25, 0.02), (0.3, 0.1)):
        joint.settle(LATENCY, mean, sigma)
        assert joint.mean[LATENCY] == pytest.approx(mean)
        assert joint.covariance[LATENCY, LATENCY] == pytest.approx(sigma**2)
        for now, then in zip(given_latency(0.4), before, strict=True):
            np.testing.assert_allclose(now, then, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("more", [1.0, 5.0, 9.0])
def test_boxes_that_were_noisier_than_assumed_count_as_if_that_had_been_known(more):
    """As a Kalman filter gives from the same prior and the same boxes of nine times the noise.

    Also where the prior of the angles has to be wider.
    """
    prior, wider = MODEL.stationary(None).copy(), np.ones(COUNT)
    prior[LATENCY, LATENCY], wider[ANGLES] = 0.0, more

    def after(factor: float, prior: np.ndarray) -> JointState:
        joint = JointState(prior)
        by_platform = linearise(sight(), np.zeros(COUNT), PLACES).by_platform * 0.01
        white = np.tile(factor * 0.04 * np.eye(2), (3, 1, 1))
        joint.add(np.arange(3), PLACES, by_platform, white, 0.7)
        H = np.random.default_rng(5).normal(size=(5, len(joint.mean)))
        P = joint.covariance
        gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + factor * 0.3 * np.eye(5))
        joint.mean = joint.mean + gain @ (np.arange(5.0) - H @ joint.mean)
        joint.covariance = P - gain @ H @ P
        return joint

    found, right = after(1.0, prior), after(9.0, wider * prior)
    found.discount(9.0, prior, 0.7, wider)
    np.testing.assert_allclose(found.covariance, right.covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.mean, right.mean, rtol=1e-6, atol=1e-9)


def test_doubted_platform_errors_leave_robots_as_they_are_given_these():
    """The information beyond the prior's is divided by 5, as that of five times the noise."""
    prior = MODEL.stationary(None).copy()
    prior[LATENCY, LATENCY] = 0.0

    def after(noise: float) -> JointState:
        joint = JointState(prior)
        H = np.random.default_rng(7).normal(size=(9, COUNT))
        P = joint.covariance
        gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + noise * np.eye(9))
        joint.mean, joint.covariance = gain @ np.arange(9.0), P - gain @ H @ P
        by_platform = linearise(sight(), np.zeros(COUNT), PLACES).by_platform * 0.01
        joint.add(np.arange(3), PLACES, by_platform, np.tile(0.04 * np.eye(2), (3, 1, 1)), 0.7)
        return joint

    found, right = after(0.01), after(0.05)
    moved = right.mean[:COUNT] - found.mean[:COUNT]
    by_platform = linearise(sight(), np.zeros(COUNT), PLACES).by_platform * 0.01
    right.robots[:, :2] += by_platform @ moved
    found.doubt_platform(5.0, prior)
    np.testing.assert_allclose(found.covariance, right.covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.mean, right.mean, rtol=1e-6, atol=1e-9)


def test_what_is_forgotten_is_decided_by_the_next_image_alone():
    """As a robot that begins, in mean and covariance, whatever was known of it before."""
    joint, slots = crowd(), np.array([0, 1])
    pixels = linearise(sight(), np.zeros(COUNT), PLACES[:2]).pixels
    joint.settle(LATENCY, 0.0, 0.5)
    joint.forget(slots, MODEL.stationary(None), 2.0)
    correct(joint, slots, pixels, sight(), MODEL)
    np.testing.assert_allclose(joint.robots[:2, :2], PLACES[:2], atol=1e-3)
    linear = linearise(sight(), np.zeros(COUNT), PLACES[:2])
    errors = MODEL.stationary(None)
    errors[LATENCY, LATENCY] = 0.25
    for i in (0, 1):
        back = np.linalg.inv(linear.by_place[i])
        pose = linear.by_pose[i]
        noise = linear.by_platform[i] @ errors @ linear.by_platform[i].T
        noise += (pose * MODEL.white) @ pose.T + MODEL.pixel * np.eye(2)
        np.testing.assert_allclose(
            joint.blocks()[i, :2, :2], back @ noise @ back.T, rtol=5e-3, atol=5e-3
        )


def test_how_likely_robots_have_one_position_is_told_as_they_are_tied():
    """They are 0.6 m apart, in sigmas of 0.5 m: sqrt(0.12 + 0.12 + 0.01)."""
    state = JointState(0.25 * np.eye(COUNT))
    own = np.tile(np.diag([0.12, 0.12, 1.0, 1.0]), (2, 1, 1))
    places = np.array([[0.0, 0.0, 0.0, 0.0], [0.6, 0.0, 0.0, 0.0]])
    state.append(np.arange(2), places, np.zeros((2, 4, COUNT)), own)
    assert state.tie(0, 1, 0.1) == pytest.approx(-0.5 * (0.36 / 0.25 + 2.0 * math.log(0.25)))
    np.testing.assert_allclose(state.robots[:, 0], [0.6 * 0.12 / 0.25, 0.6 * 0.13 / 0.25])
