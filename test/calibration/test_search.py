# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which of several local maxima the search ends in, on likelihoods that are given."""

from __future__ import annotations

from unittest.mock import Mock

import numpy as np
import pytest

from aerial_gnss_ros.calibration.evidence import State
from aerial_gnss_ros.calibration.search import LAST_STEPS, STEPS, Candidate, Search
from aerial_gnss_ros.calibration.unknowns import LATENCY

COARSE, SHORT, LONG = range(3)


def _candidate(latency_s: float, score: float) -> Candidate:
    unknowns = np.zeros(10)
    unknowns[LATENCY] = latency_s
    return Candidate(Mock(), State(unknowns, 2.0, np.zeros(0), np.zeros(0), 0.0), score)


class _Given(Search):
    """A search whose fits stay at their latency and have given scores."""

    def __init__(self, scores: dict[float, tuple[float, float, float]]) -> None:
        self.scores, self.compared, self._base = scores, Mock(), frozenset()
        self.refinements: set[float] = set()

    def modes(self) -> list[Candidate]:
        found = [_candidate(latency, score[COARSE]) for latency, score in self.scores.items()]
        return sorted(found, key=lambda one: -one.score)

    def fit(self, problem, latency_s, fix_delay_s, steps, held, speed_mps=0.2):  # noqa: ARG002
        assert problem is self.compared
        if steps == LAST_STEPS:
            self.refinements.add(latency_s)
        return _candidate(latency_s, self.scores[latency_s][SHORT if steps == STEPS else LONG])


WRONG = {1.0 + 0.25 * k: (-1000.0 - k, -3600.0 - k, -3590.0 - k) for k in range(6)}


@pytest.mark.parametrize(("coarse", "found"), [(-1030.0, 0.15), (-1070.0, 1.0)])
def test_a_maximum_that_few_images_rank_last_is_still_found(coarse, found) -> None:
    search = _Given(WRONG | {0.15: (coarse, -3520.0, -3465.0)})
    fits = search.best(search.modes())
    assert fits[0].latency_s == found
    assert fits[0].score == max(one.score for one in fits)


def test_maxima_are_compared_once_both_have_converged() -> None:
    """A short fit that is 40 behind may win in the end, one that is 130 behind may not."""
    scores = {-1.0: (0.0, -3500.0, -3490.0), 0.5: (0.0, -3540.0, -3460.0), 2.0: (0.0, -3630.0, 0.0)}
    search = _Given(scores)
    fits = search.best(search.modes())
    assert [one.latency_s for one in fits] == [0.5, -1.0, 2.0]
    assert [one.score for one in fits] == [-3460.0, -3490.0, -3630.0]
    assert search.refinements == {-1.0, 0.5}
