# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Truth from a bag (`truth/robots/<id>/fix`, the drone's path) or from a CSV.

Truth is stamped with its time of validity, results with the image's stamp. An image stamped t
shows the scene at t - latency, so truth is moved by the latency to the images' stamps.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.adapters.text_files import read_text
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.bags.tables import Track
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import cut, shown

_MOST_BYTES = 200_000_000
CSV_COLUMNS = ("stamp_ns", "robot_id", "latitude_deg", "longitude_deg")
_ROBOT = re.compile(r"(?P<namespace>.*)/truth/robots/(?P<name>[^/]+)/fix")
_DRONE = re.compile(r".*/truth/fix")
_MEASURED = re.compile(r"(?!.*/(truth|robots)/).*/fix")
_SCENARIO = re.compile(r".*/truth/scenario")
_BOXES = re.compile(r".*/truth/detections")
_FIX = "sensor_msgs/msg/NavSatFix"


@dataclass(frozen=True)
class Truth:
    """True positions, at the stamps of the images that show them.

    Attributes:
        robots: tracks by the truth's own names; empty without truth.
        drone: the drone's path (true, else measured), or None.
        latency_s: shift of truth, s.
        in_view: image stamps at which each robot was truly in view; empty if unknown.
    """

    robots: dict[str, Track] = field(default_factory=dict)
    drone: Track | None = None
    latency_s: float = 0.0
    in_view: dict[str, NDArray[np.int64]] = field(default_factory=dict)


def read_truth(bag: BagReader, latency_s: float | None = None, interval_s: float = 0.0) -> Truth:
    """Read the truth topics of a bag; a bag without them has an empty truth.

    Args:
        bag: open.
        latency_s: of the images; None: that of `truth/scenario`, else 0.
        interval_s: least time between positions of one topic that are read, s. Between them truth
            is interpolated: an acceleration a gives an error of a interval_s² / 8.

    Raises:
        InputError: the bag is damaged.
    """
    names: dict[str, str] = {}
    for topic in bag.topics.values():
        robot = _ROBOT.fullmatch(topic.name)
        if topic.msgtype == _FIX and robot:
            names[topic.name] = robot["name"]
    drone = _drone_topic(bag)
    rows: dict[str, list[tuple[int, float, float]]] = {name: [] for name in names}
    if drone is not None:
        rows[drone] = []
    wanted = set(rows) | {t for t in bag.topics if _SCENARIO.fullmatch(t) or _BOXES.fullmatch(t)}
    stated, seen, images = 0.0, dict[str, list[int]](), list[int]()
    due_ns = dict.fromkeys(rows, 0)
    for recorded in bag.messages(wanted) if wanted else ():
        if recorded.log_ns < due_ns.get(recorded.topic, 0):
            continue
        message = recorded.message()
        if recorded.topic in rows:
            due_ns[recorded.topic] = recorded.log_ns + round(interval_s * 1e9)
            place = nanoseconds(message.header.stamp), message.latitude, message.longitude
            if math.isfinite(message.latitude) and math.isfinite(message.longitude):
                rows[recorded.topic].append(place)
        elif recorded.msgtype == "std_msgs/msg/String":
            stated = _latency(message.data)
        elif recorded.msgtype == "vision_msgs/msg/Detection2DArray":
            images.append(nanoseconds(message.header.stamp))
            for box in message.detections:
                seen.setdefault(str(box.id), []).append(nanoseconds(message.header.stamp))
    late = stated if latency_s is None else latency_s
    robots = {
        name: _within(moved(track(rows[t]), late), images) for t, name in names.items() if rows[t]
    }
    path = track(rows[drone]) if drone is not None and rows[drone] else None
    return Truth(
        dict(sorted(robots.items())),
        None if path is None else moved(path, late),
        late,
        {name: np.array(stamps, dtype=np.int64) for name, stamps in seen.items()},
    )


