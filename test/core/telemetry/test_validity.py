# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What makes a sample useless is said in words."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.limits import LimitsConfig
from aerial_gnss_ros.core.telemetry.validity import unusable, validate
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

NAN = math.nan


def fix(east, shared, north, other=None):
    """Return a fix with a covariance; the vertical variance is no number: it is not used."""
    covariance = np.diag([east, north, NAN])
    covariance[0, 1], covariance[1, 0] = shared, shared if other is None else other
    return Fix(1, 0.1, 0.2, 3.0, covariance)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (Orientation(1, np.zeros(4)), "its quaternion has length 0 instead of 1"),
        (Orientation(1, np.array([0.5, 0.0, 0.0, 0.5])), "has length 0.707 instead of 1"),
        (Orientation(1, np.full(4, NAN)), "it has no orientation"),
        (Scalar(1, NAN), "its value is nan"),
        (Scalar(1, math.inf), "its value is inf"),
        (Fix(1, 0.1, 0.2, 3.0, valid=False), "the receiver reports no fix"),
        (Fix(1, NAN, 0.2, 3.0), "not on Earth"),
        (Fix(1, 2.0, 0.2, 3.0), "114.592, 11.4592 is not on Earth"),
        (Fix(1, 0.1, math.radians(500.0), 3.0), "500 is not on Earth"),
        (Fix(1, 0.1, -3.1416, 3.0), "not on Earth"),
        (Fix(1, 0.1, math.inf, 3.0), "not on Earth"),
        (Fix(1, 0.0, 0.0, 3.0), "0, 0 is what a receiver without a fix sends"),
        (Fix(1, 1e-6, -1e-6, 3.0), "what a receiver without a fix sends"),
        (Fix(1, 0.1, 0.2, math.inf), "its altitude is inf m"),
        (Fix(1, 0.1, 0.2, -2000.0), "its altitude is -2000 m"),
        (Fix(1, 0.1, 0.2, 1e18), "its altitude is 1e+18 m"),
        (fix(math.inf, 0.0, math.inf), "its covariance is not a number: variances inf, inf"),
        (fix(NAN, NAN, NAN), "its covariance is not a number"),
        (fix(1.0, NAN, 1.0), "its covariance is not a number"),
        (fix(-1.0, 0.0, -1.0), "it is not a covariance: variances -1, -1 m²"),
        (fix(-1.0, 0.0, 1.0), "it is not a covariance"),
        (fix(1.0, 0.0, 0.0), "it is not a covariance"),
        (fix(1.0, 1.0, 1.0), "it is not a covariance"),  # a correlation of 1
        (fix(1.0, -2.0, 1.0), "it is not a covariance"),
        (fix(1.0, 0.3, 1.0, 0.2), "it is not a covariance"),  # not symmetric
        (fix(1.0, 0.0, 1.1e6), "1048.81 m of uncertainty"),
        (Scalar(1, 1e18), "1e+18 m is more than limits.height_max_m (10000 m)"),
        (Scalar(1, -1e18), "is more than limits.height_max_m"),
    ],
)
def test_a_useless_sample_says_why_and_stays_useless(value, words):
    trouble, kept = validate(value)
    assert words in trouble
    assert validate(kept)[0]


@pytest.mark.parametrize(
    "value",
    [
        Orientation(1, np.array([0.0, 0.0, 0.0, 1.005])),
        Scalar(1, -3.0),
        Fix(1, 0.5 * math.pi, -math.pi, NAN),  # an altitude may be absent
        Fix(1, 1e-5, 0.0, 3.0),  # 64 m from 0, 0
        Fix(1, 0.1, 0.2, -400.0),  # the Dead Sea
        fix(1.44, 0.2, 0.04, 0.201),
        fix(1.0, 0.0, 9e5),
        Scalar(1, -9999.0),
    ],
)
def test_what_can_be_used_is_kept_as_it_is(value):
    trouble, kept = validate(value)
    assert trouble == ""
    assert kept is value


def test_limits_are_those_of_the_configuration():
    limits = LimitsConfig(null_island_m=0.0, fix_sigma_m=10.0, height_max_m=50.0)
    assert validate(Fix(1, 0.0, 0.0, 3.0), limits)[0] == ""
    assert "limits.fix_sigma_m" in validate(fix(101.0, 0.0, 1.0), limits)[0]
    assert validate(Scalar(1, 50.0), limits)[0] == ""
    assert "50.1 m is more than" in validate(Scalar(1, 50.1), limits)[0]


def test_what_is_marked_as_unusable_stays_so_between_samples():
    fix = Fix(0, 0.2, 0.1, 5.0)
    assert unusable(fix) == replace(fix, valid=False)
    assert math.isnan(unusable(Scalar(3, 5.0)).value)
    marked = unusable(Orientation(3, np.array([0.0, 0.0, 0.0, 1.0]), "earth"))
    assert np.isnan(marked.quaternion).all()
    assert (marked.stamp_ns, marked.reference) == (3, "earth")
