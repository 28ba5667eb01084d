# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a latency is that of the images or of the samples, on likelihoods that are given."""

from __future__ import annotations

import math
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from aerial_gnss_ros.calibration.checks import between_samples
from aerial_gnss_ros.calibration.evidence import State
from aerial_gnss_ros.calibration.search import Candidate
from aerial_gnss_ros.calibration.unknowns import FIX_DELAY, FOCAL, LATENCY

HELD = frozenset({FIX_DELAY, FOCAL})
BEST_S = 0.75


def _candidate(latency_s: float, score: float) -> Candidate:
    unknowns = np.zeros(10)
    unknowns[LATENCY] = latency_s
    return Candidate(Mock(), State(unknowns, 2.0, np.zeros(0), np.zeros(0), 0.0), score)


def _reported(score, interval_s: float = 0.5, images_s: float = 0.5) -> str | None:
    """Return what is said of images so far apart, and samples, the likelihood being given."""
    t = 1e-9 * np.arange(0, 60_000_000_000, round(images_s * 1e9))
    samples = np.arange(-5.0, 65.0, interval_s)
    compared = Mock()

    def fit(problem, latency_s, fix_delay_s, steps, held):
        assert (problem, fix_delay_s) == (compared, 0.0)
        assert steps > 3
        assert held == HELD | {LATENCY}
        found = score(latency_s)
        return None if found is None else _candidate(latency_s, found)

    motion = SimpleNamespace(start_ns=10**18, samples_s=samples, sample_s=interval_s)
    fine = SimpleNamespace(stamps_ns=10**18 + np.round(t * 1e9).astype(np.int64))
    search = SimpleNamespace(motion=motion, fine=fine, compared=compared, fit=fit)
    return between_samples(search, _candidate(BEST_S, 0.0), HELD)


def _comb(latency_s: float) -> float:
    """Best halfway between samples 0.5 s apart, and best of all at `BEST_S`."""
    phase = math.cos(2.0 * math.pi * (latency_s - BEST_S) / 0.5)
    return 100.0 * phase - 50.0 * abs(latency_s - BEST_S)


def _peak(latency_s: float) -> float:
    return -200.0 * abs(latency_s - BEST_S)


def test_one_maximum_an_interval_tells_of_the_samples() -> None:
    assert "halfway between any two samples 0.50 s apart" in str(_reported(_comb))
    assert _reported(_peak) is None


def test_both_sides_must_tell_so() -> None:
    assert _reported(lambda at: _comb(at) if at > BEST_S else _peak(at)) is None
    assert _reported(lambda at: _comb(at) if at < BEST_S else _peak(at)) is None
    assert _reported(lambda at: _comb(at) if at < BEST_S else None) is not None
    assert _reported(lambda _at: None) is None


@pytest.mark.parametrize("images_s", [0.3, 0.25, 0.0833])
def test_images_at_all_phases_or_at_opposite_ones(images_s) -> None:
    assert _reported(_comb, images_s=images_s) is None
    assert _reported(_comb, images_s=1.0) is not None


def test_samples_that_are_close_enough() -> None:
    assert (
        _reported(lambda at: math.cos(2.0 * math.pi * (at - BEST_S) / 0.02) * 100.0, 0.02) is None
    )
