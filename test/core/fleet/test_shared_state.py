# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The state of several drones is the Kalman filter of all of them, written out densely here."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag

from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.fleet.shared_state import SharedState, white_on_water
from aerial_gnss_ros.core.models.platform_model import COUNT, HEIGHT, LATENCY

sys.path.insert(0, str(Path(__file__).parent))

from three_drones import MODELS, MOTION, PLACES, STATIONARY, sight

ERRORS = len(STATIONARY) * COUNT


class Dense:
    """The same filter with matrices as in a textbook."""

    def __init__(self, share):
        self.n = len(STATIONARY)
        self.prior = block_diag(*STATIONARY)
        for i in range(self.n):
            for j in range(self.n):
                least = min(STATIONARY[i][0, 0], STATIONARY[j][0, 0])
                for axis in (0, 1):
                    if i != j:
                        self.prior[COUNT * i + axis, COUNT * j + axis] = share * least
        self.mean, self.P = np.zeros(COUNT * self.n), self.prior.copy()

    def jacobian(self, drone, linear, slots):
        H = np.zeros((2 * len(slots), len(self.mean)))
        errors = slice(COUNT * drone, COUNT * drone + COUNT)
        for row, slot in enumerate(slots):
            H[2 * row : 2 * row + 2, errors] = linear.by_platform[row]
            k = COUNT * self.n + 4 * slot
            H[2 * row : 2 * row + 2, k : k + 2] = linear.by_place[row]
        return H

    def begin(self, drone, linear, model, places):
        by_place = np.linalg.inv(linear.by_place)
        errors = slice(COUNT * drone, COUNT * drone + COUNT)
        G = np.zeros((4 * len(places), len(self.mean)))
        alone = np.zeros((4 * len(places),) * 2)
        white = white_on_water(linear, model)
        for i in range(len(places)):
            G[4 * i : 4 * i + 2, errors] = -by_place[i] @ linear.by_platform[i]
            alone[4 * i : 4 * i + 2, 4 * i : 4 * i + 2] = white[i]
            alone[4 * i + 2 : 4 * i + 4, 4 * i + 2 : 4 * i + 4] = 0.75**2 * np.eye(2)
        self.P = np.block([[self.P, self.P @ G.T], [G @ self.P, G @ self.P @ G.T + alone]])
        new = np.zeros((len(places), 4))
        new[:, :2] = places
        self.mean = np.concatenate([self.mean, new.ravel()])

    def predict(self, seconds):
        keep = np.concatenate([model.decay(seconds) for model in MODELS])
        m = (len(self.mean) - len(keep)) // 4
        one = np.eye(4)
        one[0, 2] = one[1, 3] = seconds
        F = block_diag(np.diag(keep), *[one] * m)
        q, s = 0.05**2, seconds
        axis = np.array([[s**3 / 3, s**2 / 2], [s**2 / 2, s]])
        Q = block_diag(self.prior * (1.0 - np.outer(keep, keep)),
                       *[q * np.kron(axis, np.eye(2))] * m)  # fmt: skip
        self.mean, self.P = F @ self.mean, F @ self.P @ F.T + Q

    def update(self, drone, linear, model, residual, slots):
        H = self.jacobian(drone, linear, slots)
        by_pose = linear.by_pose.reshape(2 * len(slots), 6)
        R = model.pixel * np.eye(len(H)) + (by_pose * model.white) @ by_pose.T
        gain = np.linalg.solve(H @ self.P @ H.T + R, H @ self.P).T
        gain[LATENCY : COUNT * self.n : COUNT] = 0.0
        self.mean = self.mean + gain @ residual.ravel()
        self.P = self.P - gain @ H @ self.P


