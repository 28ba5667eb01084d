# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the result folder of a replay: tables, maps, and the result topics as a bag."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from aerial_gnss_ros.adapters.map_frame import OnWater, frames
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.results import (
    MAP_DATUM,
    covariance_parts,
    position_update,
    result_messages,
)
from aerial_gnss_ros.adapters.transforms import course_transforms, earth_transform
from aerial_gnss_ros.bags.detect import DETECTIONS_TYPE
from aerial_gnss_ros.bags.maps import geojson, gpx, kml
from aerial_gnss_ros.bags.tables import POSITION_COLUMNS, Track
from aerial_gnss_ros.bags.typestore import GEOJSON_TYPE
from aerial_gnss_ros.bags.writer import LATCHED, RELIABLE, BagVersion, BagWriter
from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.core.estimation.position_updates import PositionUpdates
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.rejection import Rejection
from aerial_gnss_ros.text.plain_text import spreadsheet_cell

if TYPE_CHECKING:
    from typing_extensions import Self

PLATFORM_COLUMNS = ("stamp_ns", "error", "value", "sigma")
PLATFORM_STEP_NS = 500_000_000
"""Interval of rows in platform.csv: platform errors drift over minutes."""
OVERVIEW_STEP_NS = 200_000_000
"""Least time between two overviews in the bag: enough for `aerial-gnss view`."""
REJECTED_COLUMNS = ("stamp_ns", "reason", "u_px", "v_px")


class ResultFolder:
    """Collects results and writes them into an existing folder; use as a context manager.

    Args:
        folder: an existing folder.
        namespace: of the result topics.
        config: of the map frame.
        version: of the bag's files, see `BagWriter`.
        updates: picks the samples for other filters; None: none are written.
        with_bag: write the result topics as a bag.
        overview: makes the JSON text of a result's overview; None: none is written.
    """

    def __init__(
        self,
        folder: Path,
        namespace: str = "",
        config: MapConfig | None = None,
        version: BagVersion | None = None,
        updates: PositionUpdates | None = None,
        with_bag: bool = True,
        overview: Callable[[FrameResult], str] | None = None,
    ) -> None:
        self._overview, self._overview_ns = overview, 0
        self._config = config or MapConfig()
        self._updates = updates
        self._frames = frames(self._config, namespace)
        self._on_water = OnWater(self._frames)
        self._folder = folder
        self._bag: BagWriter | None = None
        if with_bag:
            self._bag = BagWriter(
                folder / "bag", compress=True, namespace=namespace, version=version
            )
        self._estimates: list[RobotEstimate] = []
        self._rejections: list[Rejection] = []
        self._poses: list[CameraPose] = []
        self._platform: list[tuple[int, PlatformError]] = []
        self._datum = ""

    def __enter__(self) -> Self:
        """Begin the bag."""
        if self._bag is not None:
            self._bag.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the bag and write the tables and maps, unless something failed."""
        if self._bag is not None:
            if kind is None and self._estimates:
                last_ns = max(estimate.stamp_ns for estimate in self._estimates)
                fields = {"geojson": geojson(self._tracks())}
                self._bag.write("robots/geojson", GEOJSON_TYPE, last_ns, fields, LATCHED)
            self._bag.__exit__(kind, error, trace)
        if kind is None:
            self._write_tables()

    def add(self, result: FrameResult) -> None:
        """Add one image's result."""
        self._estimates += result.estimates
        self._rejections += (*result.rejections, *result.late)
        self._poses += [result.pose] if result.pose is not None else []
        last = self._platform[-1][0] if self._platform else None
        if last is None or abs(result.stamp_ns - last) >= PLATFORM_STEP_NS:
            self._platform += [(result.stamp_ns, error) for error in result.platform]
        if self._bag is not None:
            self._write(self._bag, self._on_water.leveled(result))
            self._write_overview(self._bag, result)

    def _write(self, bag: BagWriter, result: FrameResult) -> None:
        """Write the messages of one result, the origin and `earth` only when they change."""
        messages = result_messages(result, self._frames)
        moved = False
        if result.datum is not None:
            place = repr(result.datum)  # NaN equals NaN here
            moved, self._datum = place != self._datum, place
        if not moved:
            messages = [one for one in messages if one.topic != MAP_DATUM]
        for one in messages:
            bag.write(one.topic, one.msgtype, result.stamp_ns, one.fields, LATCHED)
        for sample in () if self._updates is None else self._updates.due(result):
            one = position_update(sample, result.datum, self._frames)
            bag.write(one.topic, one.msgtype, result.stamp_ns, one.fields, RELIABLE)
        for estimate in result.estimates:
            for one in covariance_parts(estimate, result.datum, self._frames):
                bag.write(one.topic, one.msgtype, result.stamp_ns, one.fields, RELIABLE)
        if moved and result.datum is not None and self._config.publish_earth_tf:
            earth = earth_transform(result.stamp_ns, result.datum, self._frames)
            bag.write(earth.topic, earth.msgtype, result.stamp_ns, earth.fields, LATCHED)
        found = course_transforms(result, self._frames) if self._config.publish_tf else None
        if found is not None:
            bag.write(found.topic, found.msgtype, result.stamp_ns, found.fields, RELIABLE)

    def _write_overview(self, bag: BagWriter, result: FrameResult) -> None:
        if self._overview is None or abs(result.stamp_ns - self._overview_ns) < OVERVIEW_STEP_NS:
            return
        self._overview_ns = result.stamp_ns
        bag.write(*OVERVIEW, result.stamp_ns, {"data": self._overview(result)}, LATCHED)

    def add_detections(self, log_ns: int, fields: dict[str, Any]) -> None:
        """Record the boxes of an image, so that the next replay needs no detector."""
        if self._bag is not None:
            self._bag.write("detections", DETECTIONS_TYPE, log_ns, fields, RELIABLE)

    @property
    def drone(self) -> Track:
        """The camera's own path."""
        poses = sorted(self._poses, key=lambda pose: pose.stamp_ns)
        return Track(
            np.array([pose.stamp_ns for pose in poses], dtype=np.int64),
            np.array([pose.latitude for pose in poses], dtype=np.float64),
            np.array([pose.longitude for pose in poses], dtype=np.float64),
        )

    def _tracks(self) -> dict[str, list[RobotEstimate]]:
        """Return the estimates by robot, sorted by label and stamp."""
        tracks: dict[str, list[RobotEstimate]] = {}
        for estimate in sorted(self._estimates, key=lambda e: (e.robot_id, e.stamp_ns)):
            tracks.setdefault(estimate.robot_id, []).append(estimate)
        return tracks

    def _write_tables(self) -> None:
        estimates = sorted(self._estimates, key=lambda e: (e.stamp_ns, e.robot_id))
        rejections = sorted(self._rejections, key=lambda r: r.stamp_ns)
        tracks = self._tracks()
        for name, text in {
            "positions.csv": _table(POSITION_COLUMNS, map(position_row, estimates)),
            "rejected.csv": _table(REJECTED_COLUMNS, map(rejection_row, rejections)),
            "platform.csv": _table(PLATFORM_COLUMNS, map(platform_row, self._platform)),
            "positions.geojson": geojson(tracks),
            "positions.gpx": gpx(tracks),
            "positions.kml": kml(tracks),
        }.items():
            (self._folder / name).write_text(text, encoding="utf-8", newline="\n")


