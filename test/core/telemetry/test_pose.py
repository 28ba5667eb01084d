# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry to the camera's pose: altitude rules, lever arm, north, refusals. Numbers by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.geometry.geoid import undulation
from aerial_gnss_ros.core.geometry.magnetic import declination
from aerial_gnss_ros.core.telemetry.interpolation_error import Uncertain
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import SceneTelemetry
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation

LAT, LON = math.radians(13.194), math.radians(-59.6415)
STAMP = 1_700_000_000_000_000_000
NAN = math.nan


def _orientation(roll=0.0, pitch=0.0, yaw=0.0):
    matrix = matrix_from_rpy(*np.radians([roll, pitch, yaw]))
    return Orientation(STAMP, quaternion_from_matrix(matrix))


def _samples(*, altitude=-10.0, height=30.0, level=0.0, body=None, gimbal=None, **fix):
    return SceneTelemetry(
        STAMP,
        Fix(STAMP, **{"latitude": LAT, "longitude": LON, "altitude": altitude} | fix),
        body,
        gimbal or _orientation(pitch=90.0),
        height,
        level,
        0.05,
    )


def _pose(samples, **values):
    return PoseBuilder(estimator_config(values)).pose(samples)


SEA = undulation(LAT, LON)
ROLLED = _orientation(roll=60.0)
NONE = {"height.source": "none", "surface.altitude": -41.0}


@pytest.mark.parametrize(
    ("values", "samples", "height", "water"),
    [
        # with height: altitude only matters for what is published
        ({}, {"altitude": 22.0}, 30.0, NAN),
        ({"fix.altitude_datum": "ellipsoid"}, {"altitude": -11.0}, 30.0, -41.0),
        ({"fix.altitude_datum": "ellipsoid"}, {"altitude": NAN}, 30.0, NAN),
        ({"fix.altitude_datum": "amsl"}, {"altitude": 31.0}, 30.0, 1.0 + SEA),
        ({"fix.altitude_datum": "home"}, {"altitude": 31.0}, 30.0, NAN),
        (
            {"fix.altitude_datum": "home", "fix.home_altitude_m": -40.0},
            {"altitude": 31.0},
            30.0,
            -39.0,
        ),
        # a range finder on a body that is tilted by 60 deg
        ({"height.along": "body"}, {"height": 30.0, "body": ROLLED}, 15.0, NAN),
        ({}, {"height": 30.0, "body": ROLLED}, 30.0, NAN),
        ({}, {"height": 0.51}, 0.51, NAN),
        # tide: the water stands 1.5 m above the height's reference
        (
            {"fix.altitude_datum": "ellipsoid", "height.reference": "home"},
            {"altitude": -11.0, "height": 30.0, "level": 1.5},
            28.5,
            -39.5,
        ),
        # without height: the fix less the surface, in one datum
        (NONE | {"fix.altitude_datum": "ellipsoid"}, {"altitude": -11.0, "height": None}, 30, -41),
        (NONE | {"fix.altitude_datum": "amsl"}, {"altitude": -11.0, "height": None}, 30, -41 + SEA),
        (NONE | {"fix.altitude_datum": "home"}, {"altitude": -11.0, "height": None}, 30, NAN),
    ],
)
def test_height_and_published_altitude(values, samples, height, water):
    pose = _pose(_samples(**samples), **values)
    assert isinstance(pose, CameraPose)
    assert pose.height == pytest.approx(height)
    assert pose.altitude - pose.height == pytest.approx(water, nan_ok=True)


@pytest.mark.parametrize(
    ("values", "samples", "reason"),
    [
        ({}, {"valid": False}, Reason.BAD_FIX),
        ({}, {"height": NAN}, Reason.BAD_HEIGHT),
        ({}, {"height": -1.3}, Reason.BAD_HEIGHT),
        ({}, {"height": 1.0, "level": 1.0}, Reason.BAD_HEIGHT),
        ({}, {"height": 0.5}, Reason.BAD_HEIGHT),
        ({}, {"height": 9.5, "level": 9.0}, Reason.BAD_HEIGHT),
        ({}, {"height": 10_001.0}, Reason.BAD_HEIGHT),
        ({"limits.height_min_m": 2.0}, {"height": 2.0}, Reason.BAD_HEIGHT),
        (
            NONE | {"fix.altitude_datum": "ellipsoid"},
            {"altitude": NAN, "height": None},
            Reason.BAD_FIX,
        ),
        ({}, {"gimbal": Orientation(STAMP, np.full(4, NAN))}, Reason.BAD_GIMBAL),
        (
            {"gimbal.reference": "body"},
            {"body": Orientation(STAMP, np.full(4, NAN))},
            Reason.BAD_ATTITUDE,
        ),
    ],
)
def test_refusals(values, samples, reason):
    assert _pose(_samples(**samples), **values) is reason


@pytest.mark.parametrize(
    ("yaw", "roll", "offset", "east_north_up"),
    [
        (0.0, 0.0, (2.0, 0.0, 0.0), (2.0, 0.0, 0.0)),  # nose east
        (90.0, 0.0, (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)),  # nose north
        (90.0, 0.0, (0.0, 1.0, -0.5), (-1.0, 0.0, -0.5)),  # left of north is west
        (0.0, 90.0, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),  # rolled right side down: left is up
    ],
)
def test_lever_arm(yaw, roll, offset, east_north_up):
    body = _orientation(roll=roll, yaw=yaw)
    samples = _samples(body=body, altitude=-11.0)
    pose = _pose(samples, **{"camera.offset_m": list(offset), "fix.altitude_datum": "ellipsoid"})
    moved = enu_from_geodetic(pose.latitude, pose.longitude, pose.altitude, LAT, LON, -11.0)
    assert moved == pytest.approx(east_north_up, abs=1e-6)
    assert pose.height == pytest.approx(30.0 + east_north_up[2])
    assert pose.altitude - pose.height == pytest.approx(-41.0)


