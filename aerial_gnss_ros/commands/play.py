# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss play`: plays a recording into live nodes, with `/clock`."""

from __future__ import annotations

import argparse
import math
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from aerial_gnss_ros.adapters.kinds import FIX
from aerial_gnss_ros.bags.one_drone import refuse_two_drones
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.commands.drone_arguments import drone_file
from aerial_gnss_ros.commands.notices import note
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.nodes.played_topics import inputs

if TYPE_CHECKING:
    from aerial_gnss_ros.nodes.fleet_bag import FleetBag

_AFTER_S = 4.0  # longer than max_wait, so that the last images get their answer
_LINGER_S = 0.5  # a large message lies in this process's memory until it has been read


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Messages keep the stamps of the recording, so nodes must follow /clock: start them with "
        "use_sim_time, such as `aerial-gnss run --ros-args -p use_sim_time:=true`. The space bar "
        "pauses, so do the services ~/pause, ~/resume and ~/toggle_paused."
    )
    parser.add_argument("bags", nargs="*", type=Path, metavar="BAG", help="rosbag2 recordings")
    parser.add_argument(
        "--drone", type=drone_file, action="append", default=[], metavar="NAME=BAG",
        help="recording of one of several drones, in place of BAG, played below its name; repeated "
        "for each drone",
    )  # fmt: skip
    parser.add_argument("--rate", type=float, default=1.0, help="2 plays twice as fast")
    parser.add_argument(
        "--start",
        type=float,
        default=0.0,
        metavar="S",
        help="start this long after the first message, s",
    )
    parser.add_argument(
        "--topics", nargs="+", metavar="TOPIC",
        help="absolute topic names as recorded (default: all but the nodes' own outputs)",
    )  # fmt: skip
    parser.add_argument("--namespace", default="", help="namespace for the topics, such as drone1")
    parser.add_argument(
        "--wait-for", nargs="+", default=[], metavar="NODE",
        help="wait until these nodes have subscribed, such as detector estimator, or with --drone "
        "drone1/estimator; in --namespace",
    )  # fmt: skip
    parser.add_argument(
        "--wait", type=float, default=60.0, metavar="S", help="longest wait, s (%(default)g)"
    )
    parser.add_argument("--pause", action="store_true", help="begin paused")
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], metavar="ARG",
        help="arguments for ROS, such as -r FROM:=TO; must come last",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Play until the end, or a signal."""
    if not (math.isfinite(args.rate) and args.rate > 0.0):
        raise InputError(f"--rate must be above 0, not {args.rate:g}.")
    if not (math.isfinite(args.start) and args.start >= 0.0):
        raise InputError(f"--start must be 0 s or more, not {args.start:g}.")
    if bool(args.bags) == bool(args.drone):
        raise InputError("give BAG, or --drone NAME=BAG for each of several drones, one of both.")
    names = [name for name, _ in args.drone]
    if len(set(names)) < len(names):
        raise InputError("two drones have one name; each needs its own.")
    require_ros()
    from aerial_gnss_ros.nodes import process
    from aerial_gnss_ros.nodes.transport import use_large_data_profile

    use_large_data_profile()
    with ExitStack() as opened:
        bag = _opened(args, opened)
        if args.start > 0.0 and args.start * 1e9 >= bag.end_ns - bag.start_ns:
            raise InputError(
                f"--start {args.start:g} s is after the end: the recording lasts "
                f"{(bag.end_ns - bag.start_ns) * 1e-9:.1f} s."
            )
        return process.work(lambda: _play(args, bag), ["aerial-gnss", "--ros-args", *args.ros_args])


def _opened(args: argparse.Namespace, opened: ExitStack) -> BagReader | FleetBag:
    """Return what is to be played."""
    if not args.drone:
        bag = opened.enter_context(open_bag(args.bags))
        played = inputs({one.name: one.msgtype for one in bag.topics.values()})
        positions = {kind.msgtype for kind in FIX.values()}
        refuse_two_drones(bag, [one for one in played if bag.topics[one].msgtype in positions])
        return bag
    from aerial_gnss_ros.nodes.fleet_bag import FleetBag

    return FleetBag({name: opened.enter_context(open_bag([path])) for name, path in args.drone})


def _play(args: argparse.Namespace, bag: BagReader | FleetBag) -> None:
    import rclpy

    from aerial_gnss_ros.nodes.listening import valid_names
    from aerial_gnss_ros.nodes.names import absolute_namespace
    from aerial_gnss_ros.nodes.pausing import Pausing, keys
    from aerial_gnss_ros.nodes.player import Player

    topics = args.topics or inputs({t.name: t.msgtype for t in bag.topics.values()})
    with valid_names(), keys() as keyboard:
        node = rclpy.create_node("player", namespace=absolute_namespace(args.namespace) or None)
        player = Player(
            node, bag, topics, args.rate,
            namespace=node.get_namespace(), installed_only=not args.topics,
        )  # fmt: skip
        player.paused = args.pause
        pausing = Pausing(node, player, keyboard=keyboard)
        if not args.topics and (left := sorted(set(bag.topics) - set(topics))):
            note(
                f"not played because the nodes publish them: {', '.join(left)} (--topics "
                "plays them)"
            )
        missing = player.wait_for_nodes(args.wait_for, args.wait, pausing.going_on)
        if missing:
            where, have = node.get_namespace(), "have" if len(missing) > 1 else "has"
            note(
                f"{' and '.join(missing)} in the namespace {where} {have} not subscribed after "
                f"{args.wait:g} s; playing anyway"
            )
        end_ns = player.play(pausing.going_on, bag.start_ns + round(args.start * 1e9))
        player.run_on(end_ns, _AFTER_S, pausing.going_on)
        if rclpy.ok():
            time.sleep(_LINGER_S)
        note(f"played {sum(player.published.values())} messages")
        node.destroy_node()
