# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""python -m fuzz --cases 20000 --seed 1 [--only messages] [--case 17]."""

from __future__ import annotations

import argparse
import faulthandler
import os
import sys
import warnings

from fuzz.engine import KINDS, Tally, Target, run

SHOWN = 12


def all_targets() -> list[Target]:
    """Return what can be fuzzed."""
    from fuzz import files, messages, outputs

    return [*messages.targets(), *files.targets(), *outputs.targets()]


def arguments() -> argparse.ArgumentParser:
    """Return the options."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="see fuzz/README.md")
    parser.add_argument(
        "--cases", type=int, default=20_000, help="number of cases over all targets"
    )
    parser.add_argument("--seed", type=int, default=1, help="random seed")
    parser.add_argument(
        "--skip", type=int, default=0, metavar="N", help="number of blocks of --cases to skip"
    )
    parser.add_argument(
        "--only", action="append", default=[], metavar="TARGET", help="may be repeated"
    )
    parser.add_argument("--case", type=int, help="run only this case, and print all its mutations")
    parser.add_argument("--all", action="store_true", help="print every finding")
    return parser


def main() -> int:
    """Run the cases; return 1 where one of them found something."""
    given = arguments().parse_args()
    known = {target.name: target for target in all_targets()}
    unknown = sorted(set(given.only) - set(known))
    if unknown or (given.case is not None and len(given.only) != 1):
        sys.stderr.write(f"--only takes one of: {', '.join(known)}; --case needs it.\n")
        return 2
    warnings.simplefilter("ignore")  # numpy's, of what is damaged on purpose
    faulthandler.enable(os.fdopen(os.dup(2), "w"))  # a crash in C is told even so
    chosen = [known[name] for name in given.only] or list(known.values())
    if given.case is not None:
        return _one(chosen[0], given.seed, given.case)
    weights = sum(target.weight for target in chosen)
    print(" | ".join(["target", "cases", "s", *KINDS]))
    tallies = []
    for target in chosen:
        count = max(1, round(given.cases * target.weight / weights))
        tally = run(target, given.seed, given.skip * count, count)
        tallies.append(tally)
        print(_row(target.name, tally), flush=True)
    total = Tally(
        sum(tally.cases for tally in tallies),
        sum(tally.seconds for tally in tallies),
        [finding for tally in tallies for finding in tally.findings],
    )
    print(_row("all", total))
    _report(total, given.seed, given.all)
    return 1 if total.findings else 0


def _row(name: str, tally: Tally) -> str:
    counts = [str(tally.count(kind)) for kind in KINDS]
    return " | ".join([name, str(tally.cases), f"{tally.seconds:.1f}", *counts])


def _report(total: Tally, seed: int, every: bool) -> None:
    told: set[tuple[str, str]] = set()
    for finding in total.findings:
        cause = finding.kind, finding.where
        if not every and (cause in told or len(told) >= SHOWN):
            continue
        told.add(cause)
        print(f"\n{finding.kind}, {total.causes[cause]} times: {finding.words}")
        print(f"  python -m fuzz --seed {seed} --only {finding.target} --case {finding.case}")
    if len(total.causes) > len(told):
        print(f"\nand {len(total.causes) - len(told)} causes more (--all shows every finding)")


def _one(target: Target, seed: int, number: int) -> int:
    tally = run(target, seed, number, 1, show=print)
    for finding in tally.findings:
        print(f"{finding.kind}: {finding.words}")
        if finding.trace:
            print(finding.trace)
    return 1 if tally.findings else 0


if __name__ == "__main__":
    sys.exit(main())
