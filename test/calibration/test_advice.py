# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a fit determines, and what to fly next."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.calibration.advice import advice
from aerial_gnss_ros.calibration.excitation import Excitation, excitation
from aerial_gnss_ros.calibration.fit import Fit
from aerial_gnss_ros.calibration.motion import Poses

FLOWN = Excitation(1.0, 1.0, 1.0, (1.0, 1.0), 90.0, (30.0, 60.0), (1.0, 2.0))


def _fit(names, sigma, **more) -> Fit:
    count = len(names)
    covariance = sigma**2 * np.eye(count)
    return Fit(names, np.zeros(count), covariance, 2.0, 9, 0, 9, ("a",), FLOWN, (0.0,), **more)


def test_all_determined_needs_no_advice() -> None:
    fit = _fit(("heading",), math.radians(0.1))
    assert advice(fit) == []
    assert fit.value("heading")[1] == pytest.approx(0.1)
    assert fit.determined("heading")


def test_advice_names_each_flight_once() -> None:
    """Sigmas of 9 rad or m: nothing is determined; one orbit begins what four errors need."""
    (sentence,) = advice(_fit(("heading", "gimbal_pitch", "gimbal_roll", "height"), 9.0))
    assert sentence.startswith(
        "for heading, gimbal pitch, gimbal roll and height: orbit a still robot"
    )
    assert sentence.count("once more at") == 2  # twice the distance, half the height


def test_ambiguities_and_misfit_leave_nothing_determined() -> None:
    names = ("latency", "fix_latency", "heading")
    assert all(_fit(names, 0.001).determined(name) for name in names)
    ambiguous = _fit(names, 0.001, ambiguities={"latency": "+1.0 s fits nearly as well"})
    assert not any(ambiguous.determined(name) for name in names)
    doubtful = _fit(names, 0.001, ambiguities={"heading": "confused with a tilt"})
    assert [doubtful.determined(name) for name in names] == [True, True, False]
    assert not any(_fit(names, 0.001, misfit=("no",)).determined(name) for name in names)


def test_excitation_of_a_square() -> None:
    """10 m up, along three sides of 10 m round a robot: seen from three quarters."""
    place = np.array([[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]])
    position = np.column_stack([place, np.full(4, 10.0)])
    speed = np.tile([2.0, 0.0, 0.0], (4, 1))
    poses = Poses(position, np.tile(np.eye(3), (4, 1, 1)), speed, 0.0 * speed, np.ones(4, bool))
    found = excitation(poses, np.arange(4), np.zeros(4, dtype=np.intp), np.zeros((4, 2)))
    assert found.travelled_m == pytest.approx(30.0)
    assert found.speed_mps == pytest.approx(2.0)
    assert found.heights_m == (10.0, 10.0)
    assert found.ranges_m[0] == pytest.approx(math.hypot(5.0, 5.0))
    assert found.tilts_deg[0] == pytest.approx(math.degrees(math.atan2(10.0, math.hypot(5, 5))))
    assert found.directions_deg == 40.0  # four sectors of 10 deg
    assert "10 to 7 m" not in " ".join(found.lines())
