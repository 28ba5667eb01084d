# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The Cramér-Rao bound of a latency that is calibrated from a simulated flight.

It is the bound of one who knows what no calibration does: how fast each robot swims, how the camera
truly moved where telemetry was sampled, and how large at each time the errors of interpolating
between samples are. What remains unknown are the constants, the drifts of the platform's errors (as
the noise set has them), the white noise of boxes and samples, the robots' paths, and the errors of
interpolation themselves. A bound without the latter, which is what a noise set alone states, is not
one of data whose samples are a second apart: there they exceed the samples' noise several times.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.evidence import Evidence
from aerial_gnss_ros.calibration.layout import (
    BOX,
    EXTRA,
    FAST,
    FIRST_ROBOT,
    FOCAL,
    LATENCY,
    POINTING_TIME_S,
)
from aerial_gnss_ros.calibration.motion import ERRORS, Poses, Stamps, error_axes_of
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.core.frames import quaternion_from_matrix
from aerial_gnss_ros.core.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.noise import Noise
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

Array = NDArray[np.float64]

STEP_S = 0.01
STILL_MPS = 1e-3
LASTING_PX = 0.05
RATE_HZ = 0.5 / POINTING_TIME_S
"""White samples at this rate err as much over a long time as a process of the same sigma does that
stays for the time of pointing errors."""
FINE = 20
"""Points between two samples at which the error of interpolation is looked at."""


class TrueMotion:
    """A flight's true poses in the recording's `map`, as `calibration.motion.Motion` gives them.

    Args:
        made: the flight.
    """

    def __init__(self, made: Experiment) -> None:
        self._flight, plan = made.flight, made.sensors_plan
        self.start_ns, self.calm_s = START_NS, dict.fromkeys(ERRORS, 0.0)
        self._sample_s = 1.0 / plan.gimbal_hz, 1.0 / plan.fix_hz
        origin, first = made.flight.origin, next(made.sensors.fixes())
        self.origin = enu_from_geodetic(
            first.latitude, first.longitude, 0.0, origin.latitude, origin.longitude, 0.0
        )[:2]

    def at(self, stamps_ns: Stamps, latency_s: float, _extra_s: float) -> Poses:
        """Return true poses; fixes are never later than orientations."""
        t = (stamps_ns - START_NS) * 1e-9 - latency_s
        here = self._flight.sample(t)
        early, late = self._flight.sample(t - STEP_S), self._flight.sample(t + STEP_S)
        turn = late.enu_from_camera @ early.enu_from_camera.swapaxes(1, 2)
        position = here.camera.copy()
        position[:, :2] -= self.origin
        return Poses(
            position, here.enu_from_camera, (late.camera - early.camera) / (2.0 * STEP_S),
            Rotation.from_matrix(turn).as_rotvec() / (2.0 * STEP_S), np.ones(len(t), dtype=bool),
        )  # fmt: skip

    def interpolation(self, stamps_ns: Stamps, latency_s: float, ranges_m: Array) -> Array:
        """Return one sigma (n, 3) of interpolating samples without noise, rad."""
        t = (stamps_ns - START_NS) * 1e-9 - latency_s
        turns, levels = self._sample_s
        fine = _fine(t, turns)
        rotations = self._flight.sample(fine).enu_from_camera
        at = _samples(fine, turns)
        quaternions = quaternion_from_matrix(self._flight.sample(at).enu_from_camera)
        flips = np.cumsum(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0) % 2 == 1
        quaternions[1:][flips] *= -1.0
        made = Rotation.from_quat(make_interp_spline(at, quaternions, k=3)(fine)).as_matrix()
        turned = Rotation.from_matrix(made @ rotations.swapaxes(1, 2)).as_rotvec()
        angles = np.einsum("nji,nj->ni", error_axes_of(rotations), turned)
        places = _fine(t, levels)
        at = _samples(places, levels)
        path = make_interp_spline(at, self._flight.sample(at).camera[:, :2], k=3)
        off = path(places) - self._flight.sample(places).camera[:, :2]
        moved = _around(t, places, off).mean(axis=1) / np.square(ranges_m)
        return np.asarray(np.sqrt(_around(t, fine, angles) + moved[:, None]))