def read_truth_csv(path: Path, latency_s: float = 0.0) -> Truth:
    """Read a CSV with the columns stamp_ns, robot_id, latitude_deg, longitude_deg, and any others.

    Commas, semicolons or tabs may separate them.

    Raises:
        InputError: the file is missing, lacks a column, or has an invalid number.
    """
    if not path.is_file():
        raise InputError(f"{path} does not exist; give a bag, or a CSV of true positions.")
    lines = read_text(path, _MOST_BYTES).splitlines()
    head = lines[0] if lines else ""
    reader = csv.DictReader(lines, delimiter=max(",;\t", key=head.count))
    try:
        names = list(reader.fieldnames or ())
    except csv.Error as error:
        raise InputError(f"{path}, line 1: {cut(str(error))}.") from error
    missing = [name for name in CSV_COLUMNS if name not in names]
    if missing:
        raise InputError(
            f"{path} lacks the columns {', '.join(missing)}; a table of true positions has "
            f"{', '.join(CSV_COLUMNS)}, and this one "
            f"{', '.join(map(cut, names[:20])) or 'nothing'}."
        )
    rows: dict[str, list[tuple[int, float, float]]] = {}
    try:
        for row in reader:
            rows.setdefault(str(row["robot_id"]), []).append(_csv_row(path, reader.line_num, row))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {cut(str(error))}.") from error
    robots = {name: moved(track(rows[name]), latency_s) for name in sorted(rows)}
    return Truth(robots, None, latency_s)


def track(rows: Sequence[tuple[int, float, float]]) -> Track:
    """Return a track of (stamp in ns, latitude and longitude in degrees), ordered by stamp."""
    ordered = sorted(rows)
    stamps = np.array([row[0] for row in ordered], dtype=np.int64)
    places = np.array([row[1:] for row in ordered]).reshape(-1, 2) * (math.pi / 180.0)
    return Track(stamps, places[:, 0], places[:, 1])


def moved(track_: Track, latency_s: float) -> Track:
    """Return a track moved to the stamps of the images that show it."""
    late_ns = round(latency_s * 1e9)
    return Track(track_.stamps_ns + late_ns, track_.latitude, track_.longitude)


def _within(track_: Track, images: Sequence[int]) -> Track:
    """Return a track without samples before the first and after the last image.

    There are no positions there. One sample on either side is kept for interpolation.
    """
    if not images:
        return track_
    first = max(int(np.searchsorted(track_.stamps_ns, min(images), "right")) - 1, 0)
    last = int(np.searchsorted(track_.stamps_ns, max(images))) + 1
    kept = slice(first, last)
    return Track(track_.stamps_ns[kept], track_.latitude[kept], track_.longitude[kept])


def _drone_topic(bag: BagReader) -> str | None:
    """Return the topic of the drone's true path, else of its measured one if unambiguous."""
    fixes = [t.name for t in bag.topics.values() if t.msgtype == _FIX and t.count]
    true = [name for name in fixes if _DRONE.fullmatch(name)]
    measured = [name for name in fixes if _MEASURED.fullmatch(name)]
    return true[0] if true else measured[0] if len(measured) == 1 else None


def _latency(text: str) -> float:
    """Return the latency that a scenario states; 0 without one."""
    try:
        about: Any = parse_json(text)
        return float(about["camera"]["latency_s"])
    except (ValueError, KeyError, TypeError):
        return 0.0


def _csv_row(path: Path, line: int, row: Mapping[str, str]) -> tuple[int, float, float]:
    stamp = row["stamp_ns"] or ""
    if not re.fullmatch(r"\s*-?\d{1,19}\s*", stamp) or abs(int(stamp)) >= 1 << 63:
        raise InputError(
            f"{path}, line {line}: stamp_ns must be a whole number of nanoseconds, not "
            f"{shown(stamp)}."
        )
    latitude, longitude = (_degrees(path, line, name, row[name] or "") for name in CSV_COLUMNS[2:])
    place = int(stamp), latitude, longitude
    if not (abs(place[1]) <= 90.0 and abs(place[2]) <= 180.0):
        raise InputError(f"{path}, line {line}: {place[1]}, {place[2]} is not on Earth.")
    return place


def _degrees(path: Path, line: int, name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise InputError(
            f"{path}, line {line}: {name} must be a number of degrees, not {shown(text)}."
        ) from error
