# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots meet within a hull's length: how often is it mistaken which is which, and is it said?

python benchmarks/meetings.py --seeds 40 --first 100

Ten simulated robots swim about (`simulation.robots`), nearer to one another than real hulls come.
Their boxes are their places with white noise, of each box and of the platform, and the platform's
drift; no filter takes part. Each meeting within `--within` is followed from 3 s before until the
two are 1.8 m apart, and judged there. If probabilities are honest, the mistakes are as many as the
probabilities of the ways not taken, summed.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.identity.pair_hypotheses import PairHypotheses
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.robots import Swarm, SwimPlan

Array = NDArray[np.float64]

RATE_HZ, DURATION_S, ROBOTS, AREA_M = 10.0, 90.0, 10, 6.0
PLAN = SwimPlan(0.3, 0.7, roam_m=5.0, apart_m=0.8)
BOX_M, PLATFORM_M, DRIFT = 0.085, 0.05, 0.1
"""White noise of a box (2 px from 30 m) and of the platform, each axis, m; its drift, m/s^0.5."""

ACCELERATION = 0.1
"""What the estimator supposes of robots that meet, m/s^1.5: twice the default."""

NEAR_M, PARTED_M, BEFORE = 2.2, 1.8, 30
"""Where a meeting begins and ends, m; images of it before."""


@dataclass
class Meeting:
    """Boxes of two robots.

    Attributes:
        places: (n, 2, 2) of the boxes by image and robot, m.
        nearest: how near the robots came to one another, m.
    """

    places: Array
    nearest: float


def meetings(seed: int, within: float) -> list[Meeting]:
    """Return the meetings of one swarm, whole ones only."""
    rng = generator(seed, "meetings")
    start = rng.uniform(-AREA_M, AREA_M, (ROBOTS, 2))
    times = np.arange(0.0, DURATION_S, 1.0 / RATE_HZ)
    paths = Swarm(start, PLAN, seed, 0.0, DURATION_S).positions(times)[:, :, :2]
    shared = np.cumsum(rng.normal(0.0, DRIFT / np.sqrt(RATE_HZ), (len(times), 2)), axis=0)
    shared += rng.normal(0.0, PLATFORM_M, shared.shape)
    boxes = paths + shared + rng.normal(0.0, BOX_M, paths.shape)
    found = []
    for a in range(ROBOTS):
        for b in range(a):
            apart = np.hypot(*(paths[a] - paths[b]).T)
            k = 0
            while k < len(times):
                if apart[k] >= within:
                    k += 1
                    continue
                before = np.flatnonzero(apart[:k] > NEAR_M)
                after = np.flatnonzero(apart[k:] > PARTED_M) + k
                if len(before) and before[-1] >= BEFORE and len(after):
                    span = slice(before[-1] - BEFORE, after[0] + 1)
                    both = np.stack([boxes[a, span], boxes[b, span]], axis=1)
                    found.append(Meeting(both, float(apart[span].min())))
                k = int(after[0]) if len(after) else len(times)
    return found


def exchanged(meeting: Meeting) -> float:
    """Return the probability of the wrong way when the two have parted."""
    first = meeting.places[:BEFORE].reshape(BEFORE, 4)
    step_ns = round(1e9 / RATE_HZ)
    line = np.stack([np.ones(BEFORE), (np.arange(BEFORE) - BEFORE + 1) / RATE_HZ], axis=1)
    places, velocities = np.linalg.lstsq(line, first, rcond=None)[0].reshape(2, 2, 2)
    spread = np.tile(np.diag([0.1**2] * 4), (2, 1, 1))
    pair = PairHypotheses.begin(("a", "b"), places, velocities, spread, 0)
    own = np.tile(BOX_M**2 * np.eye(2), (2, 1, 1))
    for i, both in enumerate(meeting.places[BEFORE:], 1):
        pair.update(i * step_ns, both, own, PLATFORM_M**2 * np.eye(2), ACCELERATION)
    return pair.exchanged


def main() -> int:
    """Follow all meetings and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=40, help="swarms")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--within", type=float, default=0.25, help="nearest distance, m")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.seeds)
    all_of_them = [one for seed in seeds for one in meetings(seed, given.within)]
    wrong = np.array([exchanged(one) for one in all_of_them])
    less = np.minimum(wrong, 1.0 - wrong)
    print(
        f"{len(wrong)} meetings within {given.within:g} m, {int((wrong > 0.5).sum())} mistaken; "
        f"the ways not taken have {less.sum():.1f} together; the right way had less than 1 % in "
        f"{int((wrong > 0.99).sum())}."
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
