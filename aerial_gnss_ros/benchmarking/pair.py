# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Both nodes in one process as `aerial-gnss run` has them; reports the time of each stage.

    python3 -m aerial_gnss_ros.benchmarking.pair --samples FILE --ros-args -p search.mode:=roi

SIGUSR1 restarts the measurement.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.nodes import process
from aerial_gnss_ros.nodes.both import both
from aerial_gnss_ros.nodes.supervised import Given
from aerial_gnss_ros.nodes.timings import Timings

_IMAGES = 100_000


def main(argv: Sequence[str] | None = None) -> int:
    """Run both nodes until a signal; return the exit status."""
    arguments = list(sys.argv if argv is None else argv)
    parser = argparse.ArgumentParser(prog="pair", description=__doc__)
    parser.add_argument("--samples", type=Path, required=True, help="JSON file to write")
    parser.add_argument("--params", type=Path, nargs="+", default=[], help="parameter files")
    args = parser.parse_args(process.own_arguments(arguments)[1:])
    timings: dict[str, Timings] = {}

    def made(make: Callable[[], Any]) -> Any:
        node = make()
        timings[node.get_name()] = node.timings
        return node

    def begin(_number: int, _frame: Any) -> None:
        for each in timings.values():
            each.remember(_IMAGES)

    signal.signal(signal.SIGUSR1, begin)
    makers = both(Given(args.params))
    try:
        status = process.spin([partial(made, make) for make in makers], arguments)
    except AerialGnssError as error:
        sys.stderr.write(f"{error}\n")
        return process.WRONG_INPUT
    samples = {name: each.samples_ms() for name, each in timings.items()}
    args.samples.write_text(json.dumps(samples), encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
