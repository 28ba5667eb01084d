# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A latency shows again and again; what telemetry does wrong shows at each candidate's own time."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.latency_evidence import TUNING, LatencyEvidence, agreed

CORRECTIONS = 0.1 * np.arange(-30, 31)
NO_SIZE = np.zeros(len(CORRECTIONS))
RIGHT = 0.0
"""What an image costs that fits as expected."""


def shown(cost, until_s, evidence=None, step_s=0.4, begin_s=0.0):
    """Show images whose misfits are a function of time and candidate."""
    evidence = evidence or LatencyEvidence(CORRECTIONS)
    for t in np.arange(begin_s, until_s, step_s):
        evidence.add(t, [(cost(t, CORRECTIONS), NO_SIZE)])
    return evidence


def of_latency(late_s):
    """Return residuals that are 8 larger half a second or more from the right latency."""
    return lambda _t, late: RIGHT + 8.0 * (np.abs(late - late_s) > 0.45)


def of_telemetry(wrong):
    """Return residuals that are large where a candidate's telemetry is wrong."""
    return lambda t, late: np.where(wrong(t - late), 1000.0, RIGHT)


def best(evidence):
    return CORRECTIONS[np.argmax(evidence.gains())]


@pytest.mark.parametrize("late_s", [1.0, -1.5])
def test_a_latency_gains_with_every_image(late_s):
    gains = shown(of_latency(late_s), 10.0).gains()
    assert CORRECTIONS[np.argmax(gains)] == pytest.approx(late_s, abs=0.5)
    # 8 an image, over as much telemetry as both have
    images = (10.0 - abs(late_s)) / 0.4
    assert gains.max() == pytest.approx(8.0 * images / (2.0 * TUNING.caution), rel=0.1)
    assert gains[30] == 0.0


def test_what_is_expected_less_exactly_is_less_likely():
    """Where it fits as well: by half the log determinant that it has more."""
    evidence, size = LatencyEvidence(CORRECTIONS), 3.0 * (np.abs(CORRECTIONS - 1.0) > 0.45)
    for t in np.arange(0.0, 10.0, 0.4):
        evidence.add(t, [(np.full(len(CORRECTIONS), RIGHT), size)])
    assert best(evidence) == pytest.approx(1.0, abs=0.5)


def test_the_configured_one_loses_to_none():
    assert shown(of_latency(0.0), 10.0).gains().max() == 0.0


@pytest.mark.parametrize("until_s", [5.2, 6.0, 7.2, 20.0])
def test_telemetry_that_turns_by_itself_favours_no_latency(until_s):
    """From 5 s on; candidates of later telemetry met it before, the others will."""
    assert shown(of_telemetry(lambda at: at > 5.0), until_s).gains().max() < 1.0


def test_what_one_comparison_leaves_open_is_not_ruled_out():
    """Telemetry is wrong from 5 s on: -2 s meets it from 3 s on, the configured latency not yet."""
    evidence = shown(of_telemetry(lambda at: at > 5.0), 5.0)
    early = np.argmin(np.abs(CORRECTIONS + 2.0))
    least, most = (bound[early] for bound in evidence.bounds())
    assert least == evidence.gains()[early] < -3.0
    assert most == pytest.approx(0.0, abs=1e-9)  # over the telemetry that both have seen


def test_what_happens_in_an_image_concerns_all_candidates():
    evidence = shown(lambda t, late: np.full(len(late), 500.0 if t > 9.0 else RIGHT), 10.0)
    assert evidence.gains().max() == 0.0


def test_about_a_jump_no_image_counts():
    """One image in which only the configured latency meets the jump."""
    wrong = of_telemetry(lambda at: np.abs(at - 5.2) < 0.05)
    favoured = shown(wrong, 12.0).gains().max()
    told = LatencyEvidence(CORRECTIONS)
    told.note_jumps([5.2])
    assert favoured > 0.2
    assert shown(wrong, 12.0, told).gains().max() == 0.0


