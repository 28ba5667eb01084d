# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When it is decided which robot a new track is: at once, later, or never.

A track that may be several robots is not published while more images soon tell: until its velocity
is known, and, as robots that dived together surface together, until the others surface. One that
the camera lost and found again has nothing to wait for: it gets a new label, and the old one once
that is clear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import UNCLEAR

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ReturnRulesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    patience_s: float = 4.0
    """Longest wait for the other candidate to surface, s; tracks that start one after the other
    wait for the last one. Judged."""
    patience_share: float = 0.05
    """The wait is longer by this share of the time for which the nearest robot was unseen.
    Judged."""
    look_s: float = 1.0
    """Time after which the velocity of an ambiguous track is known, s. Judged."""
    naming_probability: float = 0.8
    """Probability above which a new track gets a robot's label, against all other robots and new
    ones. Below, it gets a new one: a label on the wrong robot is a confident wrong position, which
    is much worse. docs/results/identity.md compares other values."""


TUNING = ReturnRulesTuning()


def unsettled(probabilities: Array, columns: Indices, age: Array) -> Mask:
    """Return which new tracks wait (m,), where all candidates have surfaced.

    Args:
        probabilities: (k, k) of robots and tracks in the likeliest order.
        columns: (k,) the tracks.
        age: (m,) since they were first seen, s.
    """
    waits = np.zeros(len(age), dtype=np.bool_)
    waits[columns] = probabilities.diagonal() < 1.0 - UNCLEAR
    waits &= age[columns].min() < TUNING.look_s
    return waits


def undecided(likely: Array, age: Array, unnamed: Mask, unseen: Array, absence_s: Array) -> Mask:
    """Return which new tracks wait (m,): more images may identify them.

    Robots that dived together surface together; one that the camera lost and found again is alone.

    Args:
        likely: (n, m) probabilities of the robots.
        age: (m,) since they were first seen, s.
        unnamed: (m,) whether they have no label yet.
        unseen: (n,) how long the robots have been out of view, s.
        absence_s: (n, m) how long they were submerged if they are the tracks, s; NaN: not at all.
    """
    rows, columns = likely.argmax(axis=0), np.arange(len(age))
    best = likely[rows, columns]
    second = np.where(np.arange(len(likely))[:, None] == rows, 0.0, likely).max(axis=0)
    waits: Mask = (best > UNCLEAR) & (best < 1.0 - UNCLEAR) & unnamed
    unclear = waits & (second > UNCLEAR) & ~np.isnan(absence_s[rows, columns])
    waits &= age < TUNING.look_s
    patience = TUNING.patience_s + TUNING.patience_share * unseen[rows]
    waits |= unclear & (age[unclear].min(initial=np.inf) < patience)
    return waits


def sure(likely: Array, rows: Indices, columns: Indices, named: Mask, settled: bool) -> Mask:
    """Return which pairs (k,) of robots and tracks are likely enough for the robot's label.

    A track that has a new label is published, and can wait until it is clear.

    Args:
        likely: (n, m) probabilities.
        rows: (k,) of the robots.
        columns: (k,) of the tracks.
        named: (m,) whether they have new labels.
        settled: whether all candidates have surfaced, so that relative positions decide.
    """
    least = np.where(named[columns], 1.0 - UNCLEAR, TUNING.naming_probability)
    sure: Mask = likely[rows, columns] > least
    if settled:
        sure |= ~named[columns] | (likely.sum(axis=0)[columns] > TUNING.naming_probability)
    return sure
