# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replays several flights, each by itself, a few at a time."""

from __future__ import annotations

import argparse
import io
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError
from aerial_gnss_ros.simulation.workers import shared

WRONG_INPUT = 2
MOST_JOBS = 64
_KILLED = (
    "a flight's replay was killed from outside, most likely for want of memory; give a smaller -j."
)


@dataclass(frozen=True)
class _Flight:
    """A flight to replay.

    Attributes:
        args: of the command, for this flight alone.
        replay: replays one flight and prints its summary.
    """

    args: argparse.Namespace
    replay: Callable[[argparse.Namespace], int]


def replay_each(args: argparse.Namespace, replay: Callable[[argparse.Namespace], int]) -> int:
    """Replay each bag by itself into DIR/<its name>; one that fails does not end the others.

    Args:
        args: of the command.
        replay: replays one flight and prints its summary; a function of a module.

    Returns:
        0, or 2 where a flight could not be replayed.

    Raises:
        ConfigError: two bags have one name, or there are too many jobs.
        OutputError: a process was killed.
    """
    if args.jobs is not None and not 1 <= args.jobs <= MOST_JOBS:
        raise ConfigError(f"-j must lie within 1 to {MOST_JOBS}, not {args.jobs}.")
    names = [path.stem if path.is_file() else path.resolve().name for path in args.bags]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ConfigError(
            f"two bags are called {twice[0]}, and so would be their results; replay them apart."
        )
    args.output.mkdir(parents=True)
    flights = [
        _Flight(_alone(args, bag, args.output / name), replay)
        for bag, name in zip(args.bags, names, strict=True)
    ]
    failed = 0
    for done, (text, trouble) in enumerate(shared(_run, flights, args.jobs or 1, _KILLED), 1):
        if text:
            print(text, flush=True)
        if trouble:
            failed += 1
            print(f"aerial-gnss: {args.bags[done - 1]}: {trouble}", file=sys.stderr, flush=True)
    return WRONG_INPUT if failed else 0


def _alone(args: argparse.Namespace, bag: Path, output: Path) -> argparse.Namespace:
    own = argparse.Namespace(**vars(args))
    own.bags, own.output, own.each, own.jobs = [bag], output, False, None
    return own


def _run(flight: _Flight) -> tuple[str, str]:
    """Return a flight's summary, or why there is none."""
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(io.StringIO()):
            flight.replay(flight.args)
    except AerialGnssError as error:
        return "", str(error)
    return said.getvalue().rstrip(), ""
