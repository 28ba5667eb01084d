# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where references are at a time, and which of their fixes are no use."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.reference_places import ReferencePlaces
from aerial_gnss_ros.core.values.samples import Fix

SECOND = 1_000_000_000
LATITUDE, LONGITUDE = 0.23, -1.04


def places(**boat):
    stated = {"boat": {"class": "boat", "topic": "fix", "sigma_m": 0.5} | boat}
    return ReferencePlaces(estimator_config({"references": stated}).references)


def fix(t, east=0.0, covariance=None, **values):
    given = {"latitude": LATITUDE, "longitude": LONGITUDE + east * 1e-7, "altitude": 0.0} | values
    return Fix(round(t * SECOND), covariance=covariance, **given)


def test_what_stays_is_where_it_is_stated_to_be():
    stated = {"pier": {"class": "beacon", "position": [13.0, -59.0], "sigma_m": 0.1}}
    (pier,) = ReferencePlaces(estimator_config({"references": stated}).references).at(7)
    assert (pier.name, pier.class_id, pier.moves) == ("pier", "beacon", False)
    assert np.degrees([pier.latitude, pier.longitude]) == pytest.approx([13.0, -59.0])
    assert pier.covariance == pytest.approx(0.01 * np.eye(2))


def test_what_moves_is_between_its_fixes_and_goes_on_for_a_while():
    boat = places()
    for t in (0.0, 1.0):
        assert boat.add("boat", fix(t, east=t)) == ""
    for t, east in ((0.25, 0.25), (1.0, 1.0), (2.0, 2.0)):
        (place,) = boat.at(round(t * SECOND))
        assert place.moves
        assert (place.longitude - LONGITUDE) * 1e7 == pytest.approx(east, abs=1e-6)
    assert boat.at(3 * SECOND) == ()  # its last fix is too old
    assert boat.at(-1) == ()


def test_what_goes_on_is_less_certain_the_older_its_fix():
    boat = places()
    for t in (0.0, 1.0):
        boat.add("boat", fix(t))
    sigmas = [math.sqrt(boat.at(round(t * SECOND))[0].covariance[0, 0]) for t in (1.0, 1.5, 2.0)]
    assert sigmas[0] == pytest.approx(0.5)
    # half of 0.3 m/s² for 1 s
    assert sigmas[2] ** 2 == pytest.approx(0.25 + 0.15**2)
    assert sigmas[0] < sigmas[1] < sigmas[2]


def test_fixes_far_apart_tell_nothing_of_the_time_between():
    boat = places()
    for t in (0.0, 10.0):
        boat.add("boat", fix(t))
    assert boat.at(5 * SECOND) == ()
    assert boat.at(round(10.5 * SECOND)) == ()  # nor how fast it is
    assert len(boat.at(10 * SECOND)) == 1


def test_the_messages_own_covariance_counts_before_the_stated_one():
    boat = places()
    boat.add("boat", fix(0.0, covariance=np.diag([0.04, 0.09, 1.0])))
    boat.add("boat", fix(9.0, covariance=np.zeros((3, 3))))
    assert boat.at(0)[0].covariance == pytest.approx(np.diag([0.04, 0.09]))
    assert boat.at(9 * SECOND)[0].covariance == pytest.approx(0.25 * np.eye(2))


@pytest.mark.parametrize(
    ("bad", "sentence"),
    [
        ({"valid": False}, "its receiver has no fix"),
        ({"latitude": math.nan}, "its latitude or longitude is not on Earth"),
        ({"latitude": 0.0, "longitude": 0.0}, "it is at 0, 0, what receivers send without a fix"),
        ({"longitude": 4.0}, "its latitude or longitude is not on Earth"),
    ],
)
def test_a_fix_that_is_no_use_is_said_why(bad, sentence):
    boat = places()
    assert boat.add("boat", fix(0.0, **bad)) == sentence
    assert boat.at(0) == ()


def test_a_fix_whose_error_nobody_states_is_no_use():
    boat = places(sigma_m=math.nan)
    assert boat.add("boat", fix(0.0)) == "it has no covariance; set references.boat.sigma_m"
    assert boat.add("boat", fix(0.0, covariance=np.eye(3))) == ""


def test_fixes_can_be_forgotten():
    boat = places()
    boat.add("boat", fix(0.0))
    assert len(boat.at(0)) == 1
    boat.clear()
    assert boat.at(0) == ()
