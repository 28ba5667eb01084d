# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How well does the filter find the latency of the images while it flies?

python benchmarks/latency.py --seeds 3 --markdown latency.md

Still robots seen from 30 m with an RTK receiver, 60 s; the filter is given a sigma of 0.3 s, or as
large as the latency. Given are the estimate's error and its own sigma at the end, after how long
that sigma was below 0.1 s, and the NEES of the robots' positions: the median over robots and
seconds (1.4 is expected), in the first 10 s, when little is known of the latency, and afterwards.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Cell, Setting, config, experiment, results, robots_of, truth
from tables import keep

from aerial_gnss_ros.core.values.estimates import State

LATENCIES_S = (0.1, 0.5, 1.0, 2.5, -1.0)
KNOWN_S = 0.1
EARLY_S = 10.0

HEADS = (
    "flight", "latency s", "RMS error s", "largest", "its own sigma s", "RMS error / sigma",
    "known to 0.1 s after s", "NEES before 10 s", "NEES after", "extra names",
)  # fmt: skip


class Flight:
    """Results of one flight.

    Attributes:
        error: of the estimated latency at the end, s.
        sigma: its own at the end, s.
        known_s: time at which sigma fell below `KNOWN_S`, s; infinite where it did not.
        nees: of positions before and after `EARLY_S`, each second and robot.
        extra_names: published names less robots seen.
    """

    def __init__(self, family: str, latency_s: float, seed: int) -> None:
        cell = Cell(family, 30.0, "rtk", moving=False)
        stated = {"noise.latency_s": max(0.3, abs(latency_s))}
        setting = Setting(latency_s=latency_s, stated=stated)
        made = experiment(cell, seed, setting)
        images = list(made.detections())
        frames, true = results(made, config(cell, setting), images), truth(made, images)
        names = robots_of(frames, true)
        self.known_s = np.inf
        self.nees: tuple[list[float], list[float]] = [], []
        start = frames[0].stamp_ns
        for k, frame in enumerate(frames):
            t = (frame.stamp_ns - start) * 1e-9
            told = next((one for one in frame.platform if one.name == "latency"), None)
            if told is not None:
                self.error, self.sigma = told.value - latency_s, told.sigma
                if told.sigma < KNOWN_S:
                    self.known_s = min(self.known_s, t)
            if abs(t - round(t)) > 1e-6:
                continue
            for one in frame.estimates:
                if one.state is State.CONFIRMED:
                    error = one.position - true[k].positions[names[one.robot_id]]
                    nees = float(error @ np.linalg.solve(one.covariance[:2, :2], error))
                    self.nees[t >= EARLY_S].append(nees)
        seen = int(np.any([frame.seen for frame in true], axis=0).sum())
        self.extra_names = len(names) - seen


def row(family: str, latency_s: float, flights: list[Flight]) -> str:
    """Return a row of the table."""
    errors = np.array([one.error for one in flights])
    sigmas = np.array([one.sigma for one in flights])
    early, later = (np.median(np.concatenate([f.nees[i] for f in flights])) for i in (0, 1))
    cells = [
        f"{family} 30 m", f"{latency_s:g}", f"{np.sqrt(np.mean(errors**2)):.3f}",
        f"{np.abs(errors).max():.3f}", f"{np.median(sigmas):.3f}",
        f"{np.sqrt(np.mean((errors / sigmas) ** 2)):.2f}",
        f"{np.median([one.known_s for one in flights]):.0f}", f"{early:.1f}", f"{later:.1f}",
        f"{sum(one.extra_names for one in flights)}",
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="flights a row (default 3)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    lines = [f"| {' | '.join(HEADS)} |", "|---" + "|---:" * (len(HEADS) - 1) + "|"]
    for family in ("transit", "orbit", "hover"):
        for latency_s in LATENCIES_S:
            flights = [Flight(family, latency_s, seed) for seed in range(given.seeds)]
            lines.append(row(family, latency_s, flights))
            print(lines[-1], flush=True)
    keep("\n".join(lines) + "\n", given.markdown)


if __name__ == "__main__":
    main()
