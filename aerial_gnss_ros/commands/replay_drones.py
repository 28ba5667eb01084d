# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replays the recordings of several drones into one result."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.bags.replay_drones import DronesReplay
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.stated_datum import with_stated_datum
from aerial_gnss_ros.commands import drone_arguments
from aerial_gnss_ros.commands.configuration import Configuration, configuration
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.evaluation.truth import Truth, read_truth

Load = Callable[[DetectorConfig], Detector]
Finish = Callable[[Path, ResultFolder, DronesReplay, Truth], None]


def replay_drones(args: argparse.Namespace, load: Load, finish: Finish) -> DronesReplay:
    """Replay the drones' recordings into one folder.

    Args:
        args: of the command, checked.
        load: creates the detector.
        finish: writes the report into the folder before it gets its name.
    """
    found = configuration(args)
    own = {name: _own(args, name).estimator for name, _ in args.drone}
    with ended_cleanly(), ExitStack() as open_bags:
        bags: dict[str, BagReader] = {}
        configs: dict[str, EstimatorConfig] = {}
        for name, path in args.drone:
            bags[name] = open_bags.enter_context(open_bag([path]))
            configs[name] = with_stated_datum(own[name], bags[name])
        share = 0.5 if args.gnss_share is None else args.gnss_share
        replay = DronesReplay(
            bags, configs, found.detector, load,
            namespaces={name: drone_arguments.namespace(args, name) for name in bags},
            detect=args.model is not None, share=share,
        )  # fmt: skip
        with partial(args.output) as folder:
            folder.mkdir()
            config = found.estimator.map
            with (
                ResultFolder(
                    folder, args.namespace, config, args.rosbag_version, None, not args.no_bag
                ) as results,
                progress("replaying", replay.message_count, "messages") as report,
            ):
                for result in replay.results(report):
                    results.add(result)
            replay.tables.write(folder)
            finish(folder, results, replay, read_truth(next(iter(bags.values()))))
    return replay


def _own(args: argparse.Namespace, name: str) -> Configuration:
    """Return the configuration of one drone."""
    own = argparse.Namespace(**vars(args))
    own.namespace = drone_arguments.namespace(args, name)
    own.params = [*args.params, *(path for one, path in args.drone_params if one == name)]
    return configuration(own)
