# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The sign tests on a flight made by physics, right and with the errors that users make."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import ENU_FROM_NWU, matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.samples import Fix
from aerial_gnss_ros.preflight.flight_state import STEP_NS, FlightState
from aerial_gnss_ros.preflight.sign_tests import sign_tests
from aerial_gnss_ros.preflight.verdict import Verdict

LATITUDE, LONGITUDE = math.radians(13.2), math.radians(-59.6)
DRAG = 0.04  # rad of lean per m/s


@cache
def flight(course_off_nose=0.0):
    """Fly an oval with changing speed and height; the body leans by drag and acceleration."""
    step = STEP_NS * 1e-9
    t = np.arange(0.0, 90.0, step)
    course = 0.3 + 0.12 * t + 0.9 * np.sin(0.25 * t)  # ENU yaw of the velocity
    speed = 3.5 + 2.0 * np.sin(0.4 * t)
    velocity = speed * np.exp(1j * course)
    place = np.cumsum(velocity) * step
    up = 30.0 + 6.0 * np.sin(0.15 * t)
    lean = DRAG * velocity + np.gradient(velocity, step) / 9.81
    states = []
    for i in range(len(t)):
        nose = course[i] + course_off_nose
        forward = lean[i] * np.exp(-1j * nose)  # along and across the nose
        body = matrix_from_rpy(0.0, 0.0, nose) @ matrix_from_rpy(-forward.imag, forward.real, 0.0)
        latitude, longitude, _ = geodetic_from_enu(
            place[i].real, place[i].imag, 0.0, LATITUDE, LONGITUDE, 0.0
        )
        fix = Fix(i * STEP_NS, float(latitude), float(longitude), up[i] - 40.0)
        camera = matrix_from_rpy(0.0, math.radians(30.0 + 2.0 * math.sin(0.3 * t[i])), nose)
        pose = CameraPose(i * STEP_NS, fix.latitude, fix.longitude, up[i], math.nan, camera)
        states.append(FlightState(i * STEP_NS, fix, body, up[i], pose))
    return states


def changed(states, body=None, height=None, camera=None):
    def one(m):
        pose = m.pose
        if camera is not None:
            pose = replace(pose, enu_from_camera=camera(m))
        return replace(
            m,
            body=m.body if body is None else body(m.body),
            height=m.height if height is None else height(m.height),
            pose=pose,
        )

    return [one(m) for m in states]


def verdicts(states):
    return {test.name: test.verdict for test in sign_tests(states)}


def test_a_right_flight_passes_everything():
    assert set(verdicts(flight()).values()) == {Verdict.PASS}


def yaw_mirrored(body):
    """Heading taken for yaw: the sense is wrong."""
    forward = body[:, 0]
    return matrix_from_rpy(0.0, 0.0, math.pi / 2 - 2 * math.atan2(forward[1], forward[0])) @ body


def nwu(body):
    return ENU_FROM_NWU.T @ body


def half_turned(body):
    return body @ np.diag([1.0, -1.0, -1.0])  # FRD given as FLU


def pitch_and_roll_reversed(body):
    yaw = math.atan2(body[1, 0], body[0, 0])
    level = matrix_from_rpy(0.0, 0.0, yaw)
    return level @ (level.T @ body).T


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"body": yaw_mirrored}, {"turn": Verdict.FAIL, "lean": Verdict.FAIL}),
        ({"body": nwu}, {"nose and course": Verdict.LOOK, "lean": Verdict.FAIL}),
        ({"body": half_turned}, {"body is level": Verdict.FAIL}),
        ({"body": pitch_and_roll_reversed}, {"lean": Verdict.FAIL}),
        ({"height": lambda h: h / 0.3048}, {"height": Verdict.FAIL}),
        ({"height": lambda h: -h}, {"height": Verdict.FAIL}),
        (
            {"camera": lambda _m: matrix_from_rpy(0.0, math.radians(-30.0), 0.0)},
            {"camera meets water": Verdict.FAIL, "camera and nose": Verdict.NOT_TESTED},
        ),
        (  # holds its heading, but for a working sensor's noise
            {"camera": lambda m: matrix_from_rpy(0.0, math.radians(30.0), 1e-4 * (m.height % 1.0))},
            {"camera meets water": Verdict.NOT_TESTED, "camera and nose": Verdict.LOOK},
        ),
        (  # an earth-referenced gimbal composed with the nose a second time
            {
                "camera": lambda m: (
                    matrix_from_rpy(0.0, 0.0, math.atan2(m.body[1, 0], m.body[0, 0]))
                    @ m.pose.enu_from_camera
                )
            },
            {"camera and nose": Verdict.FAIL},
        ),
    ],
)
def test_each_error_is_seen_by_the_test_for_it(change, expected):
    found = verdicts(changed(flight(), **change))
    assert {name: found[name] for name in expected} == expected