def _fine(t: Array, sample_s: float) -> Array:
    first, last = np.floor(t.min() / sample_s) - 3, np.ceil(t.max() / sample_s) + 3
    return np.asarray(sample_s * np.arange(first, last + 0.5 / FINE, 1.0 / FINE))


def _samples(fine: Array, sample_s: float) -> Array:
    return np.asarray(sample_s * np.arange(round(fine[0] / sample_s), fine[-1] / sample_s + 0.5))


def _around(t: Array, fine: Array, errors: Array) -> Array:
    """Return mean squares over three samples round each time."""
    squares = uniform_filter1d(errors**2, 3 * FINE, axis=0, mode="nearest")
    return np.stack([np.interp(t, fine, one) for one in squares.T], axis=1)


def _speeds(made: Experiment, motion: TrueMotion, evidence: Evidence) -> Array:
    """Return one sigma of each robot's velocity (robots,), m/s: a third where it swims.

    A robot of the fit is the true one whose middle place is nearest.
    """
    times = np.linspace(0.0, made.flight.duration_s, 100) - made.clock.latency_s
    middle = np.median(made.swarm.positions(times)[..., :2], axis=1) - motion.origin
    away = np.linalg.norm(evidence.centres[:, None] - middle[None], axis=2)
    speeds = made.swarm.speeds[np.argmin(away, axis=1)]
    return np.maximum(speeds / np.sqrt(2.0), STILL_MPS)


def _set_pointing(
    made: Experiment, motion: TrueMotion, evidence: Evidence, noise: Noise
) -> float:
    """Set how large pointing errors are at each box, and return their strength, rad.

    White noise of samples averages out over the time for which pointing errors stay.
    """
    layout, images, plan = evidence.layout, evidence.boxes.images, made.sensors_plan
    poses = evidence.poses(np.zeros(layout.size))
    stamps = evidence.stamps_ns[images]
    offsets = evidence.places(np.zeros(layout.size)) - poses.position[images, :2]
    ranges = np.hypot(np.hypot(*offsets.T), poses.position[images, 2])
    turned = np.radians(noise.value("gimbal_white_deg")) ** 2 / max(plan.gimbal_hz, RATE_HZ)
    moved = (noise.value("gnss_white_m") / np.median(ranges)) ** 2 / max(plan.fix_hz, RATE_HZ)
    white = np.sqrt(RATE_HZ * (turned + moved))
    between = motion.interpolation(stamps, made.clock.latency_s, ranges)
    profile = np.sqrt(1.0 + np.square(between / white))
    layout.pointing = [one[:, None] * layout.fast.weights for one in profile.T]
    return float(white)


def bound(made: Experiment, recording: Recording, most_images: int) -> float:
    """Return the least sigma of the latency, s; infinite where no robot is seen often enough."""
    latency_s, noise = made.clock.latency_s, recording.config.noise
    motion = TrueMotion(made)
    problem = Problem(recording, motion, most_images)  # type: ignore[arg-type]
    linked = problem.evidence(latency_s, 0.0)
    if linked is None:
        return float("inf")
    evidence, state = linked.evidence, linked.state
    strengths = np.full(evidence.layout.strengths, LASTING_PX)
    strengths[FIRST_ROBOT:] = _speeds(made, motion, evidence)
    strengths[FAST] = _set_pointing(made, motion, evidence, recording.config.noise)
    state = replace(state, strengths=strengths, pixel=noise.value("box_center_px"))
    held = frozenset({EXTRA, FOCAL})
    state = evidence.descend(state, 3, held | {LATENCY}, adapt=False)
    state = evidence.evaluated(state, held)
    pick = np.eye(1, evidence.layout.size, LATENCY)
    return float(np.sqrt(evidence.covariance(state, pick)[0, 0]))
