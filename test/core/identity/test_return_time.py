# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How long robots stay away: what is learnt, and that it is a law."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid

from aerial_gnss_ros.core.identity.return_time import TUNING as RETURN_TIME
from aerial_gnss_ros.core.identity.return_time import AbsenceTimes


def _learnt(*seconds, weight=1.0):
    law = AbsenceTimes(180.0)
    for one in seconds:
        law.add(np.array([one]), np.array([weight]))
    return law


def test_nothing_learnt_favours_nobody():
    assert AbsenceTimes(180.0).odds(np.array([[1.0, 60.0], [170.0, 5.0]])) == pytest.approx(1.0)


def test_an_absence_that_tells_nothing_favours_nobody():
    law = _learnt(85.0, 87.0, np.nan)
    assert law.odds(np.array([np.nan])) == pytest.approx(1.0)
    assert law.joint_log_density(np.array([np.nan, np.nan])) == pytest.approx(-2.0 * np.log(180.0))


def test_robots_that_dived_come_back_at_the_even_rate_and_missed_ones_at_once():
    """exp(-10 / 5) * 180 / 10 = 2.44; after 60 s it is 2e-5. Those that left the view: 60 / 180."""
    gone = np.array([[10.0, np.nan], [60.0, np.nan], [1.0, 300.0]])
    share = AbsenceTimes(180.0).share(gone, np.array([10.0, 60.0, 1.0]))
    wanted = [[1.0 / 3.436, 10.0 / 180.0], [1.0, 1.0 / 3.0], [1.0 / 180.0, 1.0]]
    assert share == pytest.approx(np.array(wanted), rel=1e-3)


def test_robots_that_dive_alike_come_up_when_others_did():
    short, right = _learnt(85.0, 87.0, 86.0).odds(np.array([20.0, 86.0]))
    assert right / short > 20.0


def test_one_absence_tells_little_and_an_unsure_one_less():
    gain = [
        np.divide(*_learnt(86.0, weight=weight).odds(np.array([86.0, 20.0])))
        for weight in (0.2, 1.0)
    ]
    assert 1.5 < gain[0] < gain[1] < 50.0


def test_a_dive_ends_once_so_what_was_taken_for_its_end_before_no_longer_counts():
    """Two came up after 86 s; of one it had been thought that it was back after 41 s."""
    law = AbsenceTimes(180.0)
    for seconds, share, dive in ((41.0, 0.5, "a"), (86.0, 1.0, "a"), (86.0, 1.0, "b")):
        law.add(np.array([seconds]), np.array([share]), [dive])
    assert law.odds(np.array([41.0, 86.0])) == pytest.approx(
        _learnt(86.0, 86.0).odds(np.array([41.0, 86.0])), rel=0.2
    )
    assert _learnt(41.0, 86.0, 86.0).odds(np.array([41.0]))[0] > 3.0 * law.odds(np.array([41.0]))[0]


def test_absences_of_any_length_tell_next_to_nothing():
    """Between 20 s and 120 s, drawn evenly: odds stay within those of the even law itself."""
    rng = np.random.default_rng(2)
    odds = _learnt(*rng.uniform(20.0, 120.0, 30)).odds(np.linspace(25.0, 100.0, 40))
    assert odds.max() / odds.min() < 20.0
    assert _learnt(*rng.uniform(20.0, 120.0, 30))._log_scores[0] < -3.0  # narrow bumps failed


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(RETURN_TIME.short_s, 400.0), min_size=1, max_size=12))
def test_the_density_is_the_slope_of_what_is_left(seconds):
    law = _learnt(*seconds)
    times = np.geomspace(RETURN_TIME.short_s, 2000.0, 20_001)  # kernels are of its logarithm
    density, left = law._density(times)
    fallen = trapezoid(density, times, axis=1)
    assert fallen == pytest.approx(left[:, 0] - left[:, -1], abs=1e-4)
