# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of a fleet's drones: where each was, what it saw, how it agrees, and names."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.bags.results import PLATFORM_STEP_NS
from aerial_gnss_ros.bags.tables import Track
from aerial_gnss_ros.core.fleet.agreement import DroneReport
from aerial_gnss_ros.core.fleet.publication import FleetUpdate
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import cut

DRONE_COLUMNS = (
    "stamp_ns", "drone", "agreement", "shared_robots", "offset_east_m", "offset_north_m",
    "sigma_east_m", "sigma_north_m", "disagrees", "fault", "latitude_deg", "longitude_deg",
    "sees", "clock_ahead_s", "clock_sigma_s",
)  # fmt: skip
NAME_COLUMNS = ("robot_id", "drone", "drone_robot_id", "first_stamp_ns", "last_stamp_ns", "images")


@dataclass
class NameUse:
    """During which images a drone's own name stood for a fleet's one.

    Attributes:
        first_ns: stamp of the first image, ns.
        last_ns: of the last one.
        images: number of them.
    """

    first_ns: int
    last_ns: int
    images: int = 0


@dataclass(frozen=True)
class DroneImage:
    """What there is to say of a drone at one image.

    Attributes:
        report: the fleet's.
        latitude: of the camera by telemetry, rad.
        longitude: likewise.
        sees: the fleet's names of the robots that boxes of the image show.
    """

    report: DroneReport
    latitude: float
    longitude: float
    sees: tuple[str, ...]


@dataclass
class DroneTables:
    """What a replay says of each drone.

    Attributes:
        images: of all drones in the order of time.
        names: by the fleet's name, the drone, and its own name.
    """

    images: list[DroneImage] = field(default_factory=list)
    names: dict[tuple[str, str, str], NameUse] = field(default_factory=dict)

    @property
    def reports(self) -> list[DroneReport]:
        """Reports of all images."""
        return [image.report for image in self.images]

    def add(self, update: FleetUpdate, seen: Sighting) -> None:
        """Take in the result of one sighting."""
        report, pose = update.report, seen.pose
        sees = sorted({update.names[label] for label in seen.labels if label in update.names})
        self.images.append(DroneImage(report, pose.latitude, pose.longitude, tuple(sees)))
        for own, name in update.names.items():
            fresh = NameUse(report.stamp_ns, report.stamp_ns)
            use = self.names.setdefault((name, report.drone, own), fresh)
            use.last_ns, use.images = report.stamp_ns, use.images + 1

    def write(self, folder: Path) -> None:
        """Write drones.csv, every half second, and names.csv."""
        rows: list[list[str]] = []
        last: dict[str, int] = {}
        for image in self.images:
            one = image.report
            if one.stamp_ns - last.get(one.drone, -PLATFORM_STEP_NS) < PLATFORM_STEP_NS:
                continue
            last[one.drone] = one.stamp_ns
            rows.append(_drone_row(image))
        _write(folder / "drones.csv", DRONE_COLUMNS, rows)
        names = [
            [*key, str(use.first_ns), str(use.last_ns), str(use.images)]
            for key, use in sorted(self.names.items())
        ]
        _write(folder / "names.csv", NAME_COLUMNS, names)


def _drone_row(image: DroneImage) -> list[str]:
    one = image.report
    figures = [f"{value:.4f}" for value in (*one.offset, *one.offset_sigma)]
    place = [f"{math.degrees(value):.9f}" for value in (image.latitude, image.longitude)]
    return [
        str(one.stamp_ns), one.drone, f"{one.agreement:.4f}", str(one.shared), *figures,
        str(int(one.disagrees)), one.fault, *place, " ".join(image.sees),
        f"{one.clock.ahead_s:.4f}", f"{one.clock.sigma_s:.4f}",
    ]  # fmt: skip


def _write(path: Path, columns: Iterable[str], rows: Iterable[list[str]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    path.write_text(text.getvalue(), encoding="utf-8", newline="\n")


@dataclass(frozen=True)
class DroneFlight:
    """Where a drone was, and what it saw.

    Attributes:
        path: of its camera, each half second.
        seen: stamps of these at which each robot was in a box, by the fleet's name, ns.
    """

    path: Track
    seen: dict[str, NDArray[np.int64]]


def read_drones(path: Path) -> dict[str, DroneFlight]:
    """Read drones.csv; an absent file, as that of a single drone, or one without paths has none.

    Raises:
        InputError: the file is not such a table.
    """
    if not path.is_file():
        return {}
    rows: dict[str, list[dict[str, str]]] = {}
    for _, row in table_rows(path, DRONE_COLUMNS[:2], "the drones.csv of a replay"):
        if row.keys() >= {"latitude_deg", "longitude_deg", "sees"}:  # older tables have no paths
            rows.setdefault(row["drone"], []).append(row)
    try:
        return {name: _flight(of) for name, of in sorted(rows.items())}
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{path} has an invalid row: {cut(str(error))}.") from error


def _flight(rows: list[dict[str, str]]) -> DroneFlight:
    stamps = np.array([int(row["stamp_ns"]) for row in rows], dtype=np.int64)
    places = np.array([[float(row[f"{kind}_deg"]) for kind in ("latitude", "longitude")]
                       for row in rows])  # fmt: skip
    if not (np.abs(places) <= (90.0, 360.0)).all():
        raise ValueError("a drone is not on Earth")
    seen: dict[str, list[int]] = {}
    for stamp_ns, row in zip(stamps.tolist(), rows, strict=True):
        for name in row["sees"].split():
            seen.setdefault(name, []).append(stamp_ns)
    path = Track(stamps, np.radians(places[:, 0]), np.radians(places[:, 1]))
    return DroneFlight(path, {name: np.array(of, np.int64) for name, of in sorted(seen.items())})