def test_images_that_contradict_one_another_tell_little():
    """They favour 1 s by 1.5 in the mean: each of them, or by 10 and by -7 in turn."""

    def agree(_t, late):
        return RIGHT + 1.5 * (np.abs(late - 1.0) > 0.45)

    def differ(t, late):
        second = round(t / 0.4) % 2
        return RIGHT + np.where(np.abs(late - 1.0) > 0.45, 10.0 * (1 - second), 7.0 * second)

    assert shown(agree, 30.0).gains().max() == pytest.approx(75 * 1.5 / 4.0, rel=0.05)
    # Variance of 8.5 squared, of which 4 * 1.5 are explained, and 1 more.
    expected = 0.5 * 75 * 1.5**2 / (8.5**2 - 6.0 + 1.0)
    assert shown(differ, 30.0).gains().max() == pytest.approx(expected, rel=0.2)
    against = shown(lambda t, late: -differ(t, late), 30.0)
    assert against._compared(None)[0].min() == pytest.approx(-expected, rel=0.2)


def test_covariances_contain_what_both_comparisons_agree_on(monkeypatch):
    evidence = LatencyEvidence(CORRECTIONS[28:33])
    both = np.array([3.0, -2.0, 0.0, -4.0, 1.0]), np.array([1.0, -5.0, 0.0, 6.0, -7.0])
    monkeypatch.setattr(evidence, "_compared", lambda _: both)
    assert agreed(*evidence.bounds()).tolist() == [1.0, -2.0, 0.0, 0.0, 0.0]


def test_a_stretch_between_gaps_stands_for_itself():
    evidence = shown(of_latency(1.0), 4.0)
    before = evidence.gains().max()
    evidence.interrupt()
    shown(of_latency(1.0), 104.0, evidence, begin_s=100.0)
    assert evidence.gains().max() == pytest.approx(2.0 * before)
    assert best(evidence) == pytest.approx(1.0, abs=0.5)


def test_an_image_without_telemetry_at_a_candidate_tells_nothing_of_it():
    whole, part = LatencyEvidence(CORRECTIONS), LatencyEvidence(CORRECTIONS)
    for t in np.arange(0.0, 10.0, 0.4):
        fits = [(of_latency(1.0)(t, CORRECTIONS), NO_SIZE)]
        whole.add(t, fits)
        part.add(t, fits, t >= CORRECTIONS)
    known = CORRECTIONS <= 0.0
    np.testing.assert_array_equal(part.gains()[known], whole.gains()[known])
    late = CORRECTIONS > 0.5
    assert np.isfinite(part.gains()).all()
    assert (part.gains()[late] <= whole.gains()[late]).all()
    assert best(part) == pytest.approx(1.0, abs=0.5)


def test_bands_whose_telemetry_comes_later_fill_in():
    """All told at once, or negative latencies seconds later: the same in the end."""
    own, late = slice(20, 61), slice(0, 20)
    fit, whole, parts = of_latency(-1.5), LatencyEvidence(CORRECTIONS), LatencyEvidence(CORRECTIONS)
    waiting = []
    for t in np.arange(0.0, 10.0, 0.4):
        squares = fit(t, CORRECTIONS)
        whole.add(t, [(squares, NO_SIZE)])
        parts.add(t, [(squares[own], NO_SIZE[own])], part=own)
        waiting.append((t, [(squares[late], NO_SIZE[late])]))
    early = parts.gains()
    np.testing.assert_array_equal(early[late], 0.0)
    np.testing.assert_array_equal(early[own], whole.gains()[own])
    parts.interrupt()
    for t, fits in waiting:
        parts.add(t, fits, part=late)
        parts.add(t + 0.1, fits, part=late)  # an image that was not compared
    np.testing.assert_array_equal(parts.gains(), whole.gains())


def test_candidates_are_compared_with_the_best_by_its_own_images():
    """The last images are known to the configured latency only."""
    evidence, fit = LatencyEvidence(CORRECTIONS), of_latency(-1.5)
    for t in np.arange(0.0, 10.0, 0.4):
        evidence.add(t, [(fit(t, CORRECTIONS), NO_SIZE)], (t < 8.0) | (CORRECTIONS > -1.0))
    right = int(np.argmax(evidence.gains()))
    over = evidence.gains(right)
    assert over[right] == 0.0
    assert over[30] == pytest.approx(-evidence.gains()[right])


def test_it_keeps_a_bounded_number_of_images():
    evidence = LatencyEvidence(CORRECTIONS)
    for k in range(4):
        shown(of_latency(1.0), 100.0 * k + 60.0, evidence, begin_s=100.0 * k)
        evidence.interrupt()
    few = shown(of_latency(1.0), 60.0)
    assert evidence.gains().max() < 2.9 * few.gains().max()
