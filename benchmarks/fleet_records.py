# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a fleet's flight, and the table of some."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from fleet_flights import SHARES

WITHIN = 1.15
"""Greatest RMS error that is asked for, in bounds."""
HONEST = (0.5, 2.0)
"""Least and greatest NEES/2 that are asked for."""


@dataclass(frozen=True)
class Record:
    """One flight.

    Attributes:
        cell: number of its kind.
        seed: of it.
        share: what receivers truly have in common.
        together: mean squared error of the fleet at the end, m².
        alone: the same of each drone's own estimator.
        bound: mean of the joint bound's trace there, m².
        bound_alone: of that of the first drone.
        nees: mean normalised squared error of the fleet, by its degrees of freedom.
        joined: number of robots under one name for all drones that saw them.
        names: number of names published from 5 s before the end on.
        ms: processor time of the fleet for a sighting, ms.
        agree: share of the drones' names, from 5 s on, that stand for the fleet's of that robot.
        told: as `together` where the filter is told the true share; NaN: not flown.
        best: as `together`, of the best estimate (`fleet_best`); NaN: not computed, like all below.
        best_nees: as `nees`, of the best estimate by the bound.
        expected: as `together`, expected given what was measured.
        expected_nees: as `nees`, likewise.
    """

    cell: int
    seed: int
    share: float
    together: float
    alone: tuple[float, ...]
    bound: float
    bound_alone: float
    nees: float
    joined: int
    names: int
    ms: float
    agree: float = math.nan
    told: float = math.nan
    best: float = math.nan
    best_nees: float = math.nan
    expected: float = math.nan
    expected_nees: float = math.nan


_SQUARES = ("together", "best", "bound", "expected")
HEADS = [
    "flight", "RMS, m", "bound, m", "RMS / bound", "RMS / best", "expected / bound", "alone, m",
    "gain", "bound's gain", "NEES/2", "expected: share 0", "0.5", "1", "joined", "names, %", "ms",
]  # fmt: skip


def row(words: str, records: list[Record], robots: int) -> list[str]:
    """Return the table's row of some flights."""
    both, alone = _root([r.together for r in records]), _root([r.alone[0] for r in records])
    limit, first = _root([r.bound for r in records]), _root([r.bound_alone for r in records])
    joined = sum(r.joined == robots and r.names == robots for r in records)
    ratios = [both / limit, both / _root([r.best for r in records]), _excess(records)]
    nees = [float(np.mean([r.nees for r in records])), *(_by_share(records, s) for s in SHARES)]
    return [
        words, f"{both:.3f}", f"{limit:.3f}", *(_shown(one) for one in ratios), f"{alone:.3f}",
        f"{alone / both:.2f}", f"{first / limit:.2f}", *(_shown(one) for one in nees),
        f"{joined} of {len(records)}", f"{100.0 * np.nanmean([r.agree for r in records]):.1f}",
        f"{np.mean([r.ms for r in records]):.1f}",
    ]  # fmt: skip


def pooled(rows: list[list[Record]]) -> str:
    """Return sentences on all flights, each by its own bound.

    Args:
        rows: flights of each kind.
    """
    records = [one for of in rows for one in of]
    names = 100.0 * float(np.nanmean([r.agree for r in records]))
    words = (
        f"{len(records)} flights; over all of them, RMS / bound is "
        f"{_by_bound(records):.2f}, NEES/2 {_mean([r.nees for r in records])}, and "
        f"{names:.1f} % of the drones' names agree with the fleet's."
    )
    if not any(math.isnan(r.told) for r in records):
        sure = math.sqrt(float(np.mean([r.told / r.bound for r in records])))
        words += f" Where the filter is told the true share, RMS / bound is {sure:.2f}."
    if any(math.isnan(r.best) for r in records):
        return words
    best = math.sqrt(float(np.mean([r.best / r.bound for r in records])))
    words += (
        f" The best estimate's are {best:.2f} and {_mean([r.best_nees for r in records])}. "
        "Expected, given what was measured: "
        f"{math.sqrt(float(np.mean([r.expected / r.bound for r in records]))):.2f} and "
        f"{_mean([r.expected_nees for r in records])}."
    )
    if len(rows) == 1:
        return words
    means = [float(np.mean([r.expected_nees for r in of])) for of in rows]
    each = [_by_share(of, share) for of in rows for share in SHARES]
    squares = [[float(np.sum([getattr(r, of) for r in one])) for one in rows] for of in _SQUARES]
    together, best, bound, expected = (np.array(one) for one in squares)
    by_best, by_bound, near = (
        int((np.sqrt(one) <= WITHIN).sum())
        for one in (together / best, together / bound, expected / bound)
    )
    return (
        f"{words} Of {len(rows)} rows, {near} are expected to be within {WITHIN:g} of the "
        f"bound; {by_best} are within that of the best estimate, {by_bound} of the bound itself. "
        f"NEES/2 is expected to lie within {HONEST[0]:g} to {HONEST[1]:g} in {_honest(means)} of "
        f"{len(means)} rows, and in {_honest(each)} of {len(each)} rows of one share."
    )


def _honest(means: list[float]) -> int:
    return sum(HONEST[0] <= one <= HONEST[1] for one in means)


def _by_share(records: list[Record], share: float) -> float:
    return float(np.mean([r.expected_nees for r in records if r.share == share]))


def _by_bound(records: list[Record]) -> float:
    """Return RMS / bound of flights of several kinds, each by its own bound."""
    return _root([r.together / r.bound for r in records])


def _excess(records: list[Record]) -> float:
    """Return the RMS error that is expected given what was measured, in bounds."""
    return _root([r.expected for r in records]) / _root([r.bound for r in records])


def _root(values: list[float]) -> float:
    return math.sqrt(float(np.mean(values)))


def _shown(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}"


def _mean(values: list[float]) -> str:
    """Return the mean with its standard error in words."""
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else math.nan
    return f"{np.mean(values):.2f} (standard error {error:.2f})"
