# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence of motion: Bayes' rule over the platform's errors and what the other tracks did."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, Motion
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.stationarity import TUNING, StationarityTest, _log_others

SECOND = 1_000_000_000


class Filter:
    """What the test reads of the filter: a receiver of 1 m whose offset lasts tau seconds."""

    def __init__(self, tau_s=1e9):
        self.believed = np.zeros(2)
        self.stationary = np.eye(COUNT)
        self.decay = lambda s: np.full(COUNT, np.exp(-s / tau_s))


def law(*places, sigma_m=0.0, mps=0.0, sigma_mps=1.0):
    """Return tracks at places, the first of which seems to swim East."""
    mean = np.zeros(COUNT + 4 * len(places))
    mean[COUNT:].reshape(-1, 4)[:, :2] = places
    mean[COUNT + 2] = mps
    own = np.r_[np.full(2, 1.0 + sigma_m**2), np.full(2, sigma_mps**2)]
    covariance = np.diag(np.r_[np.ones(COUNT), np.tile(own, len(places))])
    return PositionLaw(np.arange(len(places)), mean, covariance)


def weighed(test, law, seconds, at=(0.0, 0.0), stays=True, crowded=False):
    """Return what speaks against the first track's being the mark; the others are companions."""
    stamp_ns = int(seconds * SECOND)
    names = [f"buoy_{i}" for i in range(len(law.rows))]
    tracks = [SimpleNamespace(robot_id=name, last_seen_ns=stamp_ns) for name in names]
    mark = Candidate("mark", np.array(at), np.zeros((2, 2)), (0,), crowded, stays)
    (found,) = test.update([mark], tracks, law, stamp_ns)
    return found.get(0, Motion()).nats


def after(then, now, seconds=10.0, tau_s=1e9, sigma_m=0.0, crowded=False):
    test = StationarityTest(Filter(tau_s))
    assert weighed(test, law(*then, sigma_m=sigma_m), 0.0) == 0.0
    return weighed(test, law(*now), seconds, crowded=crowded)


def odds(metres, seconds, variance, share=TUNING.adrift):
    """Return log Student minus log density of a displacement of what stays but for a share."""
    free, swum = TUNING.freedom, (TUNING.swim_mps * seconds) ** 2
    student = (1.0 + metres**2 / (free * variance)) ** (-0.5 * (free + 2.0)) / variance
    wider = variance + swum
    swims = np.exp(-0.5 * metres**2 / wider) / wider
    return np.log(student) - np.log((1.0 - share) * student + share * swims)


def test_one_track_alone_is_weighed_by_bayes_rule():
    """0.3 m of box errors, and 3 m in any direction within 10 s."""
    for way in ((1, 0), (-1, 0), (0, 1), (0.6, -0.8)):
        found = after([(5, 0)], [np.add((5, 0), np.multiply(way, 3.0))])
        assert found == pytest.approx(odds(3.0, 10.0, 0.09))
        assert found < -1.0
    assert after([(5, 0)], [(5.5, 0)]) == 0.0
    expected = odds(3.0, 10.0, 0.09 + 2.0 * (1.0 - np.exp(-0.1)))
    assert after([(5, 0)], [(8, 0)], tau_s=100.0) == pytest.approx(expected)
    crowd = odds(3.0, 10.0, 0.09, share=1.0)  # what is not the reference swims
    assert after([(5, 0)], [(8, 0)], crowded=True) == pytest.approx(crowd)
    assert crowd < odds(3.0, 10.0, 0.09) - 1.0


def velocity_odds(mps, sigma_mps):
    """Return log odds of rest to swimming where others are of the class, but for a share adrift."""
    rests, swims = (sigma_mps**2 + v**2 for v in (TUNING.rest_mps, TUNING.swim_mps))
    swimming = np.exp(-0.5 * mps**2 * (1.0 / swims - 1.0 / rests)) * rests / swims
    return -np.log((1.0 - TUNING.adrift) * swimming + TUNING.adrift)


@pytest.mark.parametrize(("mps", "tells"), [(0.0, 1.0), (0.4, -1.0)])
def test_velocity_tells_what_stays_from_others_of_its_class_until_places_do(mps, tells):
    """After 10 s, one image that puts the velocity off does not make a swimmer of what stays."""
    test, steady = StationarityTest(Filter()), law((5, 0), (0, 4), mps=mps, sigma_mps=0.1)
    found = weighed(test, steady, 0.0, crowded=True)
    assert found == pytest.approx(velocity_odds(mps, 0.1))
    assert found * tells > 1.0
    assert weighed(test, steady, 10.0, crowded=True) > 1.5
    assert weighed(StationarityTest(Filter()), steady, 0.0) == 0.0


