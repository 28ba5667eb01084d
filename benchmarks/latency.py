# SPDX-License-Identifier: Apache-2.0
"""How well does the filter find the latency of the images while it flies?

python benchmarks/latency.py --seeds 3 --markdown latency.md

Still robots seen from 30 m with an RTK receiver, 60 s; the filter is told a sigma of 0.3 s, or as
large as the latency. Given are the estimate's error and its own sigma at the end.
"""

from __future__ import annotations

import argparse
import math
import os
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 - the number of threads comes first
from families import Cell, Setting, config, experiment, results  # noqa: E402

LATENCIES_S = (0.1, 0.5, 1.0, 2.5, -1.0)


def found(family: str, latency_s: float, seed: int) -> tuple[float, float]:
    """Return the error of the estimated latency at the end of a flight and its sigma, s."""
    cell = Cell(family, 30.0, "rtk", moving=False)
    stated = {"noise.latency_s": max(0.3, abs(latency_s))}
    setting = Setting(latency_s=latency_s, stated=stated)
    frames = results(experiment(cell, seed, setting), config(cell, setting))
    told = [one for frame in frames for one in frame.platform if one.name == "latency"]
    return (told[-1].value - latency_s, told[-1].sigma) if told else (math.nan, math.nan)


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="flights a row (default 3)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    lines = [
        "| flight | latency s | RMS error s | largest | its own sigma s |",
        "|---|---:|---:|---:|---:|",
    ]
    for family in ("transit", "orbit", "hover"):
        for latency_s in LATENCIES_S:
            rows = np.array([found(family, latency_s, seed) for seed in range(given.seeds)])
            rms, most = np.sqrt(np.mean(rows[:, 0] ** 2)), np.max(np.abs(rows[:, 0]))
            sigma = np.median(rows[:, 1])
            lines.append(
                f"| {family} 30 m | {latency_s:g} | {rms:.3f} | {most:.3f} | {sigma:.3f} |"
            )
            print(lines[-1], flush=True)
    if given.markdown:
        given.markdown.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