def test_magnetic_north_turns_the_camera_by_the_declination():
    turned = _pose(
        _samples(body=_orientation(yaw=90.0), gimbal=_orientation(pitch=30.0)),
        **{"gimbal.reference": "heading", "attitude.north": "magnetic"},
    )
    forward = turned.enu_from_camera[:, 0]
    east_of_north = math.atan2(forward[0], forward[1])
    assert east_of_north == pytest.approx(declination(LAT, LON, STAMP), abs=1e-9)
    assert math.degrees(east_of_north) == pytest.approx(-15.0, abs=1.0)  # Barbados, 2023


def test_a_gimbal_with_a_compass_of_its_own_is_corrected_too():
    turned = _pose(
        _samples(gimbal=_orientation(pitch=30.0, yaw=90.0)), **{"gimbal.north": "magnetic"}
    )
    forward = turned.enu_from_camera[:, 0]
    east_of_north = math.atan2(forward[0], forward[1])
    assert east_of_north == pytest.approx(declination(LAT, LON, STAMP), abs=1e-9)


@pytest.mark.parametrize(("reference", "yaw_deg"), [("earth", 0.0), ("heading", 90.0)])
def test_a_sample_that_names_its_reference_has_it(reference, yaw_deg):
    gimbal = Orientation(STAMP, _orientation(pitch=30.0).quaternion, reference)
    values = {
        "gimbal.reference": "mavlink_flags",
        "gimbal.type": "mavros_gimbal",
        "gimbal.world": "ned",
        "gimbal.body": "frd",
    }
    forward = _pose(_samples(body=_orientation(yaw=90.0), gimbal=gimbal), **values).enu_from_camera[
        :, 0
    ]
    assert math.degrees(math.atan2(forward[1], forward[0])) == pytest.approx(yaw_deg)


def test_an_altitude_of_nan_that_the_height_is_made_of_is_explained():
    posing = PoseBuilder(estimator_config(NONE | {"fix.altitude_datum": "ellipsoid"}))
    assert posing.pose(_samples(altitude=NAN, height=None)) is Reason.BAD_FIX
    assert "altitude is NaN" in posing.trouble
    posing.pose(_samples(altitude=-11.0, height=None))
    assert posing.trouble == ""


def test_a_clock_without_a_date_cannot_correct_magnetic_north():
    posing = PoseBuilder(
        estimator_config({"gimbal.reference": "heading", "attitude.north": "magnetic"})
    )
    samples = _samples(body=_orientation())
    early = SceneTelemetry(0, samples.fix, samples.attitude, samples.gimbal, 30.0, 0.0, 0.0)
    assert posing.pose(early) is Reason.BAD_ATTITUDE
    assert "attitude.north" in posing.trouble


@pytest.mark.parametrize(
    ("covariance", "kept"),
    [
        (None, False),
        (np.diag([0.04, 0.09, 1.0]), True),
        (np.zeros((3, 3)), False),
        (np.diag([NAN, 1.0, 1.0]), False),
    ],
)
def test_a_fix_covariance_that_says_nothing_is_not_used(covariance, kept):
    pose = _pose(_samples(covariance=covariance))
    assert (pose.fix_covariance is not None) == kept


@pytest.mark.parametrize(
    ("reference", "variances", "gaps_s"),
    [
        ("earth", (1.0, 1.0, 2.0, 3.0, 3.0, 4.0), (0.1, 0.1, 0.2, 0.3, 0.3, 0.3)),
        ("heading", (1.0, 1.0, 2.0, 3.0, 3.0, 10.0), (0.1, 0.1, 0.2, 0.3, 0.3, 0.4)),
        ("body", (1.0, 1.0, 2.0, 8.0, 8.0, 10.0), (0.1, 0.1, 0.2, 0.4, 0.4, 0.4)),
        ("fixed", (1.0, 1.0, 2.0, 5.0, 5.0, 6.0), (0.1, 0.1, 0.2, 0.4, 0.4, 0.4)),
    ],
)
def test_errors_of_interpolation_are_those_of_the_inputs_used(reference, variances, gaps_s):
    uncertain = {
        Input.FIX: Uncertain((1.0,), 0.1),
        Input.HEIGHT: Uncertain((2.0,), 0.2),
        Input.GIMBAL: Uncertain((3.0, 4.0), 0.3),
        Input.ATTITUDE: Uncertain((5.0, 6.0), 0.4),
    }
    samples = replace(_samples(body=_orientation()), uncertain=uncertain)
    if reference == "fixed":
        samples = replace(samples, gimbal=None)
    pose = _pose(samples, **{"gimbal.reference": reference})
    assert isinstance(pose, CameraPose)
    assert pose.interpolation.tolist() == list(variances)
    assert pose.gaps_s.tolist() == list(gaps_s)


def test_images_between_the_same_samples_count_for_one():
    pose = CameraPose(0, 0.0, 0.0, 1.0, 1.0, np.eye(3), None, 0.0, np.ones(6), np.arange(6) * 0.1)
    assert pose.interpolation_noise(0.0).tolist() == [1.0] * 6
    assert pose.interpolation_noise(0.2).tolist() == pytest.approx([1.0, 1.0, 1.0, 1.5, 2.0, 2.5])
    whole = pose.interpolation_noise(0.02) / 25.0  # 0.5 s of images at 50 Hz
    assert whole[5] == pytest.approx(1.0)
