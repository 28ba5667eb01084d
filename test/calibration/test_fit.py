# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a calibration found: units, what counts as determined, and what is confused with what."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.calibration.excitation import Excitation
from aerial_gnss_ros.calibration.fit import STAYS_MPS, UNKNOWNS, Fit, unknown

NAMES = tuple(one.name for one in UNKNOWNS)


def fit(sigmas=None, **changes):
    """Return a fit in which each constant has half the sigma that is enough."""
    sigma = np.array([0.5 * one.enough / one.scale for one in UNKNOWNS])
    for name, factor in (sigmas or {}).items():
        sigma[NAMES.index(name)] *= factor
    flown = Excitation(1.0, 1.0, 1.0, (1.0, 2.0), 90.0, (10.0, 80.0), (1.0, 9.0))
    found = Fit(
        NAMES, np.arange(1.0, 8.0) * 1e-3, np.diag(sigma**2), 2.0, 9, 0, 9, ("aqua 1", "aqua 2"),
        flown, (0.99 * STAYS_MPS, 0.5),
    )  # fmt: skip
    return replace(found, **changes)


@pytest.mark.parametrize(
    ("name", "value"),
    [("latency", 1e-3), ("heading", math.degrees(3e-3)), ("height", 6e-3), ("focal", 0.7)],
)
def test_a_constant_is_given_in_its_unit(name, value):
    found, sigma = fit().value(name)
    assert found == pytest.approx(value)
    assert sigma == pytest.approx(0.5 * unknown(name).enough)


@pytest.mark.parametrize("name", NAMES)
def test_a_constant_is_determined_up_to_its_sigma(name):
    assert fit({name: 1.99}).determined(name)
    assert not fit({name: 2.01}).determined(name)


@pytest.mark.parametrize(
    ("changes", "left"),
    [
        ({}, set(NAMES)),
        ({"misfit": ("no box fits",)}, set()),
        ({"ambiguities": {"heading": "seen from one side"}}, set(NAMES) - {"heading"}),
        ({"ambiguities": {"latency": "two minima"}}, set()),  # all else is found at it
        ({"sigmas": {"latency": 9.0}}, set(NAMES) - {"latency", "fix_latency"}),
    ],
)
def test_what_else_keeps_constants_from_being_determined(changes, left):
    found = fit(**changes)
    assert {name for name in NAMES if found.determined(name)} == left


def test_the_constant_that_is_confused_most_is_named():
    found = fit()
    covariance = found.covariance.copy()
    for name, other, rho in (("heading", "latency", 0.3), ("heading", "gimbal_roll", -0.8)):
        i, j = NAMES.index(name), NAMES.index(other)
        covariance[i, j] = covariance[j, i] = rho * math.sqrt(covariance[i, i] * covariance[j, j])
    found = replace(found, covariance=covariance)
    assert found.correlation("heading") == ("gimbal_roll", pytest.approx(-0.8))
    assert found.correlation("latency") == ("heading", pytest.approx(0.3))


def test_robots_that_stayed_and_that_swam_are_distinguished():
    assert fit().moved() == "aqua 1 stayed, aqua 2 swam at 0.50 m/s"
