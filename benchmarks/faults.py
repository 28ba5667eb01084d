# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of positions when an input fails for five seconds.

python benchmarks/faults.py --flown faults.jsonl --markdown faults.md

Simulated flights of 40 s at 20 m with three robots, default parameters, sensors of consumer grade;
faults are in from 15 to 20 s but where their name says otherwise. Each flight is compared with the
same one without the fault. Flights that are done are kept, a line of JSON each: started again, it
goes on where it ended.

`wrong`: positions beyond a squared distance of 13.8 by their published covariance (one in a
thousand of a right one) that are not so without the fault, of those published from the fault's
begin on. `largest`: error by covariance of any, as sigmas. `positions`: measured ones while the
fault lasts and after it, of those without it. `names`: kept, of those to be kept. `right after`:
seconds from the fault's end until all robots are measured and right for a second; `never`: not in
this flight. `sigma`: the published one from 3 s after the fault on, of that without it.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import fault_table
from fault_cases import cases, fly
from fault_flights import DURATION_S, FLIGHTS
from tables import show

Record = dict[str, object]
Job = tuple[str, str, int]
"""A case's words, a kind of flight and a seed."""


def record(job: Job) -> Record:
    """Fly one and return its figures."""
    words, kind, seed = job
    case = next(one for one in cases() if one.words == words)
    began = time.perf_counter()
    verdict, run = fly(case, kind, seed)
    figures = verdict.record() | {
        "ends": case.end_s < DURATION_S,
        "died": run.died,
        "events": list(run.engine.take_events())[:8],
    }
    spent = round(time.perf_counter() - began, 2)
    return {"case": words, "flight": kind, "seed": seed, **figures, "seconds": spent}


def arguments() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--flown", type=Path, help="file of flights done, JSON lines")
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="kinds, comma between")
    parser.add_argument("--seeds", type=int, default=1, help="of each kind (default 1)")
    parser.add_argument("--first", type=int, default=1, help="the first one's seed (default 1)")
    parser.add_argument("--only", default="", help="cases that begin so, such as fix:jump")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--minutes", type=float, default=math.inf, help="begin none later")
    parser.add_argument("--failing", action="store_true", help="show only cases off target")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    return parser


def chosen(only: str) -> list[str]:
    """Return the cases that begin with some words, comma between; spaces do not matter."""
    wanted = [part.replace(" ", "") for part in only.split(",") if part.strip()] or [""]
    every = [case.words for case in cases()]
    return [
        words for words in every if any(words.replace(" ", "").startswith(part) for part in wanted)
    ]


def main() -> int:
    """Fly what lacks, print and keep the table."""
    given = arguments().parse_args()
    done = _read(given.flown)
    wanted = chosen(given.only)
    jobs = [
        (words, kind, seed)
        for seed in range(given.first, given.first + given.seeds)
        for kind in given.flights.split(",")
        for words in wanted
    ]
    lacking = [job for job in jobs if job not in done]
    until = time.monotonic() + 60.0 * given.minutes
    with ProcessPoolExecutor(given.jobs) as pool:
        found = pool.map(record, lacking) if given.jobs > 1 else map(record, lacking)
        for job, one in zip(lacking, found, strict=True):
            done[job] = one
            _keep(given.flown, one)
            print(fault_table.line(one), file=sys.stderr, flush=True)
            if time.monotonic() > until:
                break
    flights = [done[job] for job in jobs if job in done]
    table = f"{fault_table.counts(flights)}\n{fault_table.markdown(flights, given.failing)}"
    show(table, given.markdown)
    return 0


def _read(path: Path | None) -> dict[Job, Record]:
    if path is None or not path.exists():
        return {}
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return {(one["case"], one["flight"], one["seed"]): one for one in lines}


def _keep(path: Path | None, one: Record) -> None:
    if path is not None:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(one) + "\n")


if __name__ == "__main__":
    sys.exit(main())
