# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots come back from out of sight: how often is it mistaken which is which, and is it said?

python benchmarks/returns.py --pairs 4000 --first 0

Two simulated robots, side by side when they go out of sight, come back after 4 to 60 s. They swim
as the filter supposes (white acceleration), or steadily with smooth turns (`simulation.robots`).
What a filter would know of them when they went and when they are back is drawn about the truth; no
flight is flown. A pair of names is kept or not by its probability (`LIKELY` in
`core.identity.return_rules`). If probabilities are honest, as many are right in each row as
expected: their probabilities' sum.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ACCELERATION, RandomSwimmers
from tables import columns, show

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity.reidentification import Reidentification
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.identity.return_rules import TUNING as RULES
from aerial_gnss_ros.core.identity.returns import ReturnCandidates
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.robots import Swarm, SwimPlan

SEEN_S, AWAY_S, APART_M, HEIGHT_M = 5.0, (4.0, 60.0), (0.8, 6.0), 20.0
PLAN = SwimPlan(0.2, 0.7, roam_m=5.0, apart_m=0.8)
PLACE_M, BEFORE_MPS, AFTER_MPS = 0.05, 0.05, 0.15
"""What is known: places, m, velocities when they went, and when they are back for a moment, m/s."""

MOTION = MotionModel(ACCELERATION, 0.75)
HABITS = 4.0
"""Independent velocities of each seen before."""

BINS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)


def paths(kind: str, seed: int, end: float) -> RandomSwimmers | Swarm:
    """Return how two robots swim that are near one another after `SEEN_S`, up to a time, s."""
    rng = generator(seed, "returns")
    course = rng.uniform(0.0, 2.0 * np.pi)
    start = np.zeros((2, 2))
    start[1] = rng.uniform(*APART_M) * np.array([np.cos(course), np.sin(course)])
    if kind == "white":
        met = RandomSwimmers(start, True, seed, end).positions([SEEN_S])[:, 0, :2]
        return RandomSwimmers(2.0 * start - met, True, seed, end)  # side by side then
    return Swarm(start, PLAN, seed, 0.0, end)


def probability(kind: str, seed: int) -> tuple[float, bool] | None:
    """Return how likely the names are as they are given, and whether they are right.

    None: they are not one another's rivals.
    """
    rng = generator(seed, "returns seen")
    away = float(np.exp(rng.uniform(*np.log(AWAY_S))))
    swum = paths(kind, seed, SEEN_S + away + 1.0)
    order = rng.permutation(2)

    def known(t: float, sigma: float) -> tuple[np.ndarray, np.ndarray]:
        """Return places and velocities (2, 2) about the truth."""
        place, later = np.moveaxis(swum.positions([t - 0.05, t + 0.05])[:, :, :2], 1, 0)
        speed = (later - place) / 0.1
        drawn = rng.standard_normal((2, 2, 2))
        return 0.5 * (place + later) + PLACE_M * drawn[0], speed + sigma * drawn[1]

    place, velocity = known(SEEN_S, BEFORE_MPS)
    back, swims = (one[order] for one in known(SEEN_S + away, AFTER_MPS))
    now, left = round((SEEN_S + away + RULES.look_s) * 1e9), round(SEEN_S * 1e9)
    tracks = [
        Track(
            "aqua", 0, left, State.COASTING, f"aqua_{i}", (left,),
            velocity=velocity[i], velocity_spread=BEFORE_MPS**2 * np.eye(2),
            speed_history=0.5 * HABITS * float(velocity[i] @ velocity[i]),
            speed_history_count=HABITS,
        )
        for i in range(2)
    ]  # fmt: skip
    came = now - round(RULES.look_s * 1e9)
    tracks += [Track("aqua", came, now, hits=(came, now)) for _ in range(2)]
    reach, _, noise = MOTION.step(away, np.full(1, 1e-3))
    variance = 2.0 * PLACE_M**2 + float(reach[0]) ** 2 * BEFORE_MPS**2 + float(noise[0, 0])
    offsets = back[None] - (place + reach[0] * velocity)[:, None]
    candidates = ReturnCandidates(
        tracks, away=[0, 1], ready=[2, 3],
        between=(offsets, np.broadcast_to(variance * np.eye(2), (2, 2, 2, 2))),
        velocities=VelocityLikelihood(swims, np.broadcast_to(AFTER_MPS**2 * np.eye(2), (2, 2, 2))),
        stamp_ns=now, height=HEIGHT_M, newcomers=0.1,
    )  # fmt: skip
    found = Reidentification(MOTION, gate_threshold(0.997), 180.0).decide(candidates)
    if set(found.label_probabilities) != {0, 1}:
        return None
    law = found.label_probabilities[0]
    best = max(law, key=lambda row: law[row])
    return law[best], bool(order[best - 2] == 0)


def table(found: list[tuple[float, bool]]) -> str:
    """Return how often names are right, by their probability."""
    rows = []
    for low, high in pairwise(BINS):
        some = [(p, right) for p, right in found if low <= p < high or p == high == 1.0]
        rows.append(
            [f"{low:g} to {high:g}", str(len(some)), str(sum(right for _, right in some)),
             f"{sum(p for p, _ in some):.1f}"]
        )  # fmt: skip
    return columns(["probability", "pairs", "right", "expected"], rows)


def main() -> None:
    """Draw pairs and show the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=1000, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--markdown", type=Path, help="where to write the tables")
    given = parser.parse_args()
    texts = []
    for kind in ("white", "steady"):
        drawn = [probability(kind, seed) for seed in range(given.first, given.first + given.pairs)]
        found = [one for one in drawn if one is not None]
        texts.append(
            f"{kind}: {len(found)} of {given.pairs} pairs returned as two\n\n{table(found)}"
        )
    show("\n".join(texts), given.markdown)


if __name__ == "__main__":
    main()
