# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the page shows at one time: the overview, robots that are lost, and paths so far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Point = list[float]
"""Seconds since the beginning, latitude, longitude in deg, and 1 if measured, 0 if predicted."""

STEP_S = 0.5
"""Least time between two points of a path."""
MOST_POINTS = 2000
"""Of one path; a longer one keeps every second point and goes on with twice the step."""
SHOWN_LOST_S = 900.0
"""Robots lost longer ago than that are left out."""
MARGIN_PX = 8.0
"""By how much a robot's pixel may lie beside its box: the estimate is smoothed, the box is not."""


class Paths:
    """Paths of the drone, or of all of a fleet, and of all robots.

    Args:
        begin_ns: the time from which seconds count, ns.
    """

    def __init__(self, begin_ns: int) -> None:
        self.begin_ns = begin_ns
        self._robots: dict[str, _Path] = {}
        self._drone = _Path()
        self._drones: dict[str, _Path] = {}

    def add(self, fields: Mapping[str, Any]) -> None:
        """Add an overview."""
        time_s = (fields["stamp_ns"] - self.begin_ns) * 1e-9
        drone = fields["drone"]
        if drone is not None:
            self._drone.add([time_s, *drone["place"], 1])
        for one in fields.get("drones", ()):
            self._drones.setdefault(one["name"], _Path()).add([time_s, *one["place"], 1])
        for robot in fields["robots"]:
            point = [time_s, *robot["place"], int(robot["state"] == "confirmed")]
            self._robots.setdefault(robot["id"], _Path(robot["class"])).add(point)

    def robots(self) -> dict[str, list[Point]]:
        """Return the points of each robot's path."""
        return {name: path.points for name, path in self._robots.items()}

    def drone(self) -> list[Point]:
        """Return the points of the drone's path."""
        return self._drone.points

    def drones(self) -> dict[str, list[Point]]:
        """Return the points of the path of each drone of a fleet."""
        return {name: path.points for name, path in self._drones.items()}

    def lost(self, fields: Mapping[str, Any], now_ns: int) -> list[dict[str, Any]]:
        """Return the robots that were known before an overview and are not in it.

        Each is at its last place, with state `lost` and without a covariance: nothing bounds where
        it is now.

        Args:
            fields: of the overview.
            now_ns: the time shown, ns.
        """
        present = {robot["id"] for robot in fields["robots"]}
        begin_s = (now_ns - self.begin_ns) * 1e-9
        found = []
        for name, path in self._robots.items():
            last = None if name in present else path.before(begin_s)
            if last is None:
                continue
            seen_ns = self.begin_ns + round(last[0] * 1e9)
            if now_ns - seen_ns <= SHOWN_LOST_S * 1e9:
                found.append(
                    {
                        "id": name,
                        "class": path.class_id,
                        "state": "lost",
                        "place": last[1:3],
                        "covariance_m2": None,
                        "velocity_mps": None,
                        "last_seen_ns": seen_ns,
                        "depth_m": None,
                        "pixel": None,
                    }
                )
        return found


class _Path:
    """Points of one path, and the class of its robot."""

    def __init__(self, class_id: str = "") -> None:
        self.points: list[Point] = []
        self.class_id = class_id
        self._step_s = STEP_S

    def add(self, point: Point) -> None:
        """Add a point unless the last one is nearer in time than the step."""
        if self.points and 0.0 <= point[0] - self.points[-1][0] < self._step_s:
            return
        self.points.append(point)
        if len(self.points) > MOST_POINTS:
            self.points = self.points[::2]
            self._step_s *= 2.0

    def before(self, time_s: float) -> Point | None:
        """Return the last measured point not after a time, or the last one; None before all."""
        found = None
        for point in self.points:
            if point[0] > time_s:
                break
            if point[3] or found is None:
                found = point
        return found


@dataclass(frozen=True)
class Box:
    """A box in an image.

    Attributes:
        x: column of the centre, px; the others likewise.
        y: row of the centre.
        width: along the row.
        height: along the column.
        score: 0 to 1.
        class_id: the detector's class name.
    """

    x: float
    y: float
    width: float
    height: float
    score: float
    class_id: str


def boxes_of(message: Any) -> list[Box]:
    """Return the boxes of a vision_msgs/Detection2DArray; those without a result are left out."""
    found = []
    for one in message.detections:
        if not one.results:
            continue
        centre, best = one.bbox.center.position, one.results[0].hypothesis
        x, y, score = float(centre.x), float(centre.y), float(best.score)
        width, height = float(one.bbox.size_x), float(one.bbox.size_y)
        if all(map(math.isfinite, (x, y, width, height, score))):
            found.append(Box(x, y, width, height, score, str(best.class_id)))
    return found


def named_boxes(boxes: Sequence[Box], robots: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return boxes with the names of the robots that are in them.

    A robot is given to the box whose centre is nearest to its pixel, nearest pairs first, if the
    pixel lies in the box or beside it by `MARGIN_PX`.

    Args:
        boxes: of an image.
        robots: of the overview of the same image.
    """
    pairs = []
    for i, box in enumerate(boxes):
        for robot in robots:
            if robot["pixel"] is None or robot["state"] != "confirmed":
                continue
            du, dv = robot["pixel"][0] - box.x, robot["pixel"][1] - box.y
            if abs(du) <= 0.5 * box.width + MARGIN_PX and abs(dv) <= 0.5 * box.height + MARGIN_PX:
                pairs.append((math.hypot(du, dv), i, robot["id"]))
    names: dict[int, str] = {}
    for _, i, name in sorted(pairs):
        if i not in names and name not in names.values():
            names[i] = name
    return [
        {
            "x": round(box.x, 1),
            "y": round(box.y, 1),
            "width": round(box.width, 1),
            "height": round(box.height, 1),
            "score": round(box.score, 2),
            "class": box.class_id,
            "name": names.get(i),
        }
        for i, box in enumerate(boxes)
    ]
