# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Imports a recorded flight with hand-made boxes: two tables become a bag that can be replayed.

python benchmarks/real_water.py FLIGHT BAG [--every-row]

FLIGHT is a folder with `telemetry.csv` (frame_no, t_s, latitude_deg, longitude_deg,
height_above_takeoff_m, compass_heading_deg, gimbal_heading_deg, gimbal_pitch_down_deg,
datetime_utc, width_px, height_px) and `boxes.csv` (frame_no, class, x_px, y_px, width_px,
height_px: left, top and size; an empty class is an image without boxes), as the flights of
SeaDronesSee can be had. Headings count clockwise from north, pitch downward from the horizon. The
drone writes its telemetry once a second or more seldom, and a row repeats what was written last: a
sample is put into the bag where `datetime_utc` changes, or with `--every-row` for each row, as a
driver does that sends the last value again. Roll is not recorded; the gimbal keeps it
at zero.
"""

from __future__ import annotations

import argparse
import csv
import heapq
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import telemetry_fields as fields
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.import_dji import START_NS, Message
from aerial_gnss_ros.bags.writer import RELIABLE, SENSOR, BagWriter
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_rpy,
    quaternion_from_matrix,
    yaw_from_heading,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.detection.base import Detections

FOCAL_PX, FOCAL_WIDTH_PX = 2950.0, 3840.0
"""Focal length at an image width: neither lens nor zoom are recorded."""
DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
Row = dict[str, str]


def camera_of(row: Row) -> CameraModel:
    """Return the camera that is assumed, for the size of a row's image."""
    width, height = int(row["width_px"]), int(row["height_px"])
    focal = FOCAL_PX * width / FOCAL_WIDTH_PX
    matrix = np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0], [0.0, 0.0, 1.0]])
    return CameraModel(width, height, "plumb_bob", matrix, np.zeros(5))


def stamp(row: Row) -> int:
    """Return the stamp of a row, ns."""
    return START_NS + round(float(row["t_s"]) * 1e9)


def gimbal(row: Row) -> Orientation:
    """Return the camera's orientation, FLU in ENU; where its heading is missing, the body's."""
    heading = row["gimbal_heading_deg"] or row["compass_heading_deg"]
    yaw = float(yaw_from_heading(math.radians(float(heading))))
    down = math.radians(float(row["gimbal_pitch_down_deg"]))
    return Orientation(stamp(row), quaternion_from_matrix(matrix_from_rpy(0.0, down, yaw)))


def written(rows: list[Row]) -> list[Row]:
    """Return the rows in which the drone has written a new sample."""
    clocks = ["", *(row["datetime_utc"] for row in rows)]
    return [row for row, before in zip(rows, clocks, strict=False) if row["datetime_utc"] != before]


def telemetry(rows: list[Row]) -> Iterator[Message]:
    """Yield fix, gimbal and height above take-off of some rows."""
    for row in rows:
        at = stamp(row)
        latitude, longitude = (
            math.radians(float(row[f"{k}_deg"])) for k in ("latitude", "longitude")
        )
        fix = Fix(at, latitude, longitude, math.nan)
        yield at, "fix", fields.FIX_TYPE, fields.fix_fields(fix)
        yield at, "gimbal", fields.QUATERNION_TYPE, fields.quaternion_fields(gimbal(row), "enu")
        height = Scalar(at, float(row["height_above_takeoff_m"]))
        yield at, "height", fields.FLOAT_TYPE, fields.float_fields(height)


def images(rows: list[Row], boxes: list[Row]) -> Iterator[Message]:
    """Yield camera and boxes of each image."""
    by_frame: dict[str, list[Row]] = defaultdict(list)
    for box in boxes:
        if box["class"]:
            by_frame[box["frame_no"]].append(box)
    for row in rows:
        at = stamp(row)
        info = fields.camera_info_fields(camera_of(row), at, "camera")
        yield at, "camera/camera_info", fields.CAMERA_INFO_TYPE, info
        yield at, "detections", DETECTIONS_TYPE, _array(at, by_frame[row["frame_no"]])


def _array(at: int, boxes: list[Row]) -> dict[str, Any]:
    names = tuple(sorted({box["class"] for box in boxes}))
    keys = ("x_px", "y_px", "width_px", "height_px")
    corners = np.array([[float(box[key]) for key in keys] for box in boxes]).reshape(-1, 4)
    centred = np.hstack([corners[:, :2] + 0.5 * corners[:, 2:], corners[:, 2:]])
    kinds = np.array([names.index(box["class"]) for box in boxes], dtype=np.int64)
    found = Detections(centred, np.ones(len(boxes)), kinds, names)
    return detection_array(found, header_fields(at, "camera"))


def read(path: Path) -> list[Row]:
    """Return the rows of a table."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@dataclass(frozen=True)
class Tables:
    """The tables of a flight.

    Attributes:
        rows: of its telemetry, one an image.
        samples: those that become samples.
        boxes: of its images.
    """

    rows: list[Row]
    samples: list[Row]
    boxes: list[Row]

    @classmethod
    def of(cls, flight: Path, every_row: bool = False) -> Tables:
        """Read a flight.

        Args:
            flight: folder of the two tables.
            every_row: whether rows that repeat the last telemetry become samples, too.
        """
        rows, boxes = read(flight / "telemetry.csv"), read(flight / "boxes.csv")
        return cls(rows, rows if every_row else written(rows), boxes)

    def part(self, first: float, last: float) -> Tables:
        """Return what happens between two shares of the time, 0 to 1."""
        begin, end = (float(self.rows[i]["t_s"]) for i in (0, -1))

        def inside(row: Row) -> bool:
            return first <= (float(row["t_s"]) - begin) / (end - begin) <= last

        kept = {row["frame_no"] for row in self.rows if inside(row)}
        rows, samples, boxes = (
            [row for row in table if row["frame_no"] in kept]
            for table in (self.rows, self.samples, self.boxes)
        )
        return Tables(rows, samples, boxes)

    def backwards(self) -> Tables:
        """Return the flight as if time ran backwards: latencies change their sign."""
        both = float(self.rows[0]["t_s"]) + float(self.rows[-1]["t_s"])
        rows, samples = (
            [{**row, "t_s": str(both - float(row["t_s"]))} for row in reversed(table)]
            for table in (self.rows, self.samples)
        )
        return Tables(rows, samples, self.boxes[::-1])


def write_bag(tables: Tables, bag: Path) -> dict[str, int]:
    """Write a flight's bag; return the number of messages by topic.

    Args:
        tables: of the flight.
        bag: to write.

    Raises:
        OutputError: the bag exists already, or cannot be written.
    """
    sent, shown = telemetry(tables.samples), images(tables.rows, tables.boxes)
    merged = heapq.merge(sent, shown, key=lambda one: one[0])
    with BagWriter(bag) as writer:
        for at, topic, kind, values in merged:
            writer.write(topic, kind, at, values, RELIABLE if topic == "detections" else SENSOR)
        return dict(writer.counts)


def main() -> None:
    """Import one flight."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("flight", type=Path, metavar="FLIGHT", help="folder of the two tables")
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag to write")
    parser.add_argument("--every-row", action="store_true", help="a sample for each row")
    given = parser.parse_args()
    counts = write_bag(Tables.of(given.flight, given.every_row), given.bag)
    for topic, count in sorted(counts.items()):
        print(f"{count:6d} {topic}")


if __name__ == "__main__":
    main()