def position_row(estimate: RobotEstimate) -> list[str]:
    """Return a row of positions.csv; ten decimals of a degree are a hundredth of a millimetre."""
    covariance = estimate.covariance
    return [
        str(estimate.stamp_ns),
        estimate.robot_id,
        spreadsheet_cell(estimate.class_id),
        f"{math.degrees(estimate.latitude):.10f}",
        f"{math.degrees(estimate.longitude):.10f}",
        f"{estimate.altitude:.4f}",
        f"{covariance[0, 0]:.9g}",
        f"{covariance[0, 1]:.9g}",
        f"{covariance[1, 1]:.9g}",
        f"{estimate.velocity[0]:.6f}",
        f"{estimate.velocity[1]:.6f}",
        str(estimate.state),
    ]


def platform_row(row: tuple[int, PlatformError]) -> list[str]:
    """Return a row of platform.csv: corrections to be added to measurements, m, rad or s."""
    stamp_ns, error = row
    return [str(stamp_ns), spreadsheet_cell(error.name), f"{error.value:.9g}", f"{error.sigma:.9g}"]


def rejection_row(rejection: Rejection) -> list[str]:
    """Return a row of rejected.csv."""
    pixel = [f"{rejection.u_px:.3f}", f"{rejection.v_px:.3f}"]
    return [str(rejection.stamp_ns), str(rejection.reason), *pixel]


def _table(columns: Sequence[str], rows: Iterable[list[str]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")  # quotes a class name with a comma
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()
