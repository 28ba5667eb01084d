# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robots surely move, so that they tell of a drone's clock (see `clocks`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.platform_model import COUNT


@dataclass(frozen=True)
class MovingRobotsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    moves_mps: float = 0.1
    """Speed from which a robot tells of clocks, m/s. Judged: a slower one tells too little."""
    moves_sigmas: float = 4.0
    """Sigmas of that speed by which it must not be none. Judged."""
    stands_mps: float = 0.03
    """Speed below which it tells nothing any more, m/s: less than noise makes of it. Judged."""


TUNING = MovingRobotsTuning()


def moving(joint: JointState, before: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which robots (n,) surely move.

    One that stays would tell of a clock by the noise of its estimated velocity.

    Args:
        joint: their state.
        before: (n,) which did; they do until they stand.
    """
    speeds = np.sqrt(np.square(joint.robots[:, 2:]).sum(axis=1))
    sigmas = np.sqrt(joint.covariance.diagonal()[COUNT:].reshape(-1, 4)[:, 2:].sum(axis=1))
    begins = (speeds > TUNING.moves_mps) & (speeds > TUNING.moves_sigmas * sigmas)
    found: NDArray[np.bool_] = begins | (before & (speeds > TUNING.stands_mps))
    return found if joint.sway is None else found & (joint.sway == 0.0)