def test_flying_sideways_fails_nothing():
    found = verdicts(flight(course_off_nose=math.pi / 2))
    assert found["nose and course"] is Verdict.LOOK
    assert Verdict.FAIL not in found.values()
    assert found["lean"] is Verdict.PASS


def test_what_never_varied_is_not_tested():
    still = [replace(flight()[0], stamp_ns=i * STEP_NS) for i in range(500)]
    assert set(verdicts(still).values()) == {Verdict.NOT_TESTED}
    assert set(verdicts([]).values()) == {Verdict.NOT_TESTED}
    noisy = [
        replace(state, body=state.body @ matrix_from_rpy(1e-4 * (i % 3), 0.0, 0.0))
        for i, state in enumerate(still)
    ]
    found = verdicts(noisy)
    assert found.pop("body is level") is Verdict.PASS  # at rest, with a working sensor
    assert set(found.values()) == {Verdict.NOT_TESTED}


STUCK = matrix_from_rpy(0.0, math.radians(30.0), 1.0)


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"body": lambda _b: np.eye(3)}, ("body is level", "turn", "nose and course", "lean")),
        ({"body": lambda b: matrix_from_rpy(0.0, 0.0, math.atan2(b[1, 0], b[0, 0]))},
         ("body is level", "lean")),  # only the heading is measured
        ({"camera": lambda _m: STUCK}, ("camera meets water", "camera and nose")),
        ({"height": lambda _h: 30.0}, ("height",)),
    ],
    ids=["attitude", "roll and pitch", "gimbal", "height"],
)  # fmt: skip
def test_a_stuck_input_in_flight_passes_no_test(change, names):
    """The lean of an attitude that is stuck was explained wholly by motion, as nothing was left."""
    found = verdicts(changed(flight(), **change))
    assert {name: found[name] for name in names} == dict.fromkeys(names, Verdict.NOT_TESTED)


def test_an_altitude_that_is_stuck_is_named():
    stuck = [replace(m, fix=replace(m.fix, altitude=5.0)) for m in flight()]
    [height] = [test for test in sign_tests(stuck) if test.name == "height"]
    assert height.verdict is Verdict.NOT_TESTED
    assert height.seen.startswith("the fix's altitude never changed")
    assert "the other changed by 12.0 m" in height.seen


@pytest.mark.parametrize(
    ("altitude", "height", "seen"),
    [
        (math.nan, 30.0, "no altitude of the fix came"),
        (5.0, None, "no height came"),
        (math.nan, None, "no height and no altitude of the fix came"),
    ],
)
def test_what_the_test_of_height_lacks_is_named(altitude, height, seen):
    states = [replace(m, fix=replace(m.fix, altitude=altitude), height=height) for m in flight()]
    [found] = [test for test in sign_tests(states) if test.name == "height"]
    assert (found.verdict, found.seen) == (Verdict.NOT_TESTED, seen)


@pytest.mark.parametrize(
    ("below_deg", "verdict", "words"),
    [
        (45.0, Verdict.PASS, "45.0 deg below the horizon"),
        (1.5, Verdict.LOOK, "1.5 deg below the horizon"),
        (-1.5, Verdict.LOOK, "1.5 deg above the horizon"),
        (-60.0, Verdict.FAIL, "60.0 deg above the horizon"),
        (-89.0, Verdict.FAIL, "89.0 deg above the horizon"),
    ],
)
def test_up_and_down_have_their_names(below_deg, verdict, words):
    def camera(state):
        wobble = 1e-4 * (state.height % 1.0)
        return matrix_from_rpy(0.0, math.radians(below_deg) + wobble, 0.0)

    tests = sign_tests(changed(flight(), camera=camera))
    [found] = [test for test in tests if test.name == "camera meets water"]
    assert (found.verdict, words in found.seen) == (verdict, True), found.seen


def test_a_slow_turn_on_the_spot_is_seen_and_left_to_the_pilot():
    still = flight()[0]
    turned = [
        replace(
            still,
            stamp_ns=i * STEP_NS,
            body=matrix_from_rpy(0.0, 0.0, 1.0 - math.radians(0.9 * i)),  # 90 deg in 20 s
        )
        for i in range(101)
    ]
    [turn] = [test for test in sign_tests(turned) if test.name == "turn"]
    assert turn.verdict is Verdict.LOOK
    assert "rose (clockwise) by up to" in turn.seen
