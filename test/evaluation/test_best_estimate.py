# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimate whose covariance is the bound: it is unbiased, and its errors are of that size."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.models.platform_model import COUNT as ERRORS
from aerial_gnss_ros.core.models.platform_model import PlatformModel
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.evaluation.best_estimate import MeasuredFrame, best_estimates
from aerial_gnss_ros.evaluation.bound import TrueDrone, TrueFrame, joint_bound

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
LOCAL = LocalMap(MapDatum(0.23, -1.04, 0.0))
CONFIGS = {name: estimator_config({"noise.set": name}) for name in ("consumer", "rtk")}
MODELS = {
    name: PlatformModel(one.noise, one.gimbal.reference, exact=True)
    for name, one in CONFIGS.items()
}
HEIGHT, PERIOD_S, COUNT = 15.0, 2.0, 5
START = 0.15 * HEIGHT * np.array([[0.6, 0.5], [-1.0, 0.2], [0.4, -0.8]])


def swum(rng, noise):
    """Return three robots' true places at all images of both drones, in time, as the model says."""
    config = CONFIGS[noise]
    dt, density = 0.5 * PERIOD_S, config.noise.value("robot_acceleration") ** 2
    root = np.linalg.cholesky(density * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]))
    speed = 0.5 * config.tracks.max_speed * rng.standard_normal((3, 2))
    places = [START]
    for _ in range(2 * COUNT - 1):
        more = np.einsum("ij,jnk->ink", root, rng.standard_normal((2, 3, 2)))
        places.append(places[-1] + dt * speed + more[0])
        speed = speed + more[1]
    return places


def drifting(rng, noise, share):
    """Return both drones' true errors (images, 18) at all images."""
    model = MODELS[noise]
    prior = joint_prior([model.stationary(None)] * 2, share)
    root = np.linalg.cholesky(prior + 1e-12 * np.eye(2 * ERRORS))
    keep = np.tile(model.decay(0.5 * PERIOD_S), 2)
    errors = [root @ rng.standard_normal(2 * ERRORS)]
    for _ in range(2 * COUNT - 1):
        errors.append(
            keep * errors[-1] + np.sqrt(1 - keep**2) * (root @ rng.standard_normal(2 * ERRORS))
        )
    return np.array(errors)


def pose_at(d, i):
    """Return the true pose of drone d, the two on opposite sides, at the i-th image of all."""
    bearing = math.radians(180.0 * d)
    away = np.array([[-10.0 * math.cos(bearing), -10.0 * math.sin(bearing)]])
    latitude, longitude = (float(angle[0]) for angle in LOCAL.places(away))
    rotation = matrix_from_rpy(0.0, math.atan2(HEIGHT, 10.0), bearing)
    stamp = round(0.5 * PERIOD_S * i * 1e9)
    return CameraPose(stamp, latitude, longitude, HEIGHT, HEIGHT, rotation)


def telemetry(pose, errors, white):
    """Return the measured pose that a drone's errors (9,) correct, with white noise (6,)."""
    true = MapPose.of(pose, LOCAL)
    axes = CameraView.of(CAMERA, true, np.zeros(6), 0.0).axes
    turned = rotation_matrix(axes @ errors[3:6]).T @ rotation_matrix(white[3:]) @ true.rotation
    place = true.position - errors[:3] + white[:3]
    latitude, longitude = (float(angle[0]) for angle in LOCAL.places(place[None, :2]))
    return replace(
        pose, latitude=latitude, longitude=longitude, height=float(place[2]),
        enu_from_camera=turned,
    )  # fmt: skip


