# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests of signs and references on a monitored flight, from simple physics.

Each compares two independent inputs (where the GNSS moved, where the attitude puts the nose), so
that a wrong sign shows. An input that did not vary is not tested: a stuck value agrees with much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.preflight.flight_arrays import (
    FAST,
    HALF,
    LAG,
    STEP_S,
    FlightArrays,
    changes,
    correlation,
    courses,
    differences,
    flight_arrays,
)
from aerial_gnss_ros.preflight.flight_state import FlightState
from aerial_gnss_ros.preflight.verdict import SignTest, Verdict

_ENOUGH = round(5.0 / STEP_S)
_SAME = 1e-6
"""A working sensor's noise is larger, in rad and in m."""
_LEAST_LEAN = math.radians(0.3)
"""Of the standard deviation; a change of speed by 0.7 m/s takes more than a degree."""
_STUCK = "never changed: it may be stuck or a constant"


def sign_tests(states: Sequence[FlightState]) -> tuple[SignTest, ...]:
    """Return all tests on states in order of time, `STEP_NS` apart."""
    flight = flight_arrays(states)
    return (
        _level(flight),
        _camera_down(flight),
        _turn(flight),
        _nose_and_course(flight),
        _lean(flight),
        _camera_and_nose(flight),
        _height(flight),
    )


def _level(flight: FlightArrays) -> SignTest:
    name, rule = "body is level", "at rest and in slow flight a drone stands level, top up"
    tilt = np.degrees(np.arccos(np.clip(flight.up[:, 2], -1.0, 1.0)))
    tilt = tilt[np.isfinite(tilt)]
    if len(tilt) < HALF:
        return SignTest(name, rule, Verdict.NOT_TESTED, "no attitude came")
    median = float(np.median(tilt))
    seen = f"tilted by {median:.1f} deg (median)"
    if median < 20.0 and _never_varied(flight.up):
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            f"{seen}, and roll and pitch never changed: tilt the drone by hand and see whether "
            "they follow",
        )  # fmt: skip
    if median < 20.0:
        return SignTest(name, rule, Verdict.PASS, seen)
    if median > 135.0:
        return SignTest(
            name, rule, Verdict.FAIL,
            f"{seen}: upside down, so the attitude is probably FRD or NED, but FLU in ENU is set",
        )  # fmt: skip
    verdict = Verdict.FAIL if median > 45.0 else Verdict.LOOK
    return SignTest(name, rule, verdict, f"{seen}: more than flight explains, except in a storm")


def _camera_down(flight: FlightArrays) -> SignTest:
    name, rule = "camera meets water", "a gimbal pitched down must look below the horizon"
    below = np.degrees(flight.below[np.isfinite(flight.below)])
    if len(below) < HALF:
        return SignTest(name, rule, Verdict.NOT_TESTED, "the camera's pose is not known")
    median = float(np.median(below))
    seen = f"{abs(median):.1f} deg {'below' if median > 0.0 else 'above'} the horizon (median)"
    if median > 2.0 and _never_varied(np.radians(below)):
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            f"{seen}, and it never changed: tilt the camera and see whether it follows",
        )  # fmt: skip
    if median > 2.0:
        return SignTest(name, rule, Verdict.PASS, seen)
    if median < -10.0:
        return SignTest(
            name, rule, Verdict.FAIL,
            f"{seen}: if the camera looked down, the sign of the gimbal's pitch is wrong",
        )  # fmt: skip
    return SignTest(name, rule, Verdict.LOOK, f"{seen}: tilt the camera down and look again")


def _turn(flight: FlightArrays) -> SignTest:
    name, rule = "turn", "when the nose turns clockwise, heading must rise"
    turned = changes(flight.nose)
    known = np.isfinite(turned)
    if known.sum() < HALF:
        return SignTest(name, rule, Verdict.NOT_TESTED, "no attitude came")
    way = np.nancumsum(np.where(known, turned, 0.0)) / LAG  # the whole turn up to now
    most = float(way[np.argmax(np.abs(way))])
    total = math.degrees(float(np.ptp(way)))
    if total < 30.0:
        return SignTest(
            name, rule, Verdict.NOT_TESTED, "the nose hardly turned: turn it clockwise by 90 deg"
        )
    course = changes(courses(flight))
    both = known & np.isfinite(course)
    rose = "rose (clockwise)" if most > 0.0 else "fell (counter-clockwise)"
    seen = f"heading {rose} by up to {total:.0f} deg"
    if both.sum() >= _ENOUGH and np.sqrt(np.mean(course[both] ** 2)) > math.radians(4.0):
        agree = correlation(turned[both], course[both])
        if agree > 0.5:
            return SignTest(
                name, rule, Verdict.PASS, f"{seen}; the GNSS course turned the same way"
            )
        if agree < -0.5:
            return SignTest(
                name, rule, Verdict.FAIL,
                f"{seen}; the GNSS course turned the other way: the sense of yaw is wrong",
            )  # fmt: skip
    return SignTest(name, rule, Verdict.LOOK, f"{seen}: right if the nose turned that way")


