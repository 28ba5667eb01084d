# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The Cramér-Rao bound of a latency that is calibrated from a simulated flight.

It is the bound of one who knows what no calibration does: how fast each robot swims, the camera's
true pose at the samples' times, and how large at each time the errors of poses between them are.
Unknown remain the constants, the drifts of the platform's errors (as the noise set has them),
the white noise of boxes and samples, the robots' paths, and those errors
themselves.

These errors belong to the data. With samples a second apart they exceed the samples' own noise
several times, and a bound that lacks them is below what any estimator can reach.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.measurement_model import MeasurementModel
from aerial_gnss_ros.calibration.motion import Motion, Stamps
from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.calibration.prior import POINTING_TIME_S
from aerial_gnss_ros.calibration.problem import Linked, Problem
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.unknowns import (
    FIRST_ROBOT,
    FIX_DELAY,
    FOCAL,
    LATENCY,
    POINTING,
)
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.sensors import START_NS

Array = NDArray[np.float64]

STILL_MPS = 1e-3
LASTING_PX = 0.05
TELEMETRY = (
    "gnss_offset_m", "gnss_white_m", "heading_deg", "gimbal_pitch_deg", "gimbal_roll_deg",
    "height_m", "attitude_white_deg", "gimbal_white_deg", "height_white_m",
)  # fmt: skip
RATE_HZ = 0.5 / POINTING_TIME_S
"""White samples at this rate err as much over a long time as a process of the same sigma does that
stays for the time of pointing errors."""
BOUND_STEPS = 6
FINE_S, SAMPLES = 0.02, 3
"""Poses are compared with the true ones so often; errors are averaged over so many samples."""


class ExactMotion(Motion):
    """Poses from samples without noise, smoothed as those of a calibration, and what they err by.

    Args:
        made: the flight.
        config: the estimator's parameters.
    """

    def __init__(self, made: Experiment, config: EstimatorConfig) -> None:
        exact = Recording(config)
        feed(exact, made.sensors, true=True)
        super().__init__(exact)
        self._flight = made.flight
        origin, first = made.flight.origin, next(made.sensors.fixes(true=True))
        self.origin = enu_from_geodetic(
            first.latitude, first.longitude, 0.0, origin.latitude, origin.longitude, 0.0
        )[:2]
        """Of the recording's `map` in the flight's chart, East and North, m."""
        margin = made.clock.latency_s
        self._fine = np.arange(
            min(0.0, -margin), made.flight.duration_s + max(0.0, -margin), FINE_S
        )
        poses = self.at((START_NS + self._fine * 1e9).astype(np.int64), 0.0, 0.0)
        true = made.flight.sample(self._fine)
        turned = Rotation.from_matrix(
            poses.rotation @ true.enu_from_camera.swapaxes(1, 2)
        ).as_rotvec()
        self._turned = np.einsum("nji,nj->ni", error_axes_of(true.enu_from_camera), turned)
        self._moved = poses.position[:, :2] + self.origin - true.camera[:, :2]

    def interpolation(self, stamps_ns: Stamps, latency_s: float, ranges_m: Array) -> Array:
        """Return one sigma (n, 3) of these poses, rad about the error axes."""
        t = (stamps_ns - START_NS) * 1e-9 - latency_s
        width = max(1, round(SAMPLES * self.sample_s / FINE_S))
        away = _around(t, self._fine, self._moved, width).mean(axis=1) / np.square(ranges_m)
        return np.asarray(np.sqrt(_around(t, self._fine, self._turned, width) + away[:, None]))


def _around(t: Array, fine: Array, errors: Array, width: int) -> Array:
    """Return mean squares round each time."""
    squares = uniform_filter1d(errors**2, width, axis=0, mode="nearest")
    return np.stack([np.interp(t, fine, one) for one in squares.T], axis=1)


def _speeds(made: Experiment, motion: ExactMotion, linked: Linked) -> Array:
    """Return the velocity's sigma (robots,) at which each robot's true path is likeliest, m/s."""
    model = linked.evidence.model
    places = model.places(linked.state.unknowns)
    scenes = (model.stamps_ns[model.boxes.images] - START_NS) * 1e-9 - made.clock.latency_s
    true = made.swarm.positions(scenes)[..., :2] - motion.origin
    speeds = []
    for path, centre in zip(model.layout.paths, model.centres, strict=True):
        away = np.linalg.norm(true[:, path.rows] - places[path.rows], axis=2).mean(axis=1)
        own = true[np.argmin(away), path.rows] - centre
        table = np.zeros((len(path.rows), path.count))
        np.put_along_axis(table, path.columns, path.weights, axis=1)
        found = np.linalg.solve(table.T @ table + 1e-6 * path.rough, table.T @ own)
        square = float(np.sum(found * (path.rough @ found))) / (2.0 * (path.count - 1))
        speeds.append(max(math.sqrt(max(square, 0.0)), STILL_MPS))
    return np.array(speeds)


def _set_pointing(
    made: Experiment, motion: ExactMotion, model: MeasurementModel, noise: Noise
) -> float:
    """Set how large pointing errors are at each box, and return their strength, rad.

    White noise of samples averages out over the time for which pointing errors stay.
    """
    layout, images, plan = model.layout, model.boxes.images, made.sensors_plan
    poses = model.poses(np.zeros(layout.size))
    stamps = model.stamps_ns[images]
    offsets = model.places(np.zeros(layout.size)) - poses.position[images, :2]
    ranges = np.hypot(np.hypot(*offsets.T), poses.position[images, 2])
    turned = np.radians(noise.value("gimbal_white_deg")) ** 2 / max(plan.gimbal_hz, RATE_HZ)
    moved = (noise.value("gnss_white_m") / np.median(ranges)) ** 2 / max(plan.fix_hz, RATE_HZ)
    white = np.sqrt(RATE_HZ * (turned + moved))
    between = motion.interpolation(stamps, made.clock.latency_s, ranges)
    profile = np.sqrt(1.0 + np.square(between / white))
    layout.pointing_weights = [one[:, None] * layout.pointing.weights for one in profile.T]
    return float(white)


def bound(made: Experiment, recording: Recording, most_images: int) -> float:
    """Return the least sigma of the latency, s; infinite where no robot is seen often enough.

    The smaller one of smoothing telemetry as a calibration does, which trades fast motion for fast
    drift, and of taking the samples as they are.
    """
    config = recording.config
    quiet = replace(config, noise=replace(config.noise, **dict.fromkeys(TELEMETRY, 0.0)))
    ways = ExactMotion(made, config), ExactMotion(made, quiet)
    return min(_bound(made, recording, motion, most_images) for motion in ways)


def _bound(made: Experiment, recording: Recording, motion: ExactMotion, most_images: int) -> float:
    latency_s, noise = made.clock.latency_s, recording.config.noise
    linked = Problem(recording, motion, most_images).evidence(latency_s, 0.0)
    if linked is None:
        return math.inf
    evidence = linked.evidence
    sigmas = np.full(evidence.model.layout.processes, LASTING_PX)
    sigmas[FIRST_ROBOT:] = _speeds(made, motion, linked)
    sigmas[POINTING] = _set_pointing(made, motion, evidence.model, noise)
    state = replace(linked.state, sigmas=sigmas, pixel=noise.value("box_center_px"))
    held = frozenset({FIX_DELAY, FOCAL})
    state = evidence.descend(state, BOUND_STEPS, held | {LATENCY}, adapt=False)
    state = evidence.evaluated(state, held)
    pick = np.eye(1, evidence.model.layout.size, LATENCY)
    return float(np.sqrt(evidence.covariance(state, pick)[0, 0]))