def both(share=0.5):
    """The shared state and the dense one after drone 0 began all robots."""
    state, dense, view = SharedState(STATIONARY, share), Dense(share), sight(0)
    state.look(0, view)
    linear = linearise(view, np.zeros(COUNT), PLACES)
    state.begin(np.arange(3), linear.pixels, view, MODELS[0], 0.75)
    dense.begin(0, linear, MODELS[0], PLACES)
    return state, dense


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_many_images_of_three_drones_give_the_covariance_of_one_dense_filter(share):
    state, dense = both(share)
    for step, drone in enumerate([1, 0, 2, 1, 1, 0, 2, 2, 0]):
        state.predict(0.3, [m.decay(0.3) for m in MODELS], STATIONARY, MOTION)
        dense.predict(0.3)
        state.linearise_at(drone, PLACES)
        view = sight(drone, 0.5 * step)
        slots = np.arange(3)  # one that is missed may turn, which `Dense` does not know
        linear = linearise(view, np.zeros(COUNT), PLACES[slots])
        state.correct(slots, linear.pixels, view, MODELS[drone])
        dense.update(drone, linear, MODELS[drone], np.zeros((len(slots), 2)), slots)
    P = state.ordered()[1]
    scale = np.sqrt(np.maximum(dense.P.diagonal(), 1e-12))
    np.testing.assert_allclose(P / np.outer(scale, scale), dense.P / np.outer(scale, scale),
                               atol=1e-6)  # fmt: skip
    assert np.linalg.eigvalsh(P).min() > -1e-12


def test_an_update_corrects_the_drones_that_did_not_see_it():
    state, dense = both()
    view = sight(1)
    state.look(1, view)
    linear = linearise(view, np.zeros(COUNT), PLACES)
    residual = np.array([[2.0, -1.0], [1.0, 1.5], [-2.0, 0.5]])
    state.correct(np.arange(3), linear.pixels + residual, view, MODELS[1])
    dense.update(1, linear, MODELS[1], residual, [0, 1, 2])
    mean, P = state.ordered()
    np.testing.assert_allclose(mean, dense.mean, atol=1e-7)
    assert abs(mean[0]) > 0.05
    assert abs(mean[2 * COUNT]) > 0.01
    np.testing.assert_allclose(P, dense.P, atol=1e-7)


def test_a_robot_that_is_corrected_alone_tells_of_nothing_else():
    """Schmidt: of the dense update only what concerns this robot is taken over."""
    state, dense = both()
    state.predict(0.3, [m.decay(0.3) for m in MODELS], STATIONARY, MOTION)
    dense.predict(0.3)
    state.linearise_at(1, PLACES)
    view, own = sight(1, 0.5), ERRORS + 4 * 1 + np.arange(4)
    linear = linearise(view, np.zeros(COUNT), PLACES)
    residual = np.array([[2.0, -1.0]])
    state.correct(np.array([1]), linear.pixels[1:2] + residual, view, MODELS[1], alone=True)
    mean, P = dense.mean.copy(), dense.P.copy()
    dense.update(1, linear_of(linear, 1), MODELS[1], residual, [1])
    mean[own], P[own], P[:, own] = dense.mean[own], dense.P[own], dense.P[:, own]
    found = state.ordered()
    assert np.abs(mean[own[:2]] - PLACES[1]).max() > 0.01
    np.testing.assert_allclose(found[0], mean, atol=1e-7)
    np.testing.assert_allclose(found[1], P, atol=1e-7)
    assert np.linalg.eigvalsh(found[1]).min() > -1e-12


def test_two_robots_that_are_one_tell_of_both_drones():
    """Equal to seeing the one robot twice: begun by each drone, then tied."""
    state, dense = both()
    view = sight(1)
    state.look(1, view)
    linear = linearise(view, np.zeros(COUNT), PLACES)
    state.begin(np.arange(3, 6), linear.pixels, view, MODELS[1], 0.75)
    state.tie(0, 3, 1e-4)
    state.drop(np.array([0]))
    dense.update(1, linear_of(linear, 0), MODELS[1], np.zeros((1, 2)), [0])
    P = state.ordered()[1]
    np.testing.assert_allclose(P[:ERRORS, :ERRORS], dense.P[:ERRORS, :ERRORS], atol=2e-6)


