# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A value that repeats itself is refused where the sensor's noise cannot repeat, and only there."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.telemetry.plausibility import Plausibility
from aerial_gnss_ros.core.telemetry.repetition import SAMPLES, Repetition, Standing
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation

METRES = 6.4e6, 6.2e6
N = SAMPLES


def _reported(angles_deg, every_s=0.1):
    """Return which of some orientations (roll, pitch, yaw) are repetitions."""
    one = Repetition()
    quaternions = [quaternion_from_matrix(matrix_from_rpy(*np.radians(a))) for a in angles_deg]
    return [
        one.update(round(k * every_s * 1e9), quaternion.tolist())
        for k, quaternion in enumerate(quaternions)
    ]


def _panning(samples, noise_deg=0.03, step_deg=0.0):
    """Return angles of a gimbal that pans through north, then stays to the last bit."""
    rng = np.random.default_rng(1)
    angles = np.array([[0.0, 50.0, 170.0 + 0.9 * k] for k in range(samples)])
    angles += noise_deg * rng.standard_normal(angles.shape)
    if step_deg:
        angles = np.round(angles / step_deg) * step_deg
    return np.vstack([angles, np.repeat(angles[-1:], 10, axis=0)])


def test_an_old_orientation_under_new_stamps_is_refused_at_once_and_a_new_one_believed():
    angles = np.vstack([_panning(N), [[0.0, 50.0, 210.0]]])
    assert _reported(angles) == [False] * N + [True] * 10 + [False]
    angles[:, 0] = 0.0  # a gimbal that keeps level
    assert _reported(angles) == [False] * N + [True] * 10 + [False]


@pytest.mark.parametrize(
    "angles",
    [
        _panning(N - 1),  # has not shown its noise for long enough
        _panning(3 * N, step_deg=0.1),  # a gimbal with a resolution of 0.1 deg holds still
        _panning(3 * N, noise_deg=0.2, step_deg=0.1),  # the same, where noise hides that mostly
        [[0.0, 50.0 + 0.1 * (k % 2), 0.1 * (k % 2)] for k in range(3 * N)] + [[0.0, 50.1, 0.1]] * 9,
        [[math.sin(k / 8), 9 * math.sin(k / 5), k + math.sin(k / 7)] for k in range(3 * N)]
        + [[2.0, 3.0, 4.0]] * 10,  # a simulator's camera that sways, and stops
        _panning(3 * N, noise_deg=0.0),  # nothing ever changed but the yaw
        [[a, 50 + a, 2 * a] for a in [1e-3 * k**2 for k in range(N)]] + [[2.0, 52.0, 4.0]] * 10,
    ],
    ids=["too short", "coarse", "coarse and noisy", "flickers", "sways", "only yaw", "smooth"],
)
def test_a_sensor_that_may_repeat_itself_is_left_alone(angles):
    assert not any(_reported(angles))


def test_a_sample_twice_is_no_repetition():
    one = Repetition()
    for k, angles in enumerate(_panning(N)[:N]):
        quaternion = quaternion_from_matrix(matrix_from_rpy(*np.radians(angles))).tolist()
        assert not one.update(k, quaternion)
        assert not one.update(k, quaternion)


def _places(speed_mps, samples=N + 1, jitter_m=0.05, every_s=0.1, brake=0):
    rng = np.random.default_rng(2)
    speeds = np.full(samples - 1, speed_mps)
    if brake:
        speeds[-brake:] *= np.linspace(1.0, 0.1, brake)
    north = np.append(0.0, np.cumsum(speeds) * every_s)
    metres = np.column_stack([north, np.zeros(samples)]) + jitter_m * rng.standard_normal(
        (samples, 2)
    )
    places = metres / METRES
    return np.vstack([places, np.repeat(places[-1:], 5, axis=0)])


def _stood(places, every_s=0.1):
    one = Standing()
    stamps = [round(k * every_s * 1e9) for k in range(len(places))]
    return [one.update(t, tuple(p), METRES) for t, p in zip(stamps, places.tolist(), strict=True)]


def test_a_receiver_does_not_stop_from_one_sample_to_the_next():
    assert _stood(_places(4.0)) == [False] * (N + 1) + [True] * 5


@pytest.mark.parametrize(
    "places",
    [
        _places(0.3),  # hovers
        _places(4.0, jitter_m=0.001, brake=6),  # brakes, then stands
        _places(4.0, jitter_m=0.0),  # a simulator's, without noise
        np.repeat(_places(4.0), 2, axis=0),  # sent on twice as often as it measures
    ],
    ids=["hover", "brakes", "no noise", "doubled"],
)
def test_a_receiver_that_may_stand_is_left_alone(places):
    assert not any(_stood(places))


def test_the_step_out_of_a_repetition_is_no_motion():
    moving = _places(4.0)[: N + 1]
    again = np.add(moving, [20.0 / METRES[0], 0.0])
    long, short = again[:10], again[20:23]
    places = np.vstack([moving, moving[-1:], long, long[-1:], short, short[-1:]])
    assert [k for k, is_old in enumerate(_stood(places)) if is_old] == [N + 1, N + 12]


def test_the_door_marks_what_only_repeats():
    door = Plausibility(estimator_config({}))
    reported = []
    for k, angles in enumerate(_panning(N)):
        quaternion = quaternion_from_matrix(matrix_from_rpy(*np.radians(angles)))
        trouble, kept = door.orientation(Input.GIMBAL, Orientation(k * 10**8, quaternion))
        reported.append((bool(trouble), bool(np.isnan(kept.quaternion).all())))
    assert reported == [(False, False)] * N + [(True, True)] * 10
    reported = []
    for k, (north, east) in enumerate(_places(4.0).tolist()):
        fix = Fix(k * 10**8, math.radians(13.0) + north, math.radians(-59.0) + east, 20.0)
        trouble, kept = door.fix(fix)
        reported.append((bool(trouble), kept.valid))
    assert reported == [(False, True)] * (N + 1) + [(True, False)] * 5
    door.clear()
    assert not door.fix(Fix(10**12, fix.latitude, fix.longitude, 20.0))[0]
