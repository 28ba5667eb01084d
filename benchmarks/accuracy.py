# SPDX-License-Identifier: Apache-2.0
"""How far off is each method? Released code, paper, exact single image, ours, and the bound.

python benchmarks/accuracy.py --seeds 4 --json accuracy.json --markdown accuracy.md

Root mean square of the horizontal error over all robots in view, each second from 10 s on, of
flights of 60 s with three robots; every method sees the same boxes and telemetry, and is told which
box is which robot but for ours, which finds out. An error beyond 1 km counts as 1 km.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 - the number of threads comes first
import released_code  # noqa: E402
from families import (  # noqa: E402
    ORIGIN,
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
from scipy.optimize import linear_sum_assignment  # noqa: E402

from aerial_gnss_ros.core import localize, paper  # noqa: E402
from aerial_gnss_ros.core.frames import matrix_from_quaternion  # noqa: E402
from aerial_gnss_ros.core.local_map import LocalMap  # noqa: E402
from aerial_gnss_ros.core.values import State  # noqa: E402

METHODS = ("released", "paper", "single", "ours", "bound")
FIRST_S = 10.0
MOST_M = 1000.0


def fly(cell: Cell, seed: int, setting: Setting) -> dict[str, list[float]]:
    """Return squared errors (m²) of each method at the same samples of one flight."""
    made, stated = experiment(cell, seed, setting), config(cell, setting)
    true, found = truth(made), results(made, stated)
    limits = bounds(made, stated, true)
    names = robots_of(found, true)
    local = LocalMap(ORIGIN)
    attitudes = list(made.sensors.attitudes())
    stamps = np.array([attitude.stamp_ns for attitude in attitudes])
    errors: dict[str, list[float]] = {name: [] for name in METHODS}
    for k, (_, boxes, frame) in enumerate(made.detections()):
        seconds = (true[k].pose.stamp_ns - true[0].pose.stamp_ns) * 1e-9
        pose = found[k].pose
        if seconds < FIRST_S - 1e-6 or abs(seconds - round(seconds)) > 1e-6 or pose is None:
            continue
        ours = {
            names[one.robot_id]: one.position
            for one in found[k].estimates
            if one.state is State.CONFIRMED
        }
        body = attitudes[int(np.argmin(np.abs(stamps - pose.stamp_ns)))]
        exact = localize.locate(pose, made.camera, frame.centers, stated.noise, stated)
        printed = paper.locate(pose, made.camera, frame.centers, stated.noise, stated)
        places = {
            "released": local.positions(
                *released_code.locate(
                    pose, made.camera, frame.centers, frame.sizes,
                    matrix_from_quaternion(body.quaternion),
                )
            ),
            "paper": local.positions(printed.latitude, printed.longitude),
            "single": local.positions(exact.latitude, exact.longitude),
        }  # fmt: skip
        apart = np.linalg.norm(boxes.centers[:, None] - frame.centers[None], axis=2)
        for row, column in zip(*linear_sum_assignment(apart), strict=True):
            robot = made.swarm.names.index(boxes.names[row])
            if robot not in ours or exact.reasons[column] is not None:
                continue
            here = true[k].positions[robot]
            for name, found_places in places.items():
                off = np.nan_to_num(np.linalg.norm(found_places[column] - here), nan=MOST_M)
                errors[name].append(min(float(off), MOST_M) ** 2)
            errors["ours"].append(float(np.sum((ours[robot] - here) ** 2)))
            errors["bound"].append(float(np.trace(limits[k, robot, :2, :2])))
    return errors


def row(cell: Cell, flown: list[dict[str, list[float]]]) -> dict[str, object]:
    """Return one line of the table: RMS of each method, m, and ratios."""
    found: dict[str, object] = {"cell": cell.words}
    rms = {}
    for name in METHODS:
        squares = [value for one in flown for value in one[name]]
        rms[name] = math.sqrt(sum(squares) / len(squares)) if squares else math.nan
    found |= {f"{name}_m": value for name, value in rms.items()}
    found["samples"] = sum(len(one["ours"]) for one in flown)
    for name in ("released", "paper", "single"):
        found[f"{name}_by_ours"] = rms[name] / rms["ours"]
    found["ours_by_bound"] = rms["ours"] / rms["bound"]
    return found


def markdown(rows: list[dict[str, object]]) -> str:
    """Return the table."""
    heads = [
        "flight", "released code m", "paper m", "exact single m", "ours m", "bound m",
        "released / ours", "paper / ours", "single / ours", "ours / bound",
    ]  # fmt: skip
    keys = [f"{name}_m" for name in METHODS]
    keys += ["released_by_ours", "paper_by_ours", "single_by_ours", "ours_by_bound"]
    lines = [f"| {' | '.join(heads)} |", "|---" + "|---:" * (len(heads) - 1) + "|"]
    for one in rows:
        cells_ = [f"{float(one[key]):.2f}" for key in keys]  # type: ignore[arg-type]
        lines.append(f"| {one['cell']} | {' | '.join(cells_)} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Fly all families and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="flights a cell")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument(
        "--only", default="", help="cells whose words hold all these, comma between"
    )
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    wanted = [part.strip() for part in given.only.split(",") if part.strip()]
    chosen = [cell for cell in cells() if all(part in cell.words for part in wanted)]
    setting, rows = Setting(), []
    with ProcessPoolExecutor(given.processes) as pool:
        futures = {
            cell: [pool.submit(fly, cell, seed, setting) for seed in range(given.seeds)]
            for cell in chosen
        }
        for cell in chosen:
            rows.append(row(cell, [future.result() for future in futures[cell]]))
            print(markdown(rows).splitlines()[-1], file=sys.stderr, flush=True)
            # What is done is kept: a long run may be ended early.
            if given.markdown:
                given.markdown.write_text(markdown(rows), encoding="utf-8")
            if given.json:
                text = json.dumps({"seeds": given.seeds, "rows": rows}, indent=1) + "\n"
                given.json.write_text(text, encoding="utf-8")
    print(markdown(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
