# SPDX-License-Identifier: Apache-2.0
"""Are positions as good as physics allows, and is their covariance honest? A table over families.

python benchmarks/consistency.py --seeds 20 --processes 2 --json table.json --markdown table.md

NEES is e' P^-1 e of a robot's East and North at 10, 30 and 60 s, of robots in view; its expectation
is 2. Robots of one flight share the platform's errors, so the chi-square band is that of one robot
a flight (the seed says which), at 95 % over all cells and times together (Bonferroni); the mean
printed is of the same robots. RMS and bound are over all robots in view, each second from 10 s on.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 - the number of threads comes first
from families import (  # noqa: E402
    Cell,
    Setting,
    bounds,
    cells,
    config,
    experiment,
    results,
    robots_of,
    truth,
)
from scipy.stats import chi2  # noqa: E402

from aerial_gnss_ros.core.values import State  # noqa: E402

TIMES_S = (10.0, 30.0, 60.0)


@dataclass(frozen=True)
class Flown:
    """One flight's figures.

    Attributes:
        nees: by time (s) of the chosen robot; absent where it is not in view.
        nees_all: of all robots and times.
        squared: sum of squared errors, m².
        bound: sum of the bounds' traces at the same samples, m².
        stated: sum of the published traces, m².
        samples: number of samples.
        names: published names less robots seen: identity changes.
        ms: milliseconds of core time per image.
    """

    nees: dict[float, float]
    nees_all: list[float]
    squared: float
    bound: float
    stated: float
    samples: int
    names: int
    ms: float


def fly(cell: Cell, seed: int, setting: Setting) -> Flown:
    """Return the figures of one flight."""
    made, stated = experiment(cell, seed, setting), config(cell, setting)
    true = truth(made)
    found = results(made, stated)
    limits = bounds(made, stated, true)
    names = robots_of(found, true)
    times = [round((f.pose.stamp_ns - true[0].pose.stamp_ns) * 1e-9, 3) for f in true]
    end = times[-1]
    chosen = seed % setting.robots
    nees: dict[float, float] = {}
    every: list[float] = []
    squared = bound = published = 0.0
    samples = 0
    for k, t in enumerate(times):
        at = next((one for one in TIMES_S if abs(min(one, end) - t) < 1e-6), None)
        if at is None and (t < TIMES_S[0] or abs(t - round(t)) > 1e-6):
            continue
        for estimate in found[k].estimates:
            robot = names[estimate.robot_id]
            if estimate.state is not State.CONFIRMED or not true[k].seen[robot]:
                continue
            error = estimate.position - true[k].positions[robot]
            covariance = estimate.covariance[:2, :2]
            value = float(error @ np.linalg.solve(covariance, error))
            if at is not None:
                every.append(value)
                if robot == chosen:
                    nees[at] = value
            squared += float(error @ error)
            bound += float(np.trace(limits[k, robot, :2, :2]))
            published += float(np.trace(covariance))
            samples += 1
    seen = int(np.any([frame.seen for frame in true], axis=0).sum())
    ms = float(np.mean([sum(result.timings_ms.values()) for result in found]))
    return Flown(nees, every, squared, bound, published, samples, len(names) - seen, ms)


def band(count: int, tests: int) -> tuple[float, float]:
    """Return the limits of the mean of planar NEES that one of `tests` leaves at 5 % in all."""
    tail = 0.05 / tests / 2.0
    return (
        float(chi2.ppf(tail, 2 * count)) / count,
        float(chi2.ppf(1.0 - tail, 2 * count)) / count,
    )


def row(cell: Cell, flown: list[Flown], tests: int) -> dict[str, object]:
    """Return one line of the table."""
    found: dict[str, object] = {"cell": cell.words}
    inside = True
    for t in TIMES_S:
        values = [one.nees[t] for one in flown if t in one.nees]
        if not values:
            found[f"nees_{t:g}s"], found[f"band_{t:g}s"] = None, None
            continue
        low, high = band(len(values), tests)
        mean = float(np.mean(values))
        inside &= low <= mean <= high
        found[f"nees_{t:g}s"], found[f"band_{t:g}s"] = mean, (low, high, len(values))
    every = [value for one in flown for value in one.nees_all]
    samples = max(1, sum(one.samples for one in flown))
    rms = math.sqrt(sum(one.squared for one in flown) / samples)
    limit = math.sqrt(sum(one.bound for one in flown) / samples)
    return found | {
        "nees_all": float(np.mean(every)) if every else None,
        "inside": inside,
        "rms_m": rms,
        "bound_m": limit,
        "published_m": math.sqrt(sum(one.stated for one in flown) / samples),
        "ratio": rms / limit if limit > 0.0 else None,
        "extra_names": sum(one.names for one in flown),
        "core_ms": float(np.median([one.ms for one in flown])),
    }


def markdown(rows: list[dict[str, object]]) -> str:
    """Return the table."""

    def number(value: object, digits: int = 2) -> str:
        return "–" if value is None else f"{float(value):.{digits}f}"  # type: ignore[arg-type]

    head = (
        "| flight | NEES 10 s | 30 s | 60 s | all robots | in band | RMS m | bound m | ratio | "
        "published m | extra names |"
    )
    lines = [head, "|---" * 11 + "|"]
    for one in rows:
        nees = " | ".join(number(one[f"nees_{t:g}s"]) for t in TIMES_S)
        lines.append(
            f"| {one['cell']} | {nees} | {number(one['nees_all'])} | "
            f"{'yes' if one['inside'] else 'NO'} | {number(one['rms_m'], 3)} | "
            f"{number(one['bound_m'], 3)} | {number(one['ratio'])} | "
            f"{number(one['published_m'], 3)} | {one['extra_names']} |"
        )
    return "\n".join(lines) + "\n"


def main() -> int:
    """Fly all families and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20, help="flights a cell")
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument(
        "--only", default="", help="cells whose words hold all these, comma between"
    )
    parser.add_argument("--robots", type=int, default=3)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    wanted = [part.strip() for part in given.only.split(",") if part.strip()]
    chosen = [cell for cell in cells() if all(part in cell.words for part in wanted)]
    setting, tests = Setting(robots=given.robots), len(TIMES_S) * len(cells())
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    rows = []
    with ProcessPoolExecutor(given.processes) as pool:
        futures = {
            cell: [pool.submit(fly, cell, seed, setting) for seed in seeds] for cell in chosen
        }
        for cell in chosen:
            rows.append(row(cell, [future.result() for future in futures[cell]], tests))
            print(markdown(rows).splitlines()[-1], file=sys.stderr, flush=True)
    print(markdown(rows))
    if given.markdown:
        given.markdown.write_text(markdown(rows), encoding="utf-8")
    if given.json:
        given.json.write_text(json.dumps({"seeds": given.seeds, "rows": rows}, indent=1) + "\n",
                              encoding="utf-8")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
