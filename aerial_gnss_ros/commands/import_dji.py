# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss import-dji`: a DJI flight record, with its video, to a bag on canonical topics."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from aerial_gnss_ros.adapters.dji_log import ROW_RATE_HZ, DjiLog, read_dji_log
from aerial_gnss_ros.bags.alignment import Alignment, align
from aerial_gnss_ros.bags.import_dji import START_NS, Footage, write_dji_bag
from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.bags.video import Video, open_video
from aerial_gnss_ros.commands.argument_types import add_rosbag_version
from aerial_gnss_ros.commands.camera_arguments import add_numbers, chosen_camera
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.import_report import Imported, as_json, as_text
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import InputError

_LATEST_START_S = 2_100_000_000.0
"""ROS stamps end in 2038; the longest flight must end before."""
_LOWEST_M, _HIGHEST_M = -500.0, 10_000.0  # as water_level.value_m


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "An interrupted import leaves no files: run it again. Memory does not grow with the "
        "video's length."
    )
    parser.add_argument(
        "log", type=Path,
        help="flight record or AirData as CSV, heights in feet or metres; or SRT subtitles",
    )  # fmt: skip
    parser.add_argument("video", type=Path, nargs="?", help="the video of that flight, such as mp4")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="BAG", help="folder of the new bag"
    )
    add_rosbag_version(parser)
    parser.add_argument("--namespace", default="", help="namespace of the topics, such as drone1")
    parser.add_argument(
        "--rate", type=float, default=ROW_RATE_HZ, metavar="HZ",
        help="row rate if the log has no time column, Hz (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--start", type=float, metavar="S",
        help=
                "Unix time of the log's time zero, s (default: the log's UTC date if present, "
                "else 2025-01-01)",
    )  # fmt: skip
    parser.add_argument(
        "--water-level", type=float, metavar="M",
        help=
                "level of the water above the take-off point, m: -15 if you took off from a "
                "cliff 15 m above it; recorded in the bag for replay",
    )  # fmt: skip
    _add_video(parser.add_argument_group("video"))
    camera = parser.add_argument_group("camera", "recorded in the bag if given")
    camera.add_argument(
        "--camera", metavar="YAML|NAME",
        help="CameraInfo YAML, a photo (its EXIF), or a known drone (`aerial-gnss camera --list`)",
    )  # fmt: skip
    add_numbers(camera)
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def _add_video(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--offset", type=float, metavar="S",
        help="log time at which the video begins, s (default: from the log's video marker)",
    )  # fmt: skip
    group.add_argument(
        "--recording", type=int, metavar="N", help="number of the recording in the log, from 1"
    )
    group.add_argument(
        "--every", type=int, default=1, metavar="N", help="import every N-th frame (%(default)s)"
    )
    group.add_argument(
        "--jpeg-quality", type=int, default=95, metavar="Q",
        help="JPEG quality, 1 to 100 (%(default)s); H.264 frames must be re-encoded",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Import a log."""
    refuse_existing(args.output)
    _check(args)
    log = read_dji_log(args.log, args.rate)
    video = None if args.video is None else open_video(args.video)
    size = None if video is None else (video.width, video.height)
    camera = chosen_camera(args, args.camera, size)
    start = None if video is None else align(log, video.duration_s, args.offset, args.recording)
    start_ns = _start_ns(args, log)
    footage = _footage(args, video, start)
    total = _total(log, footage, camera is not None, args.water_level is not None)
    with ended_cleanly(), progress("importing", total, "messages") as report:
        counts = write_dji_bag(
            log,
            args.output,
            camera=None if camera is None else camera.camera,
            footage=footage,
            start_ns=start_ns,
            water_level=args.water_level,
            namespace=args.namespace,
            on_message=report,
            version=args.rosbag_version,
        )
    done = Imported(
        args.output, log, camera, video, start, args.every, start_ns, counts, args.water_level
    )
    print(json.dumps(as_json(done), indent=2) if args.json else as_text(done))
    return 0


def _check(args: argparse.Namespace) -> None:
    if not args.rate > 0.0:
        raise InputError(f"--rate must be above 0 Hz, not {args.rate:g}.")
    if args.start is not None and not 0.0 <= args.start <= _LATEST_START_S:
        raise InputError(
            f"--start must be a Unix time within 0 and {_LATEST_START_S:.0f} s, not {args.start:g}."
        )
    if args.water_level is not None and not _LOWEST_M <= args.water_level <= _HIGHEST_M:
        raise InputError(
            f"--water-level must lie within {_LOWEST_M:g} and {_HIGHEST_M:g} m, not "
            f"{args.water_level:g}."
        )
    if args.offset is not None and not math.isfinite(args.offset):
        raise InputError(f"--offset must be a time in seconds, not {args.offset:g}.")
    if args.every < 1:
        raise InputError(f"--every must be 1 or more, not {args.every}.")
    if not 1 <= args.jpeg_quality <= 100:
        raise InputError(f"--jpeg-quality must lie within 1 and 100, not {args.jpeg_quality}.")
    if args.video is None and (args.offset is not None or args.recording is not None):
        raise InputError("--offset and --recording need a video; give it after the log.")


def _start_ns(args: argparse.Namespace, log: DjiLog) -> int:
    if args.start is not None:
        return round(float(args.start) * 1e9)
    return START_NS if log.clock_ns is None else log.clock_ns


def _footage(
    args: argparse.Namespace, video: Video | None, start: Alignment | None
) -> Footage | None:
    if video is None or start is None:
        return None
    return Footage(video, start.start_s, args.every, args.jpeg_quality)


def _total(log: DjiLog, footage: Footage | None, camera: bool, level: bool) -> int:
    """Return how many messages will be written."""
    inputs = 1 + sum(bool(len(values)) for values in (log.attitude, log.gimbal))
    telemetry = len(log) * inputs + len(log.heights()) + level
    if footage is None:
        return telemetry + len(log) * camera
    return telemetry + -(-footage.video.count // footage.every) * (1 + camera)
