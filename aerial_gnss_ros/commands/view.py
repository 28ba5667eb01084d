# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss view`: a live picture, or one of a recording, for a tablet's browser."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.bags.stated_datum import with_stated_datum
from aerial_gnss_ros.commands.configuration import Configuration, configuration
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.notices import say
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.view.live import STEP_S, Live
from aerial_gnss_ros.view.page import PAGE, SOCKET, LiveSocket, RecordingSocket, tile_routes
from aerial_gnss_ros.view.pictures import RecordedPictures
from aerial_gnss_ros.view.recording import (
    Recording,
    recorded_overviews,
    replayed_overviews,
    tabled_overviews,
)
from aerial_gnss_ros.view.server import LOCAL, PORT, Route, application, is_local
from aerial_gnss_ros.view.server import run as serve
from aerial_gnss_ros.view.tiles import Tiles


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Without BAG the live estimator is shown. The page needs no internet. A recording without "
        "positions is replayed first; give the result of `aerial-gnss replay` to spare that, and "
        "its bag beside it for the images."
    )
    parser.add_argument(
        "paths", type=Path, nargs="*", metavar="BAG|RESULT",
        help="recordings, or folders that `aerial-gnss replay` wrote (default: live)",
    )  # fmt: skip
    parser.add_argument(
        "--bind", default=LOCAL, metavar="ADDRESS",
        help="address to serve: 0.0.0.0 for all of the boat's network (%(default)s: this computer)",
    )  # fmt: skip
    parser.add_argument(
        "--port", type=int, default=PORT, metavar="N", help="TCP port (%(default)s; 0: any free)"
    )
    parser.add_argument(
        "--tiles", type=Path, metavar="FILE", help="chart or map to draw below, an MBTiles file"
    )
    add_configuration(parser)
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], metavar="ARG",
        help="live: arguments for ROS, such as -r FROM:=TO; must come last",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Serve the page until a signal."""
    if not 0 <= args.port <= 65535:
        raise InputError(f"--port must be 0 to 65535, not {args.port}.")
    config = configuration(args)
    tiles = None if args.tiles is None else Tiles(args.tiles)
    (recorded if args.paths else live)(args, config, tiles)
    return 0


def live(args: argparse.Namespace, config: Configuration, tiles: Tiles | None) -> None:
    """Serve the live estimator."""
    require_ros()
    from aerial_gnss_ros.nodes.overviews import OverviewListener

    image, boxes = config.detector.image.topic, config.detector.detections.topic
    listener = OverviewListener(args.namespace, image, boxes, args.ros_args)
    try:
        source = Live(listener, args.namespace.strip("/") or "live", tiles)
        routes: list[Route] = [(SOCKET, LiveSocket, {"source": source}), *tile_routes(tiles)]
        show(args, routes, (STEP_S, source.tick))
    finally:
        listener.close()


def recorded(args: argparse.Namespace, config: Configuration, tiles: Tiles | None) -> None:
    """Serve a recording."""
    tables = [table for path in args.paths if (table := path / "positions.csv").is_file()]
    if len(tables) > 1:
        raise InputError(f"{tables[0].parent} and {tables[1].parent} are two results; give one.")
    # The bag of a result, if it has one, and all others as they are.
    bags = [path for path in map(_bag, args.paths) if path is not None]
    recording = Recording(
        overviews(bags, tables, args, config), ", ".join(path.name for path in args.paths)
    )
    image, boxes = config.detector.image.topic, config.detector.detections.topic
    pictures = RecordedPictures(bags, image, boxes, args.namespace)
    try:
        shown = pictures if bags and pictures.find() else None
        arguments = {"recording": recording, "pictures": shown, "tiles": tiles}
        show(args, [(SOCKET, RecordingSocket, arguments), *tile_routes(tiles)])
    finally:
        pictures.close()


def overviews(
    bags: Sequence[Path],
    tables: Sequence[Path],
    args: argparse.Namespace,
    config: Configuration,
) -> list[str]:
    """Return the overviews of recordings: recorded ones, those of a result, or of a replay."""
    if not bags:
        return tabled_overviews(tables[0])
    with open_bag(bags) as bag:
        if args.method is None and args.model is None:
            texts = recorded_overviews(bag, args.namespace)
            if texts is not None:
                return texts
            if tables:
                return tabled_overviews(tables[0])
        return list(replayed(bag, args, config))


def replayed(bag: BagReader, args: argparse.Namespace, config: Configuration) -> Iterator[str]:
    """Yield the overviews of a replay.

    Raises:
        InputError: as `Replay`, without its list of topics.
    """
    try:
        flight = Replay(
            bag,
            with_stated_datum(config.estimator, bag),
            config.detector,
            load_detector,
            namespace=args.namespace,
            detect=args.model is not None,
        )
    except InputError as error:
        raise InputError(str(error).partition(" It holds ")[0]) from error
    say(f"Robots from {flight.summary.detections_from}.")
    with progress("replaying", flight.message_count, "messages") as report:
        yield from replayed_overviews(flight, report)


def _bag(path: Path) -> Path | None:
    """Return the bag in the result of a replay, None if it has none; another path is a bag."""
    if not (path / "positions.csv").is_file():
        return path
    return path / "bag" if (path / "bag").is_dir() else None


def show(
    args: argparse.Namespace,
    routes: Sequence[Route],
    tick: tuple[float, Callable[[], None]] | None = None,
) -> None:
    """Serve routes until a signal."""

    def began(url: str) -> None:
        print(f"open {url} in a browser; Ctrl-C ends", flush=True)
        if not is_local(args.bind):
            say("Whoever is on this network can see the page.")

    serve(application(PAGE, routes), args.bind, args.port, began, tick)
