# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real flights over sea and lake with hand-made boxes, default parameters: what becomes of them?

python benchmarks/real_flights.py --markdown docs/results/real_flights.md

Nobody states the latency, the lens or what is moored. There is no truth, but a buoy stays where it
is. `used`: share of the boxes that updated robots, and of those steeper than 15 deg below the
horizon. `spread`: distances of a buoy's positions from their median, over all its names, where it
is seen as steeply. `within 90 %`: share of these positions within their own ellipse of 90 %, and
the same with the variance of the receiver's offset taken out, which the median removes. `names`:
those given to an object while it stays in view, which is told by the image alone. `misfit`: mean
normalised squared innovation of a degree of freedom (1 is right; – where images are used one by
one, since the latency is unknown).
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from box_chains import chains
from numpy.typing import NDArray
from real_water import Row, Tables, camera_of, gimbal, stamp, write_bag
from tables import columns, show

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay, no_detector
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_quaternion
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State
from aerial_gnss_ros.detection.config import DetectorConfig

Array = NDArray[np.float64]
Key = tuple[int, float, float]
"""Stamp and centre of a box."""

STEEP_DEG, MOORED = 15.0, "buoy"
CHI2_90 = 4.605
LEAST_WIDTH_M = 0.05
"""Least sigma that is left of a position without the receiver's offset, m."""
LEAST_POSITIONS = 5
"""Fewer positions of an object have no spread worth the name."""
HEADS = [
    "flight", "camera down", "boxes", "used", "steeper than 15°", "latency s",
    "spread, median m", "p90 m", "within 90 %", "without offset", "names an object",
    "most names", "misfit",
]  # fmt: skip


@dataclass
class Flight:
    """What became of one flight.

    Attributes:
        rows: telemetry, one an image.
        boxes: of all images, by stamp and centre.
        named: the estimate of each box that measured a confirmed robot.
        refused: boxes that came to nothing.
        results: of all images.
        misfit: mean normalised squared innovation; NaN where there is none.
    """

    rows: list[Row]
    boxes: list[tuple[Key, str]]
    named: dict[Key, RobotEstimate] = field(default_factory=dict)
    refused: set[Key] = field(default_factory=set)
    results: list[FrameResult] = field(default_factory=list)
    misfit: float = math.nan

    @property
    def steep(self) -> list[bool]:
        """Return for each box whether it is steeper than `STEEP_DEG` below the horizon."""
        turn = {stamp(row): matrix_from_quaternion(gimbal(row).quaternion) for row in self.rows}
        camera = camera_of(self.rows[0])
        rays, _ = camera.rays(np.array([[u, v] for (_, u, v), _ in self.boxes]))
        found = []
        for ((at, _, _), _), ray in zip(self.boxes, rays, strict=True):
            up = (turn[at] @ FLU_FROM_OPTICAL @ (ray / np.linalg.norm(ray)))[2]
            found.append(math.degrees(math.asin(-up)) > STEEP_DEG)
        return found

    def used(self, only: list[bool] | None = None) -> float:
        """Return the share of the boxes (of some) that updated robots."""
        chosen = only or [True] * len(self.boxes)
        keys = [key for (key, _), one in zip(self.boxes, chosen, strict=True) if one]
        return sum(key not in self.refused for key in keys) / len(keys) if keys else math.nan

    @property
    def latency(self) -> tuple[float, float] | None:
        """Return the last estimate of the latency and its sigma, s; None: it is not estimated."""
        for result in reversed(self.results):
            for one in result.platform:
                if one.name == "latency":
                    return one.value, one.sigma
        return None

    def objects(self, steep: bool = False) -> Iterator[tuple[str, list[RobotEstimate]]]:
        """Yield class and positions of each object while it stays in view.

        Args:
            steep: only positions of boxes steeper than `STEEP_DEG` below the horizon.
        """
        keys = [key for key, _ in self.boxes]
        wanted = {key for key, one in zip(keys, self.steep, strict=True) if one or not steep}
        for chain in chains(self.boxes):
            found = [self.named[key] for key, _ in chain if key in self.named and key in wanted]
            if found:
                yield chain[0][1], found


