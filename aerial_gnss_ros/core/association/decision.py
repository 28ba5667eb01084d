# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The decisions of association on one image, which the tracker executes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]

NO_PAIRS: tuple[Indices, Indices] = np.zeros(0, np.intp), np.zeros(0, np.intp)
"""Empty rows and columns."""


@dataclass
class Association:
    """Decisions about an image's boxes; rows are those of tracks.

    Attributes:
        rows: (m,) of the tracks that get a box.
        columns: (m,) of their boxes.
        claimed: pairs of `CandidatePairs` in which robots are updated.
        matched: number of robots with a box inside their gates.
        manoeuvred: rows of robots that left their gates, whose velocities are to be inflated.
        clutter_shares: factors of `Track.clutter_probability`, by row.
        near_misses: rows of new tracks with boxes near their gates.
        outside: number of robots with a box near their gates and none inside.
        sentence: for the log, may be empty.
    """

    rows: Indices
    columns: Indices
    claimed: list[int] = field(default_factory=list)
    manoeuvred: list[int] = field(default_factory=list)
    clutter_shares: dict[int, float] = field(default_factory=dict)
    near_misses: set[int] = field(default_factory=set)
    matched: int = 0
    outside: int = 0
    sentence: str = ""
