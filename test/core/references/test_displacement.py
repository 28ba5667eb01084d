# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What displacements tell: Bayes' rule over the platform's errors and what other tracks did."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.displacement import (
    TUNING,
    Glimpse,
    Look,
    _log_others,
    looks_since,
)

sys.path.insert(0, str(Path(__file__).parent))

from one_mark import SECOND, Filter, law, mark, tracks_of


def looks(then, now, seconds=10.0, tau_s=1e9, at=((0, 0), (0, 0)), names=((), ()), **more):
    """Return what two laws tell of the tracks that may be the mark, by row."""
    two = zip((then, now), (0.0, seconds), at, names, strict=True)
    former, last = (
        Glimpse.of([mark(place)], tracks_of(one, t, called), one, round(t * SECOND))
        for one, t, place, called in two
    )
    one = mark(rows=tuple(range(len(now.rows))), **more)
    return looks_since(former, last, one, tracks_of(now, seconds, names[1]), Filter(tau_s))


def look(then, now, seconds=10.0, **more):
    """Return what the places of the first track tell."""
    return looks(law(*then), law(*now), seconds, **more)[0]


def odds(metres, seconds, variance):
    """Return the log odds of Student's density to the normal one of what swims."""
    free, wider = TUNING.freedom, variance + (TUNING.swim_mps * seconds) ** 2
    student = (1.0 + metres**2 / (free * variance)) ** (-0.5 * (free + 2.0)) / variance
    return np.log(student) - np.log(np.exp(-0.5 * metres**2 / wider) / wider)


def test_one_track_alone_is_weighed_by_bayes_rule():
    """0.3 m of box errors, and 3 m in any direction within 10 s."""
    for way in ((1, 0), (-1, 0), (0, 1), (0.6, -0.8)):
        found = look([(5, 0)], [np.add((5, 0), np.multiply(way, 3.0))])
        assert found.nats == pytest.approx(odds(3.0, 10.0, 0.09))
        assert found.nats < -1.0
        assert found.metres == pytest.approx(3.0)
    assert look([(5, 0)], [(5.5, 0)]).nats == pytest.approx(odds(0.5, 10.0, 0.09))
    expected = odds(3.0, 10.0, 0.09 + 2.0 * (1.0 - np.exp(-0.1)))
    assert look([(5, 0)], [(8, 0)], tau_s=100.0).nats == pytest.approx(expected)


@pytest.mark.parametrize(("seconds", "times"), [(0.0, 1.0), (1.0, 2.0), (5.0, 26.0), (10.0, 101.0)])
def test_the_longer_a_track_has_stayed_the_more_that_tells(seconds, times):
    """What swims has come 0.3 m each second, and box errors are 0.3 m: 1 + t²."""
    found = look([(5, 0)], [(5, 0)], seconds)
    assert found.nats == found.tells == found.rests == pytest.approx(np.log(times))


def test_what_was_learnt_of_a_place_is_no_motion():
    found = looks(law((5, 0), sigma_m=0.5), law((8, 0), sigma_m=0.3))[0]
    assert found.nats == pytest.approx(odds(3.0, 10.0, 0.09 + 0.25 - 0.09))


def test_what_another_drone_told_of_the_receiver_is_no_motion():
    """Its offset was unknown by 1 m, then by 0.6 m: the track moves with it, by 0.8 m one sigma."""
    told = law((8, 0))
    told.covariance[:2, :2] *= 0.36
    told.covariance[COUNT:, COUNT:] -= 0.64 * np.eye(4)
    assert looks(law((5, 0)), told)[0].nats == pytest.approx(odds(3.0, 10.0, 0.09 + 0.64))


def test_what_is_moored_may_swing():
    found = look([(5, 0)], [(8, 0)], sigma_m=0.5)
    assert found.nats == pytest.approx(odds(3.0, 10.0, 0.09 + 0.25))


def test_an_error_that_lasts_displaces_what_is_seen_from_another_side():
    """One sigma of the receiver displaces the track 0.4 m East, then 0.4 m West."""
    both = law((5, 0)), law((8, 0))
    for one, by_error in zip(both, (0.4, -0.4), strict=True):
        one.covariance[0, COUNT] = one.covariance[COUNT, 0] = by_error
    assert looks(*both)[0].nats == pytest.approx(odds(3.0, 10.0, 0.09 + 0.5 * 0.8**2), abs=1e-5)


