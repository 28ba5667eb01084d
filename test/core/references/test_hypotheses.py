# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which track is which reference: by position, by one another, and not where it is in doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, Motion
from aerial_gnss_ros.core.references.hypotheses import TUNING, hypotheses
from aerial_gnss_ros.core.references.position_law import PositionLaw

GNSS_M, OWN_M, TOLD_M = 1.2, 0.1, 0.05


def law(places):
    """Return tracks at places, all displaced alike by a receiver of 1.2 m."""
    n = len(places)
    mean, covariance = np.zeros(COUNT + 4 * n), np.zeros((COUNT + 4 * n,) * 2)
    mean[COUNT:].reshape(n, 4)[:, :2] = places
    for axis in (0, 1):
        alike = [axis, *range(COUNT + axis, COUNT + 4 * n, 4)]
        covariance[np.ix_(alike, alike)] = GNSS_M**2
    covariance[COUNT:, COUNT:] += OWN_M**2 * np.eye(4 * n)
    return PositionLaw(np.arange(n), mean, covariance)


def at(name, place, rows, crowded=False):
    return Candidate(name, np.array(place, float), TOLD_M**2 * np.eye(2), tuple(rows), crowded)


def probability(found, **rows):
    return sum(one.probability for one in found if one.rows == rows)


def test_probabilities_add_up_and_the_likeliest_is_first():
    found = hypotheses(law([(0, 0), (4, 0)]), [at("a", (1, 0), (0, 1), True)])
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    assert found[0].rows == {"a": 0}
    assert [one.probability for one in found] == sorted(
        (o.probability for o in found), reverse=True
    )


@pytest.mark.parametrize(("off", "least", "most"), [(1.0, 0.99, 1.0), (8.0, 0.0, 0.001)])
def test_a_reference_alone_is_believed_as_far_as_the_receiver_allows(off, least, most):
    (first, *_) = found = hypotheses(law([(0, 0)]), [at("a", (off, 0), (0,))])
    assert least <= probability(found, a=0) <= most
    assert bool(first.rows) == (off < 3.0)


def test_odds_are_those_of_bayes_rule():
    found = hypotheses(law([(0, 0)]), [at("a", (2.5, 0), (0,))])
    near = GNSS_M**2 + OWN_M**2 + TOLD_M**2
    far = near + TUNING.nearby_m**2
    ratio = far / near * np.exp(-0.5 * 2.5**2 * (1.0 / near - 1.0 / far))
    odds = ratio * (1.0 - TUNING.wrong_share) / TUNING.wrong_share
    assert probability(found, a=0) / probability(found) == pytest.approx(odds)


def odds_of_motion(motion):
    """Return by how much a motion changes the odds of a reference to none."""
    pier = at("a", (1, 0), (0,))
    stays = hypotheses(law([(0, 0)]), [pier])
    moved = hypotheses(law([(0, 0)]), [replace(pier, motions={0: motion})])
    before, after = (probability(one, a=0) / probability(one) for one in (stays, moved))
    return after / before


def test_motion_counts_against_a_track_by_its_odds():
    """Of references that are not where they are said to be, one in ten is adrift."""
    assert odds_of_motion(Motion(nats=-4.0)) == pytest.approx(np.exp(-4.0))
    assert odds_of_motion(Motion(adrift=np.log(31.0))) == pytest.approx(1.0 / (0.9 + 3.1))
    assert odds_of_motion(Motion(np.log(5.0), np.log(11.0))) == pytest.approx(5.0 / (0.9 + 1.1))
    assert odds_of_motion(Motion(adrift=-50.0)) == pytest.approx(1.0 / 0.9)


@pytest.mark.parametrize(("adrift", "rows"), [(0.0, {"a": 0}), (8.0, {})])
def test_one_that_has_come_loose_is_no_reference_however_well_it_fits(adrift, rows):
    """It swims now: by errors of the platform, unless it stayed until then as none other has."""
    motions = {0: Motion(-4.0, adrift), 1: Motion(-8.0, -8.0)}
    pier = replace(at("a", (0, 0), (0, 1), True), motions=motions)
    found = hypotheses(law([(0, 0), (4, 0)]), [pier])
    assert found[0].rows == rows
    assert found[0].probability > 0.9


