# SPDX-License-Identifier: Apache-2.0
"""What makes a sample useless is said in words."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.usable import usable
from aerial_gnss_ros.core.values import Fix, Orientation, Scalar

NAN = math.nan


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (Orientation(1, np.zeros(4)), "its quaternion has length 0 instead of 1"),
        (Orientation(1, np.array([0.5, 0.0, 0.0, 0.5])), "has length 0.707 instead of 1"),
        (Orientation(1, np.full(4, NAN)), "it gives no orientation"),
        (Scalar(1, NAN), "its value is nan"),
        (Scalar(1, math.inf), "its value is inf"),
        (Fix(1, 0.1, 0.2, 3.0, valid=False), "the receiver reports no fix"),
        (Fix(1, NAN, 0.2, 3.0), "no place on Earth"),
        (Fix(1, 2.0, 0.2, 3.0), "114.592, 11.4592 is no place on Earth"),
    ],
)
def test_a_useless_sample_says_why_and_stays_useless(value, words):
    trouble, kept = usable(value)
    assert words in trouble
    assert usable(kept)[0]


@pytest.mark.parametrize(
    "value",
    [
        Orientation(1, np.array([0.0, 0.0, 0.0, 1.005])),
        Scalar(1, -3.0),
        Fix(1, 0.5 * math.pi, -math.pi, NAN),  # an altitude may be absent
    ],
)
def test_what_can_be_used_is_kept_as_it_is(value):
    assert usable(value) == ("", value)