def _nose_and_course(flight: FlightArrays) -> SignTest:
    name, rule = "nose and course", "flying forward, the GNSS course is the nose's heading"
    off = courses(flight) - flight.nose
    off = off[np.isfinite(off)]
    if _never_varied(np.column_stack([np.cos(flight.nose), np.sin(flight.nose)])):
        return SignTest(name, rule, Verdict.NOT_TESTED, f"the nose's heading {_STUCK}")
    if len(off) < _ENOUGH:
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            f"it never flew faster than {FAST} m/s for 5 s with attitude: fly forward 20 m",
        )  # fmt: skip
    mean = np.mean(np.exp(1j * off))
    angle, spread = math.degrees(float(np.angle(mean))), float(abs(mean))
    if spread < 0.8:
        return SignTest(
            name, rule, Verdict.NOT_TESTED, "it flew in many directions relative to its nose"
        )
    seen = f"the course is {abs(angle):.0f} deg {_way(angle)} of the nose"
    if abs(angle) < 25.0:
        return SignTest(name, rule, Verdict.PASS, seen)
    return SignTest(
        name, rule, Verdict.LOOK,
        f"{seen} throughout: either it flew so, or yaw is off by that (90: another world frame, "
        "such as north-west-up or a heading taken for yaw)",
    )  # fmt: skip


def _lean(flight: FlightArrays) -> SignTest:
    """Fit the lean of the body (complex, east + i north) to velocity and acceleration.

    A yaw error rotates it; a wrong sense of yaw mirrors it.
    """
    name, rule = "lean", "a multicopter leans in the direction in which it flies and accelerates"
    lean = flight.up[:, 0] + 1j * flight.up[:, 1]
    velocity = flight.velocity[:, 0] + 1j * flight.velocity[:, 1]
    gain = np.full(len(velocity), np.nan + 0j)
    if len(velocity) > 2 * HALF:
        gain[HALF:-HALF] = (velocity[2 * HALF :] - velocity[: -2 * HALF]) / 2.0
    use = np.isfinite(lean) & np.isfinite(velocity) & np.isfinite(gain)
    if use.sum() < 2 * _ENOUGH or np.std(velocity[use]) < 0.7:
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            "too little change of speed: fly forward fast and stop, twice",
        )  # fmt: skip
    if np.std(lean[use]) < _LEAST_LEAN:
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            "the airframe hardly leaned while it changed speed: roll and pitch may be stuck or not "
            "given",
        )  # fmt: skip
    straight, phase = _explained(lean[use], velocity[use], gain[use])
    mirrored, _ = _explained(lean[use], velocity[use].conj(), gain[use].conj())
    if max(straight, mirrored) < 0.3:
        return SignTest(
            name, rule, Verdict.NOT_TESTED, "lean and motion are hardly correlated (wind, no roll?)"
        )
    if mirrored > straight + 0.2:
        return SignTest(
            name, rule, Verdict.FAIL,
            "its lean is the mirror image of its motion: the sense of yaw is wrong",
        )  # fmt: skip
    angle = -math.degrees(phase)  # clockwise positive
    seen = f"it leans {abs(angle):.0f} deg {_way(angle)} of its motion"
    if abs(angle) < 35.0:
        return SignTest(name, rule, Verdict.PASS, seen)
    return SignTest(
        name, rule, Verdict.FAIL,
        f"{seen}: yaw is off by that, or roll and pitch have the wrong sign (180)",
    )  # fmt: skip