def test_that_a_track_is_certainly_adrift_leaves_no_other_hypothesis():
    """However certainly: hundreds of other tracks may tell."""
    pier = replace(at("a", (0, 0), (0,)), motions={0: Motion(0.0, 2000.0)})
    assert probability(hypotheses(law([(0, 0)]), [pier])) == 1.0


def test_a_track_that_is_another_reference_is_not_this_one_adrift():
    """As an adrift `a`, track 0 counts where `b` is not that track, and the likelier one only."""
    tracks, motions = law([(0, 0), (4, 0)]), {0: Motion(0.0, np.log(31.0)), 1: Motion()}
    both = [at(name, (2, 0), (0, 1), True) for name in ("a", "b")]
    before = hypotheses(tracks, both)

    def factor(motions, **rows):
        after = hypotheses(tracks, [replace(both[0], motions=motions), both[1]])
        former, odds = (probability(x, **rows) / probability(x, a=0, b=1) for x in (before, after))
        return odds / former

    assert factor(motions) == pytest.approx(0.9 + 3.1)
    assert factor(motions, b=1) == pytest.approx(0.9 + 3.1)
    assert factor(motions, b=0) == pytest.approx(1.0)
    assert factor(motions, a=1, b=0) == pytest.approx(1.0)
    motions[1] = Motion(0.0, np.log(11.0))
    assert factor(motions) == pytest.approx(0.9 + 3.1)
    assert factor(motions, b=0) == pytest.approx(0.9 + 1.1)


def test_two_tracks_alike_are_left_open():
    found = hypotheses(law([(-1, 0), (1, 0)]), [at("a", (0, 0), (0, 1), True)])
    assert probability(found, a=0) == pytest.approx(probability(found, a=1))
    assert max(one.probability for one in found) < 0.5


def test_two_references_tell_which_is_which_where_one_could_not():
    """Two beacons 2 m apart, and a receiver 1.5 m off: each alone is as likely the other."""
    tracks, reported = law([(0, 0), (2, 0)]), [(1.0, 1.2), (3.0, 1.2)]
    alone = hypotheses(tracks, [at("a", reported[0], (0, 1), True)])
    assert max(probability(alone, a=0), probability(alone, a=1)) < 0.9
    both = hypotheses(tracks, [at("a", reported[0], (0, 1)), at("b", reported[1], (0, 1))])
    assert probability(both, a=0, b=1) > 0.99


def test_of_two_that_contradict_the_one_that_fits_the_receiver_is_believed():
    tracks = law([(0, 0), (10, 0)])
    found = hypotheses(tracks, [at("a", (0.5, 0), (0,)), at("b", (15.0, 0), (1,))])
    assert probability(found, a=0) > 0.99


def test_two_that_contradict_and_fit_alike_are_both_left_open():
    tracks = law([(0, 0), (10, 0)])
    found = hypotheses(tracks, [at("a", (1.5, 0), (0,)), at("b", (8.5, 0), (1,))])
    assert probability(found, a=0) == pytest.approx(probability(found, b=1))
    assert probability(found, a=0, b=1) < 1e-6


def test_one_wrong_of_three_is_left_out():
    tracks = law([(0, 0), (10, 0), (0, 10)])
    reported = [at("a", (1.0, 1.0), (0,)), at("b", (11.0, 1.0), (1,)), at("c", (-1.0, 10.0), (2,))]
    assert probability(hypotheses(tracks, reported), a=0, b=1) > 0.99


def test_many_references_and_tracks_are_still_weighed():
    places = [(4.0 * i, 0.0) for i in range(12)]
    rows = tuple(range(12))
    reported = [
        at(f"r{i}", place, sorted(rows, key=lambda row, i=i: abs(row - i)))
        for i, place in enumerate(places)
    ]
    found = hypotheses(law(places), reported)
    assert len(found) <= TUNING.largest_count
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    assert all(row == int(name[1:]) for name, row in found[0].rows.items())
    assert len(found[0].rows) >= 6