def flight(rng, errors, noise="consumer", scale=1.0, places=None):
    """Return the drones and what they measure, by errors (images, 18) of both."""
    places, model = swum(rng, noise) if places is None else places, MODELS[noise]
    drones, measured = [], []
    for d in (0, 1):
        frames, seen = [], []
        for i in range(d, 2 * COUNT, 2):
            frame = TrueFrame(pose_at(d, i), places[i], np.ones(3, np.bool_))
            view = CameraView.of(CAMERA, MapPose.of(frame.pose, LOCAL), np.zeros(6), 0.0)
            pixels = linearise(view, np.zeros(ERRORS), places[i]).pixels
            pixels = pixels + scale * math.sqrt(model.pixel) * rng.standard_normal((3, 2))
            own = errors[i, ERRORS * d : ERRORS * d + ERRORS]
            white = scale * np.sqrt(model.white) * rng.standard_normal(6)
            frames.append(frame)
            seen.append(MeasuredFrame(telemetry(frame.pose, own, white), own, pixels))
        drones.append(TrueDrone(CONFIGS[noise], CAMERA, frames))
        measured.append(seen)
    return drones, measured


def last(drones, measured, share):
    """Return errors (3, 2) and covariances (3, 2, 2) at the last image."""
    found = best_estimates(drones, measured, LOCAL, share)[1]
    return found.positions[-1] - drones[1].frames[-1].positions, found.covariances[-1]


@pytest.mark.parametrize(("noise", "share"), [("consumer", 0.0), ("consumer", 0.9), ("rtk", 0.5)])
def test_its_errors_are_as_large_as_the_bound_says_and_their_covariance_is_right(noise, share):
    """With RTK it is the angles that matter, else it is the receivers."""
    rng = np.random.default_rng(7)
    draws, squares, normalised, limits, means = 150, [], [], [], []
    for _ in range(draws):
        error, covariance = last(*flight(rng, drifting(rng, noise, share), noise), share)
        squares.append(np.square(error).sum(axis=1).mean())
        limits.append(np.trace(covariance, axis1=1, axis2=2).mean())
        # All three robots have the receivers' offset in common: the mean of three is not better.
        normalised.append(0.5 * error[0] @ np.linalg.solve(covariance[0], error[0]))
        means.append(error.mean(axis=0))
    # A mean square of 150 draws of 2 degrees of freedom has a standard error of a twelfth.
    assert np.mean(squares) / np.mean(limits) == pytest.approx(1.0, abs=0.25)
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.25)
    assert np.abs(np.mean(means, axis=0)).max() < 4.0 * math.sqrt(0.5 * np.mean(limits) / draws)


def test_its_covariance_is_the_bound():
    rng = np.random.default_rng(9)
    drones, measured = flight(rng, drifting(rng, "consumer", 0.5))
    found = best_estimates(drones, measured, LOCAL, 0.5)
    for one, limit in zip(found, joint_bound(drones, LOCAL, 0.5), strict=True):
        np.testing.assert_array_equal(one.covariances, limit[:, :, :2, :2])


def still(offsets, share):
    """Return errors (3, 2) at the end where all but receivers' offsets (18,) is exact, m."""
    rng, errors = np.random.default_rng(10), np.tile(np.asarray(offsets, float), (2 * COUNT, 1))
    return last(*flight(rng, errors, "consumer", 0.0, [START] * (2 * COUNT)), share)[0]


def test_without_any_error_it_is_the_truth():
    assert np.abs(still(np.zeros(2 * ERRORS), 0.5)).max() < 1e-5


def test_an_offset_that_both_receivers_have_is_its_error():
    offsets = np.zeros(2 * ERRORS)
    offsets[[0, ERRORS]], offsets[[1, ERRORS + 1]] = 1.5, -0.7
    np.testing.assert_allclose(still(offsets, 1.0), np.tile([-1.5, 0.7], (3, 1)), atol=1e-3)


def test_what_one_receiver_alone_errs_by_is_halved():
    offsets = np.zeros(2 * ERRORS)
    offsets[0] = 1.5
    np.testing.assert_allclose(still(offsets, 0.0), np.tile([-0.75, 0.0], (3, 1)), atol=0.1)