def linear_of(linear, row):
    """One robot's part of a linearisation."""
    parts = (linear.pixels, linear.by_place, linear.by_platform, linear.by_pose, linear.seen)
    return type(linear)(*(part[row : row + 1] for part in parts))


@pytest.mark.parametrize("moved", [False, True])
def test_a_camera_that_stays_learns_nothing_of_itself_from_a_robot_that_only_it_sees(moved):
    """Two drones share no robot; robots of one swim. Neither learns of its own errors."""
    state = SharedState(STATIONARY[::2], 0.5)
    views = [sight(0), sight(2)]
    places = PLACES.copy()
    far = PLACES + np.array([2.0, 1.0])
    for drone, (view, seen) in enumerate(zip(views, (places, far), strict=True)):
        state.look(drone, view)
        pixels = linearise(view, np.zeros(COUNT), seen).pixels
        state.begin(3 * drone + np.arange(3), pixels, view, MODELS[2 * drone], 0.75)
    rng = np.random.default_rng(1)
    for _ in range(30):
        state.predict(0.2, [np.ones(COUNT)] * 2, STATIONARY[::2], MOTION)
        if moved:
            places, far = (seen + rng.normal(0.0, 0.3, (3, 2)) for seen in (places, far))
        for drone, (view, seen) in enumerate(zip(views, (places, far), strict=True)):
            state.look(drone, view)
            pixels = linearise(view, np.zeros(COUNT), seen).pixels + rng.normal(0.0, 2.0, (3, 2))
            state.correct(3 * drone + np.arange(3), pixels, view, MODELS[2 * drone])
    for drone in (0, 1):
        spread = state.platform(drone)[1].diagonal()[:6]
        prior = STATIONARY[2 * drone].diagonal()[:6]
        np.testing.assert_allclose(spread, prior, rtol=1e-6)


def test_robots_begin_after_manoeuvres_put_all_drones_errors_in_doubt(monkeypatch):
    state, _ = both()
    for drone in (1, 2, 0):
        state.predict(0.3, [m.decay(0.3) for m in MODELS], STATIONARY, MOTION)
        view = sight(drone, 0.5)
        state.look(drone, view)
        linear = linearise(view, np.zeros(COUNT), PLACES)
        state.correct(np.arange(3), linear.pixels + drone, view, MODELS[drone])
        state.settle()
    view = sight(1, 1.0)
    state.look(1, view)
    before = state.ordered()[1]
    known, first = before.diagonal()[:ERRORS], state.prior(STATIONARY).diagonal()
    with monkeypatch.context() as m:
        m.setattr(state.joint.manoeuvre_noise, "take_underestimated", lambda: 4.0)
        state.doubt_platforms(STATIONARY)
    mean, P = state.ordered()
    heights = [HEIGHT, 2 * COUNT + HEIGHT]
    assert (P.diagonal()[heights] > 1.2 * known[heights]).all()
    assert (P.diagonal()[:ERRORS] <= 1.001 * first).all()  # no less certain than before any image
    np.testing.assert_allclose(given_errors(P), given_errors(before), atol=1e-5)
    state.begin(np.array([3]), np.array([[600.0, 400.0]]), view, MODELS[1], 0.75)
    after, Q = state.ordered()
    np.testing.assert_array_equal(after[: len(mean)], mean)  # what is known of others stays
    np.testing.assert_array_equal(Q[: len(P), : len(P)], P)
    assert np.linalg.eigvalsh(Q).min() > -1e-12


def given_errors(P):
    """Return robots' covariance if all drones' errors were known."""
    known = P[:ERRORS, :ERRORS] + 1e-12 * np.eye(ERRORS)
    return P[ERRORS:, ERRORS:] - P[ERRORS:, :ERRORS] @ np.linalg.solve(known, P[:ERRORS, ERRORS:])
