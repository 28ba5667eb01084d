# SPDX-License-Identifier: Apache-2.0
"""What a flight could tell, in words: how it excited the errors, and what to fly next."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aerial_gnss_ros.calibration.fit import Fit
from aerial_gnss_ros.calibration.poses import PoseTable
from aerial_gnss_ros.calibration.recording import Recording

ORBIT = "orbit a still robot once, at a distance of one to two heights, looking at it"
_ADVICE = {
    "latency": "fly past a still robot to and fro at 3 m/s or more: what comes late leads one way "
    "on the way out and the other way on the way back",
    "heading": ORBIT,
    "gimbal_pitch": ORBIT,
    "gimbal_roll": ORBIT,
    "height": ORBIT,
    "focal": "hover beside a still robot and tilt the gimbal up and down for half a minute, so "
    "that the robot crosses the image from top to bottom and back",
}
_AGAIN = {
    "gimbal_pitch": "at twice the distance, which tells pitch from height",
    "gimbal_roll": "with the robot at the left of the image, then at the right",
    "height": "at half the height, which tells height from pitch",
}


@dataclass(frozen=True)
class Excitation:
    """How much a flight varied.

    Attributes:
        travelled_m: horizontal way of the drone.
        speed_mps: root mean square of its velocity.
        turned_dps: root mean square of the camera's turning, deg/s.
        heights_m: lowest and highest.
        directions_deg: from how many degrees of the compass the best seen robot was looked at.
        tilts_deg: least and greatest angle below the horizon at which robots were seen.
        ranges_m: least and greatest horizontal distance to robots.
    """

    travelled_m: float
    speed_mps: float
    turned_dps: float
    heights_m: tuple[float, float]
    directions_deg: float
    tilts_deg: tuple[float, float]
    ranges_m: tuple[float, float]

    def words(self) -> list[str]:
        """Return it as lines."""
        return [
            (
                f"the drone flew {self.travelled_m:.0f} m ({self.speed_mps:.1f} m/s), "
                f"{self.heights_m[0]:.1f} to {self.heights_m[1]:.1f} m high; the camera turned "
                f"{self.turned_dps:.1f} deg/s"
            ),
            (
                f"robots were seen {self.ranges_m[0]:.0f} to {self.ranges_m[1]:.0f} m away, "
                f"{self.tilts_deg[0]:.0f} to {self.tilts_deg[1]:.0f} deg below the horizon, one of "
                f"them from {self.directions_deg:.0f} deg of the compass"
            ),
        ]


def excitation(recording: Recording) -> Excitation:
    """Return how much a recording varied."""
    sightings = recording.sightings
    table = PoseTable(recording)
    stamps = np.array([one.stamp_ns for one in sightings], dtype=np.int64)
    poses = table.at(stamps)
    known = np.flatnonzero(poses.known)
    place = poses.position[known]
    way = float(np.sum(np.hypot(*np.diff(place[:, :2], axis=0).T))) if len(known) > 1 else 0.0
    seen: dict[str, list[tuple[float, float, float]]] = {}
    for i in known:
        position = poses.position[i]
        for name, robot in zip(sightings[i].robots, sightings[i].places, strict=True):
            east, north = robot - position[:2]
            away = math.hypot(east, north)
            down = math.degrees(math.atan2(position[2], away))
            seen.setdefault(name, []).append((math.atan2(north, east), down, away))
    rows = np.array([row for found in seen.values() for row in found]).reshape(-1, 3)
    compass = max((_spread([row[0] for row in found]) for found in seen.values()), default=0.0)
    return Excitation(
        way,
        float(np.sqrt(np.mean(np.sum(poses.velocity[known] ** 2, axis=1)))),
        math.degrees(float(np.sqrt(np.mean(np.sum(poses.turning[known] ** 2, axis=1))))),
        (float(place[:, 2].min()), float(place[:, 2].max())),
        compass,
        (float(rows[:, 1].min()), float(rows[:, 1].max())),
        (float(rows[:, 2].min()), float(rows[:, 2].max())),
    )


def advice(fit: Fit) -> list[str]:
    """Return what to fly next, one sentence for each way; none where all is determined."""
    wanted: dict[str, list[str]] = {}
    for name in fit.names:
        if not fit.determined(name):
            wanted.setdefault(_ADVICE[name], []).append(name)
    return [_sentence(what, names) for what, names in wanted.items()]


def _sentence(what: str, names: list[str]) -> str:
    words = [name.replace("_", " ") for name in names]
    listed = " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
    more = [f"once more {_AGAIN[name]}" for name in names if name in _AGAIN]
    return f"for {listed}: {'; then '.join([what, *more])}."


def _spread(angles: list[float]) -> float:
    """Return the degrees of the compass, in sectors of 10 deg, that angles fall into."""
    return 10.0 * len({math.floor(math.degrees(angle) / 10.0) for angle in angles})
