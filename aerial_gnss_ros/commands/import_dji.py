# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss import-dji`: a DJI flight record to a bag on the canonical topics."""

from __future__ import annotations

import argparse
import json
import math
import re
import textwrap
from pathlib import Path

from aerial_gnss_ros.adapters.dji_log import (
    ROW_RATE_HZ,
    DjiLog,
    RefusedRow,
    read_dji_log,
    summarise_refusals,
)
from aerial_gnss_ros.bags.import_dji import START_NS, write_dji_bag
from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.errors import InputError

HELP = "turn a DJI flight record (CSV) into a bag"
_MM = 1e-3
_LINES_SHOWN = 8
_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "The log's video is not imported yet: the bag holds telemetry only, and the camera where "
        "its three arguments are given."
    )
    parser.add_argument("log", type=Path, help="flight record as CSV, heights in feet or metres")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="BAG", help="folder of the new bag"
    )
    parser.add_argument("--namespace", default="", help="put before the topics, such as drone1")
    parser.add_argument(
        "--rate", type=float, default=ROW_RATE_HZ, metavar="HZ",
        help="rows a second where the log has no time column (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--start", type=float, default=START_NS / 1e9, metavar="S",
        help="Unix time of the first row, s; the log tells no date (2025-01-01, 0 h UTC)",
    )  # fmt: skip
    camera = parser.add_argument_group(
        "camera", "described in the bag where all three are given: a pinhole without distortion"
    )
    camera.add_argument("--image-size", metavar="WxH", help="px, such as 1920x1080")
    camera.add_argument("--focal-length-mm", type=float, metavar="MM", help="at the zoom used")
    camera.add_argument(
        "--sensor-width-mm", type=float, metavar="MM", help="that the image's width covers"
    )
    parser.add_argument("--json", action="store_true", help="the summary for machines")


def run(args: argparse.Namespace) -> int:
    """Import a log."""
    refuse_existing(args.output)
    camera = _camera(args)
    if not args.rate > 0.0:
        raise InputError(f"--rate must be above 0 Hz, not {args.rate:g}.")
    if not (math.isfinite(args.start) and args.start >= 0.0):
        raise InputError(f"--start must be a Unix time in seconds, not {args.start:g}.")
    log = read_dji_log(args.log, args.rate)
    counts = write_dji_bag(
        log,
        args.output,
        camera=camera,
        start_ns=round(args.start * 1e9),
        namespace=args.namespace,
    )
    if args.json:
        print(json.dumps(_summary(args.output, log, counts), indent=2))
    else:
        _print_table(args.output, log, counts, camera is not None)
    return 0


def _camera(args: argparse.Namespace) -> CameraModel | None:
    given = {
        "--image-size": args.image_size,
        "--focal-length-mm": args.focal_length_mm,
        "--sensor-width-mm": args.sensor_width_mm,
    }
    missing = [flag for flag, value in given.items() if value is None]
    if len(missing) == len(given):
        return None
    if missing:
        raise InputError(f"a camera needs {', '.join(missing)} too; give all three or none.")
    match = re.fullmatch(r"(\d+)[xX](\d+)", args.image_size)
    if match is None:
        raise InputError(f"--image-size must be such as 1920x1080, not {args.image_size!r}.")
    return CameraModel.from_focal_length(
        args.focal_length_mm * _MM,
        args.sensor_width_mm * _MM,
        None,
        int(match[1]),
        int(match[2]),
    )


def _by_reason(refused: tuple[RefusedRow, ...]) -> dict[str, list[int]]:
    lines: dict[str, list[int]] = {}
    for row in refused:
        lines.setdefault(row.reason, []).append(row.line)
    return lines


def _summary(path: Path, log: DjiLog, counts: dict[str, int]) -> dict[str, object]:
    return {
        "bag": str(path),
        "rows": len(log),
        "duration_s": float(log.stamps_ns[-1] - log.stamps_ns[0]) * 1e-9,
        "messages": counts,
        "conversions": list(log.statements),
        "refused_lines": _by_reason(log.refused),
    }


def _print_table(path: Path, log: DjiLog, counts: dict[str, int], camera: bool) -> None:
    seconds = float(log.stamps_ns[-1] - log.stamps_ns[0]) * 1e-9
    print(f"{log.path}: {len(log)} rows, {seconds:.1f} s\n")
    rows = [statement.partition(": ")[::2] for statement in log.statements]
    refused = "nothing"
    if log.refused:
        refused = f"{summarise_refusals(log.refused, _LINES_SHOWN)}; --json lists every line"
    rows.append(("refused", refused))
    if not camera:
        rows.append(
            ("camera", "none; give --image-size, --focal-length-mm and --sensor-width-mm for one")
        )
    column = max(len(name) for name, _ in rows) + 4
    for name, text in rows:
        first = f"  {name}".ljust(column)
        print(textwrap.fill(text, _WIDTH, initial_indent=first, subsequent_indent=" " * column))
    print(f"\n{path}:")
    for topic, count in counts.items():
        print(f"  {topic:<24} {count} messages")
