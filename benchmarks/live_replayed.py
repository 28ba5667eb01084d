# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The demo's flights through the live nodes, replayed, and by each image alone.

python benchmarks/live_replayed.py --markdown live.md

Each flight is rendered, played into detector and estimator nodes, and replayed with the boxes that
the live detector published, all without a reference: single images cannot use one. Then the replay
is changed in one thing at a time, to see how much each matters. Errors are medians over robots and
images.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import rclpy
from tables import columns, show

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.tables import EstimatedTrack, Track, read_positions
from aerial_gnss_ros.commands.demo import PLAYED, SEARCH, demo_experiment, keep_boxes, tracks
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Array, Scalar
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.evaluation.errors import RobotErrors, compare, distances, summarise
from aerial_gnss_ros.evaluation.receiver import read_fixes, relative
from aerial_gnss_ros.evaluation.truth import Truth, read_truth
from aerial_gnss_ros.nodes.live import Heard, fly
from aerial_gnss_ros.nodes.transport import use_large_data_profile
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.scene import demo_scene

LATE_S = 0.02
"""Spread of the delays with which messages reach a node of a busy machine, one sigma, s."""
MIDDLE = 150


class Changed(Estimator):
    """Receives its inputs as a live node may.

    Args:
        method: filter or single.
        late_s: one sigma of the additional delays of heights, which are stamped on arrival, s.
        lost: number of the image that never arrives; -1: none.
    """

    def __init__(self, method: str = "filter", late_s: float = 0.0, lost: int = -1) -> None:
        super().__init__(estimator_config({"method": method}))
        self._late_s, self._lost, self._given = late_s, lost, 0
        self._rng = np.random.default_rng(0)

    def add_height(self, height: Scalar) -> None:
        """Add a height with a later stamp."""
        late_ns = round(abs(self._rng.normal(0.0, self._late_s)) * 1e9)
        super().add_height(replace(height, stamp_ns=height.stamp_ns + late_ns))

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add an image's boxes unless they are lost."""
        if self._given != self._lost:
            super().add_detections(frame)
        self._given += 1


def replayed(paths: list[Path], estimator: Estimator, method: str) -> dict[str, EstimatedTrack]:
    """Return what a replay publishes, by robot."""
    config = estimator_config({"method": method})
    with tempfile.TemporaryDirectory() as folder, open_bag(paths) as bag:
        replay = Replay(bag, config, detector_config(SEARCH), load_detector, estimator=estimator)
        with ResultFolder(Path(folder)) as results:
            for result in replay.results():
                results.add(result)
        return read_positions(Path(folder) / "positions.csv")


def flown(folder: Path, seed: int, rate: float) -> Heard:
    """Render the demo's flight and play it into the nodes; keep their boxes."""
    made = demo_experiment(30.0, 15.0, 3, seed)
    write_bag(folder / "flight", made, demo_scene(seed))
    with open_bag(folder / "flight") as bag:
        heard = fly(bag, list(PLAYED), folder / "nodes.log", lambda *_: None, rate, SEARCH)
    keep_boxes(folder, heard)
    return heard


def medians(errors: list[RobotErrors], fixes: Track, truth: Truth) -> str:
    """Return the median error, and that without the receiver's, m."""
    assert truth.drone is not None  # noqa: S101 - a simulated flight states it
    own = summarise(relative(errors, fixes, truth.drone))
    return f"{summarise(errors).median:.2f} / {own.median:.2f}"


CHANGES: dict[str, dict[str, float]] = {
    f"heights stamped up to {2e3 * LATE_S:.0f} ms late": {"late_s": LATE_S},
    "without the first image": {"lost": 0},
    f"without image {MIDDLE}": {"lost": MIDDLE},
}


def main() -> int:
    """Fly, compare and write the tables."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4])
    parser.add_argument("--rate", type=float, default=1.0, help="1 is real time (default)")
    parser.add_argument("--markdown", type=Path, help="page that takes the tables")
    given = parser.parse_args()
    use_large_data_profile()
    rclpy.init()
    rows: list[list[str]] = []
    changed: dict[str, list[Array]] = {"live": [], **{words: [] for words in CHANGES}}
    for seed in given.seeds:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            heard = flown(folder, seed, given.rate)
            paths = [folder / "flight", folder / "detections"]
            with open_bag(paths) as bag:
                truth, fixes = read_truth(bag), read_fixes(bag, "/fix")

            def errors(found: dict[str, EstimatedTrack], truth: Truth = truth) -> list[RobotErrors]:
                return compare(found, truth.robots, truth.drone)

            live = errors(tracks(heard.positions))
            again = errors(replayed(paths, Changed(), "filter"))
            single = errors(replayed(paths, Changed("single"), "single"))
            changed["live"].append(distances(live, again))
            for words, change in CHANGES.items():
                late, lost = change.get("late_s", 0.0), int(change.get("lost", -1))
                other = errors(replayed(paths, Changed("filter", late, lost), "filter"))
                changed[words].append(distances(other, again))
        each = [medians(one, fixes, truth) for one in (live, again, single)]
        rows.append([f"seed {seed}", f"{len(heard.detections)} of {heard.images}", *each])
        print(rows[-1], file=sys.stderr, flush=True)
    rclpy.try_shutdown()
    heads = ["flight", "images through the nodes", "live m", "replayed m", "single images m"]
    shares = {
        words: 1e3 * np.percentile(np.concatenate(one), (50, 95, 100))
        for words, one in changed.items()
    }
    differences = [[words, *(f"{mm:.0f}" for mm in one)] for words, one in shares.items()]
    more = columns(["against the replay", "median mm", "p95 mm", "largest mm"], differences)
    show(f"{columns(heads, rows)}\n{more}", given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
