# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much evidence decides between hypotheses: the same everywhere."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class EvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    clear_odds: float = 20.0
    """Odds from which the likelier hypothesis is taken alone: the usual level of 5 %."""
    sure_sigmas: float = 3.0
    """Sigmas beyond which a deviation is no chance: 0.3 %."""
    forgotten: float = 1e-3
    """Probability below which a hypothesis is forgotten. It would add less than 3 % to a sigma."""


TUNING = EvidenceTuning()

CLEAR_NATS = math.log(TUNING.clear_odds)
"""The same as log odds."""
SURE_SIGMAS = TUNING.sure_sigmas
"""The sigmas of `EvidenceTuning`."""
UNCLEAR = 1.0 / TUNING.clear_odds
"""Probability above which the less likely hypothesis is kept."""
