# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that stay, drift, leave or swim, of which nobody tells the filter: alone and together.

python benchmarks/fleet_still.py --flown still.jsonl --markdown docs/results/fleet.md

Two drones with RTK on opposite sides of three robots or one, whose motions are those of
`motion_found`; receivers have half of their variance in common. `--flown` keeps the flights.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_best import Beside, beside_best
from fleet_flights import RTK, Cell, config_of, drones_of, own
from fleet_names import robots_by_name, uses
from motion_found import BEYOND, EACH_S, FROM_S, Swimmers
from tables import columns, show

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

CELLS = {
    words: Cell(kind, "opposite", 30.0, RTK, robots=robots, duration_s=60.0)
    for words, kind, robots in (
        ("hover", "hover", 3),
        ("orbit", "orbit", 3),
        ("one robot", "hover", 1),
    )
}
MOTIONS = (
    "all stay", "on watch circles of 3 to 10 cm", "all drift", "a current begins", "one leaves",
    "all swim",
)  # fmt: skip
SPEED_MPS = 0.3
STAY = dict.fromkeys(
    "ab",
    estimator_config(
        {"noise.set": "rtk", "noise.robot_acceleration": 0.0, "tracks.max_speed": 0.01}
    ),
)
"""Of the best estimate, which is told that all stay."""


def errors(
    one: Experiment, local: LocalMap, published: Sequence[tuple[RobotEstimate, ...]]
) -> list[float]:
    """Return mean squared error, m², mean NEES/2, and the share of errors that are far beyond."""
    squares, normalised, next_s = list[float](), list[float](), FROM_S
    for estimates in published:
        t = (estimates[0].stamp_ns - START_NS) * 1e-9 if estimates else -1.0
        if t < next_s:
            continue
        next_s = t + EACH_S
        true = one.swarm.positions([t])[:, 0, :2]
        for estimate in estimates:
            place = local.positions([estimate.latitude], [estimate.longitude])[0]
            error = min(true - place, key=lambda apart: float(apart @ apart))
            squares.append(float(error @ error))
            normalised.append(float(error @ np.linalg.solve(estimate.covariance[:2, :2], error)))
    beyond = float((np.array(normalised) > BEYOND).mean())
    return [float(np.mean(squares)), 0.5 * float(np.mean(normalised)), beyond]


def flown(cell: Cell, motion: str, seed: int) -> list[float]:
    """Return the errors of a flight.

    Mean squared errors, m², of each drone's own estimator by default, of all together without and
    with the search for robots that stay; then NEES/2 and the share far beyond of the last. Then,
    where all stay, what is expected given what was measured (`fleet_best`): mean squared errors of
    each drone's own and of all together, m², the bounds of both, m², and NEES/2; else NaN.
    """
    swims = motion == "all swim"
    made = drones_of(replace(cell, speed=SPEED_MPS) if swims else cell, seed, 0.5)
    local, last_s = LocalMap(made["a"].flight.origin), cell.duration_s - FROM_S
    if not swims:
        places = made["a"].swarm.positions([0.0])[:, 0, :2]
        for one in made.values():
            one.swarm = Swimmers(motion, places, seed, cell.duration_s)
    swim = {name: config_of(cell, noise) for name, noise in zip(made, cell.noises, strict=True)}
    found = {
        name: replace(one, tracks=replace(one.tracks, find_moored=True))
        for name, one in swim.items()
    }
    alone, told, results = list[float](), [], dict[str, list[FrameResult]]()
    singly = list[Beside]()
    for name, one in made.items():
        results[name], seen_by = own(one, found[name])
        alone.append(errors(made["a"], local, [r.estimates for r in results[name]])[0])
        told += [(seen.pose.stamp_ns, name, seen) for seen in own(one, swim[name])[1]]
        if motion == MOTIONS[0]:
            robots = robots_by_name(uses(made, [(name, seen, None) for seen in seen_by]))
            said = [(name, r.stamp_ns, r.estimates) for r in results[name]]
            singly.append(beside_best({name: one}, STAY, results, said, 0.0, robots, last_s))
    told.sort(key=lambda item: item[:2])
    both = list[list[float]]()
    for configs in (swim, found):
        fleet = Fleet(configs, local)
        updates = [(name, seen, fleet.update(name, seen)) for _, name, seen in told]
        both.append(errors(made["a"], local, [update.estimates for *_, update in updates]))
    beside = [math.nan] * 5
    if singly:
        robots = robots_by_name(
            uses(made, [(n, seen, update.names) for n, seen, update in updates])
        )
        said = [(name, seen.stamp_ns, update.estimates) for name, seen, update in updates]
        joint = beside_best(made, STAY, results, said, 0.5, robots, last_s)
        each, bounds = (
            float(np.mean([getattr(s, of) for s in singly])) for of in ("expected", "bound")
        )
        beside = [each, joint.expected, bounds, joint.bound, joint.nees]
    return [float(np.mean(alone)), both[0][0], *both[1], *beside]


def expected(means: list[float]) -> list[str]:
    """Return the cells of what is expected, of the last numbers of `flown`."""
    if math.isnan(means[0]):
        return ["-"] * 5
    alone, together, single, joint = (math.sqrt(one) for one in means[:4])
    cells = [f"{alone:.3f}", f"{together:.3f}", f"{alone / together:.2f}"]
    return [*cells, f"{single / joint:.2f}", f"{means[4]:.2f}"]


def main() -> int:
    """Fly what is missing and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="of each row (default 4)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--flights", nargs="*", choices=CELLS, default=[*CELLS][:2],
                        help="kinds of flights (default: over three robots)")  # fmt: skip
    parser.add_argument("--motions", nargs="*", choices=MOTIONS, default=MOTIONS,
                        help="of the robots (default all)")  # fmt: skip
    parser.add_argument("--flown", type=Path, help="file that keeps the flights")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    kept = dict[tuple[str, str, int], list[float]]()
    if given.flown is not None and given.flown.is_file():
        for line in given.flown.read_text(encoding="utf-8").splitlines():
            kind, motion, seed, *one = json.loads(line)
            kept[kind, motion, seed] = one
    rows = []
    for kind in given.flights:
        for motion in given.motions:
            first = 5_000_001 + given.first
            for seed in range(first, first + given.seeds):
                key = kind, motion, seed
                if key in kept:
                    continue
                kept[key] = flown(CELLS[kind], motion, seed)
                if given.flown is not None:
                    with given.flown.open("a", encoding="utf-8") as file:
                        file.write(json.dumps([*key, *kept[key]]) + "\n")
            own_keys = [key for key in kept if key[:2] == (kind, motion)]
            if not own_keys:
                continue
            means = np.mean([kept[key] for key in own_keys], axis=0)
            alone, swimming, together = (math.sqrt(one) for one in means[:3])
            rows.append(
                [
                    kind, motion, str(len(own_keys)),
                    *(f"{one:.3f}" for one in (alone, swimming, together)),
                    f"{alone / together:.2f}", f"{means[3]:.2f}", f"{100.0 * means[4]:.2f} %",
                    *expected(means[5:].tolist()),
                ]
            )  # fmt: skip
    heads = [
        "flight", "motion", "flights", "alone, m", "together, all swim, m", "together, m", "gain",
        "NEES/2", "beyond", "expected: alone, m", "together, m", "gain", "bound's gain", "NEES/2",
    ]  # fmt: skip
    show(columns(heads, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