def _camera_and_nose(flight: FlightArrays) -> SignTest:
    name, rule = (
        "camera and nose",
        "a camera that follows the nose turns with it, as far and as fast",
    )
    nose, view = changes(flight.nose), changes(flight.view)
    use = np.isfinite(nose) & np.isfinite(view) & (np.abs(nose) > math.radians(5.0))
    if use.sum() < HALF:
        return SignTest(
            name, rule, Verdict.NOT_TESTED, "the nose hardly turned while the camera was known"
        )
    if _never_varied(np.column_stack([np.cos(flight.view), np.sin(flight.view)])):
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            f"the camera's heading {_STUCK} while the nose turned",
        )  # fmt: skip
    share = float(nose[use] @ view[use] / (nose[use] @ nose[use]))
    seen = f"the camera turned {share:.2f} times as far as the nose"
    if 0.6 < share < 1.4:
        return SignTest(name, rule, Verdict.PASS, seen)
    if share >= 1.4:
        return SignTest(
            name, rule, Verdict.FAIL,
            f"{seen}: its yaw is measured from north; set gimbal.reference: earth",
        )  # fmt: skip
    if share < -0.4:
        return SignTest(name, rule, Verdict.FAIL, f"{seen}: its yaw has the wrong sign")
    return SignTest(
        name, rule, Verdict.LOOK,
        f"{seen}: right for a camera that holds its heading; if it follows the nose, its yaw is "
        "measured from the nose: set gimbal.reference: heading",
    )  # fmt: skip


def _height(flight: FlightArrays) -> SignTest:
    name, rule = "height", "when the drone climbs, height rises as much as the fix's altitude"
    known = {"no height": flight.height, "no altitude of the fix": flight.altitude}
    absent = [words for words, values in known.items() if np.isfinite(values).sum() < _ENOUGH]
    use = np.isfinite(flight.altitude) & np.isfinite(flight.height)
    if absent or use.sum() < _ENOUGH:
        seen = f"{' and '.join(absent) or 'height and altitude of the fix never together'} came"
        return SignTest(name, rule, Verdict.NOT_TESTED, seen)
    for what, values, other in (
        ("height", flight.height[use], flight.altitude[use]),
        ("the fix's altitude", flight.altitude[use], flight.height[use]),
    ):
        if _never_varied(values):
            return SignTest(
                name, rule, Verdict.NOT_TESTED,
                f"{what} {_STUCK}, the other changed by {np.ptp(other):.1f} m",
            )  # fmt: skip
    rise, up = differences(flight.altitude), differences(flight.height)
    both = np.isfinite(rise) & np.isfinite(up)
    moved = both & (np.abs(rise) > 0.5)
    if moved.sum() < HALF or np.ptp(flight.altitude[use]) < 2.0:
        return SignTest(name, rule, Verdict.NOT_TESTED, "it hardly climbed: climb 5 m and descend")
    share = float(rise[moved] @ up[moved] / (rise[moved] @ rise[moved]))
    seen = f"height rises {share:.2f} m for each metre of the fix's altitude"
    if 0.7 < share < 1.4:
        return SignTest(name, rule, Verdict.PASS, seen)
    if share < -0.2:
        return SignTest(name, rule, Verdict.FAIL, f"{seen}: it counts downward")
    unit = " (feet taken for metres?)" if 2.6 < share < 4.0 or 0.25 < share < 0.37 else ""
    verdict = Verdict.FAIL if unit or share > 2.0 else Verdict.LOOK
    return SignTest(name, rule, verdict, seen + unit)


def _explained(
    lean: NDArray[np.complex128],
    velocity: NDArray[np.complex128],
    gain: NDArray[np.complex128],
) -> tuple[float, float]:
    """Return the share of the lean's variance that motion explains, and its phase in rad."""
    design = np.column_stack([np.ones_like(velocity), velocity, gain])
    weights, *_ = np.linalg.lstsq(design, lean, rcond=None)
    residual = lean - design @ weights
    share = 1.0 - float(np.var(residual) / max(float(np.var(lean)), 1e-12))
    return share, float(np.angle(weights[1] * np.std(velocity) + weights[2] * np.std(gain)))


def _never_varied(values: NDArray[np.float64]) -> bool:
    """Whether values (n,) or vectors (n, k) stayed the same, as a stuck or constant input does."""
    rows = values.reshape(len(values), math.prod(values.shape[1:]))
    known = rows[np.isfinite(rows).all(axis=1)]
    return len(known) > 0 and bool((np.ptp(known, axis=0) < _SAME).all())


def _way(angle_deg: float) -> str:
    return "clockwise" if angle_deg > 0.0 else "counter-clockwise"