def fly(tables: Tables, config: EstimatorConfig) -> Flight:
    """Import and replay a flight."""
    stamps = {row["frame_no"]: stamp(row) for row in tables.rows}
    boxes = [(_key(stamps, box), box["class"]) for box in tables.boxes if box["class"]]
    flight = Flight(tables.rows, boxes)
    measured: dict[int, dict[str, int]] = {}
    update = Tracker.update

    def watched(
        self: Tracker, frame: PosedFrame, points: WaterPoints, local: LocalMap
    ) -> TrackUpdate:
        found = update(self, frame, points, local)
        # The first is the published one: another latency is tried after it.
        measured.setdefault(frame.detections.stamp_ns, found.measured)
        return found

    engine = Estimator(config)
    with tempfile.TemporaryDirectory() as place, patch.object(Tracker, "update", watched):
        bag = Path(place) / "bag"
        write_bag(tables, bag)
        with open_bag([bag]) as opened:
            replay = Replay(opened, config, DetectorConfig(), no_detector, estimator=engine)
            flight.results = list(replay.results())
    flight.misfit = engine.health.fit.ratio
    by_stamp: dict[int, list[Key]] = defaultdict(list)
    for key, _ in boxes:
        by_stamp[key[0]].append(key)
    for result in flight.results:
        for one in (*result.rejections, *result.late):
            flight.refused.add((one.stamp_ns, one.u_px, one.v_px))
        owners = measured.get(result.stamp_ns, {})
        for estimate in result.estimates:
            if estimate.state is State.CONFIRMED and estimate.robot_id in owners:
                flight.named[by_stamp[result.stamp_ns][owners[estimate.robot_id]]] = estimate
    return flight


def _key(stamps: dict[str, int], box: Row) -> Key:
    x, y, width, height = (float(box[k]) for k in ("x_px", "y_px", "width_px", "height_px"))
    return stamps[box["frame_no"]], x + 0.5 * width, y + 0.5 * height


def moored(flight: Flight) -> tuple[Array, Array, Array]:
    """Return distances (n,) of buoys' positions from their medians, m, and squared normalised ones.

    The latter twice: by the published covariance, and without the receiver's offset.
    """
    offset = {
        result.stamp_ns: np.diag([e.sigma**2 for e in result.platform if e.name[:4] == "gnss"])
        for result in flight.results
    }
    apart, whole, rest = [], [], []
    for kind, found in flight.objects(steep=True):
        if kind != MOORED or len(found) < LEAST_POSITIONS:
            continue
        places = np.array([one.position for one in found])
        for one, off in zip(found, places - np.median(places, axis=0), strict=True):
            covariance = one.covariance[:2, :2]
            apart.append(float(np.hypot(*off)))
            whole.append(float(off @ np.linalg.solve(covariance, off)))
            left = covariance - offset[one.stamp_ns]
            values, vectors = np.linalg.eigh(left)
            along = vectors.T @ off
            rest.append(float(np.sum(along**2 / np.maximum(values, LEAST_WIDTH_M**2))))
    return np.array(apart), np.array(whole), np.array(rest)


def line(name: str, flight: Flight) -> list[str]:
    """Return a row of the table."""
    pitches = [float(row["gimbal_pitch_down_deg"]) for row in flight.rows]
    apart, whole, rest = moored(flight)
    names = [len({one.robot_id for one in found}) for _, found in flight.objects()]
    latency = flight.latency
    steep = flight.steep
    cells = [name, f"{min(pitches):.0f} to {max(pitches):.0f}°", str(len(flight.boxes))]
    cells += [f"{100.0 * flight.used():.0f} %"]
    cells += [f"{100.0 * flight.used(steep):.0f} %" if any(steep) else "–"]
    cells += [f"{latency[0]:+.2f} ± {latency[1]:.2f}" if latency else "taken as 0"]
    if len(apart):
        cells += [f"{np.median(apart):.2f}", f"{np.percentile(apart, 90):.2f}"]
        cells += [f"{100.0 * np.mean(one < CHI2_90):.0f} %" for one in (whole, rest)]
    else:
        cells += ["–"] * 4
    cells += [f"{np.mean(names):.2f}" if names else "–", str(max(names, default=0))]
    return [*cells, "–" if math.isnan(flight.misfit) else f"{flight.misfit:.2f}"]


def _halves(one: str) -> tuple[str, str]:
    key, _, text = one.partition("=")
    return key, text


def _value(text: str) -> bool | float | str:
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def main() -> None:
    """Replay all flights and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    folder = Path("../shared/data/real_water/flights")
    parser.add_argument("--flights", type=Path, default=folder, help="folder of the flights")
    parser.add_argument("--only", default="", help="flights whose names contain this")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="a parameter other than the default")  # fmt: skip
    parser.add_argument("--every-row", action="store_true",
                        help="telemetry that repeats itself is sent again")  # fmt: skip
    parser.add_argument("--part", nargs=2, type=float, default=(0.0, 1.0),
                        metavar=("FIRST", "LAST"), help="shares of the time")  # fmt: skip
    parser.add_argument("--backwards", action="store_true", help="time runs backwards")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    config = estimator_config({key: _value(text) for key, text in map(_halves, given.set)})
    rows = []
    for one in sorted(given.flights.iterdir()):
        if given.only in one.name and (one / "boxes.csv").is_file():
            tables = Tables.of(one, given.every_row).part(*given.part)
            rows.append(
                line(one.name, fly(tables.backwards() if given.backwards else tables, config))
            )
            print(" | ".join(rows[-1]), flush=True)
    show(columns(HEADS, rows), given.markdown)


if __name__ == "__main__":
    main()