@pytest.mark.parametrize("metres", [2.0, 3.0])
def test_others_left_where_they_were_speak_for_motion_and_others_displaced_alike_do_not(metres):
    then, moved = [(5, 0), (0, 4), (2, 9)], (5 + metres, 0)
    alone = look(then[:1], [moved]).nats
    assert look(then, [moved, (metres, 4), (2 + metres, 9)]).nats > alone - 0.2
    assert look(then, [moved, (0, 4), (2, 9)]).nats < alone - 2.5
    assert look(then, [moved, (0, 0), (2, 5)]).nats == pytest.approx(alone, abs=1.5)
    assert look(then, [moved, (0, 1), (2, 14)]).nats == pytest.approx(alone, abs=1.5)


def test_others_that_stay_as_well_say_nothing_against_one_that_stays():
    """However many there are: where nothing was displaced, no error is common to all."""
    around = [(5.0 * i, 5.0) for i in range(9)]
    alone = look([(5, 0)], [(5.1, 0)], 0.5)
    among = look([(5, 0), *around], [(5.1, 0), *around], 0.5)
    assert among.nats == pytest.approx(alone.nats, abs=0.01)


def test_others_displaced_alike_are_no_evidence_of_rest():
    """They explain motion: no more than what has not moved at all is known to rest."""
    found = look([(5, 0), (0, 4)], [(8, 0), (3, 4)], 2.0)
    assert found.nats > 10.0
    assert found.rests == found.tells == pytest.approx(np.log(5.0))
    assert Look(nats=-3.0, tells=2.0).rests == -3.0


def test_others_count_by_both_of_their_laws():
    """One that stays or swims, two that may have one current: as the formula says."""

    def log(apart, variance):
        return -np.log(variance) - 0.5 * apart**2 / variance

    own, extra, swum = 0.09, 0.25, 9.0
    alike, wider = own + extra, own + extra + swum
    apart = np.array([[[0.4, 0.0]], [[2.0, 0.0]]])
    one = _log_others(apart, np.array([own]), np.array([extra]), swum, np.ones((2, 1), bool))
    for found, metres in zip(one, (0.4, 2.0), strict=True):
        each = np.logaddexp(log(metres, alike), log(metres, wider)) - np.log(2.0)
        assert found == pytest.approx(np.logaddexp(each, log(metres, wider)))
    two = np.array([[[2.0, 0.0], [2.4, 0.0], [50.0, 0.0]]])
    counted = np.array([[True, True, False]])
    (found,) = _log_others(two, np.full(3, own), np.array([extra]), swum, counted)
    each = [np.logaddexp(log(m, alike), log(m, wider)) - np.log(2.0) for m in (2.0, 2.4)]
    spread = np.full((2, 2), extra + swum) + own * np.eye(2)
    along = np.array([2.0, 2.4])
    drift = -np.log(np.linalg.det(spread)) - 0.5 * along @ np.linalg.solve(spread, along)
    assert found == pytest.approx(np.logaddexp(sum(each), drift))


def test_the_place_of_its_box_may_move_with_the_camera():
    """What stands out of the water is expected elsewhere, and seen there."""
    then, now = [(5, 0), (0, 4)], [(9, 0), (0, 4)]
    assert look(then, now, at=((5, 0), (9, 0))).nats == pytest.approx(np.log(101.0), abs=0.1)
    assert look(then, now, at=((5, 0), (5, 0))).nats < -3.0


def test_only_tracks_that_both_images_show_tell():
    both = law((5, 0), (0, 4)), law((0, 4), (5, 0))
    assert looks(*both, names=((), ("buoy_1", "buoy_0")))[1].metres == 0.0
    found = looks(*both, names=((), ("buoy_1", "buoy_2")))
    assert {row: one.metres for row, one in found.items()} == {0: 0.0}
    tracks = tracks_of(both[0], 1.0)
    tracks[1].last_seen_ns = 0
    assert Glimpse.of([mark()], tracks, both[0], SECOND).rows == {"buoy_0": 0}


@pytest.mark.parametrize(("metres", "misfit"), [(3.0, 4.5 - 0.09), (0.4, 0.0)])
def test_what_is_taken_for_an_error_of_the_platform_makes_others_uncertain(metres, misfit):
    """What is beyond 0.3 m of box errors, of which others may differ by a part."""
    found = look([(5, 0)], [(5 + metres, 0)])
    assert found.misfit == pytest.approx(TUNING.misfit**2 * misfit)