def test_what_was_learnt_of_a_place_is_no_motion():
    expected = odds(3.0, 10.0, 0.09 + 0.25)
    assert after([(5, 0)], [(8, 0)], sigma_m=0.5) == pytest.approx(expected)


@pytest.mark.parametrize("metres", [2.0, 3.0])
def test_others_left_where_they_were_speak_for_motion_and_others_displaced_alike_do_not(metres):
    then, moved = [(5, 0), (0, 4), (2, 9)], (5 + metres, 0)
    alone = after(then[:1], [moved])
    assert after(then, [moved, (metres, 4), (2 + metres, 9)]) > alone - 0.2
    assert after(then, [moved, (0, 4), (2, 9)]) < alone - 2.5
    assert after(then, [moved, (0, 0), (2, 5)]) == pytest.approx(alone, abs=1.5)
    assert after(then, [moved, (0, 1), (2, 14)]) == pytest.approx(alone, abs=1.5)


def test_others_that_stay_as_well_say_nothing_against_one_that_stays():
    """However many there are: where nothing was displaced, no error is common to all."""
    around = [(5.0 * i, 5.0) for i in range(9)]
    alone = after([(5, 0)], [(5.1, 0)], 0.5, crowded=True)
    among = after([(5, 0), *around], [(5.1, 0), *around], 0.5, crowded=True)
    assert among == pytest.approx(alone, abs=0.01)


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


def test_one_that_stays_from_then_on_may_be_the_reference_again():
    test, far = StationarityTest(Filter()), law((9, 0), (0, 4))
    weighed(test, law((5, 0), (0, 4)), 0.0)
    assert weighed(test, law((5, 0), (0, 4)), 1.0) == 0.0
    found = [weighed(test, far, t) for t in range(5, 40, 5)]
    assert found[0] < -3.0
    assert found[-1] == 0.0


def test_the_place_of_its_box_may_move_with_the_camera():
    """What stands out of the water is expected elsewhere, and seen there."""
    test = StationarityTest(Filter())
    weighed(test, law((5, 0), (0, 4)), 0.0, at=(5.0, 0.0))
    assert weighed(test, law((9, 0), (0, 4)), 10.0, at=(9.0, 0.0)) == 0.0
    assert weighed(test, law((9, 0), (0, 4)), 10.0, at=(5.0, 0.0)) < -3.0


def test_what_moves_is_not_asked_to_stay():
    test = StationarityTest(Filter())
    weighed(test, law((5, 0)), 0.0, stays=False)
    assert weighed(test, law((15, 0)), 5.0, stays=False) == 0.0


def test_an_accepted_jump_another_position_or_calibration_is_no_motion():
    for change in ("jump", "forget", "restart"):
        test = StationarityTest(filtering := Filter())
        weighed(test, law((5, 0)), 0.0)
        if change == "jump":
            filtering.believed = np.array([6.0, 0.0])
        elif change == "forget":
            test.forget("mark")
        else:
            test.restart()
        assert weighed(test, law((11, 0)), 1.0) == 0.0


def test_what_another_drone_told_of_the_receiver_is_no_motion():
    """Its offset was unknown by 1 m, then by 0.6 m: the track moves with it, by 0.8 m one sigma."""
    test = StationarityTest(Filter())
    weighed(test, law((5, 0)), 0.0)
    told = law((8, 0))
    told.covariance[:2, :2] *= 0.36
    told.covariance[COUNT:, COUNT:] -= 0.64 * np.eye(4)
    assert weighed(test, told, 10.0) == pytest.approx(odds(3.0, 10.0, 0.09 + 0.64))


def test_a_swimmer_that_has_turned_back_is_still_one():
    """It is where it was 16 s ago, and was 4 m off 8 s ago."""
    test = StationarityTest(Filter())
    for t in range(16):
        weighed(test, law((5 + 4 * np.sin(t * np.pi / 16), 0), (0, 4)), t)
    assert weighed(test, law((5, 0), (0, 4)), 16.0) < -3.0


@pytest.mark.parametrize(("metres", "misfit"), [(3.0, 4.5 - 0.09), (0.4, 0.0)])
def test_what_is_taken_for_an_error_of_the_platform_makes_others_uncertain(metres, misfit):
    """What is beyond 0.3 m of box errors, of which others may differ by a part."""
    test = StationarityTest(Filter())
    mark = Candidate("mark", np.zeros(2), np.zeros((2, 2)), (0,), stays=True)
    for stamp_ns, east in ((0, 5.0), (10 * SECOND, 5.0 + metres)):
        tracks = [SimpleNamespace(robot_id="buoy_0", last_seen_ns=stamp_ns)]
        (found,) = test.update([mark], tracks, law((east, 0)), stamp_ns)
    assert found[0].misfit == pytest.approx(TUNING.misfit**2 * misfit)
