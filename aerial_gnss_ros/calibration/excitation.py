# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Excitation of a flight: errors with the same effect throughout cannot be separated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.motion import Poses

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Excitation:
    """Variation of distance, direction, tilt and speed during a flight.

    Attributes:
        travelled_m: length of the drone's horizontal path.
        speed_mps: root mean square of its velocity.
        turned_dps: root mean square of the camera's angular rate, deg/s.
        heights_m: lowest and highest.
        directions_deg: range of bearings, in sectors of 10 deg, from which one robot was seen.
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

    def lines(self) -> list[str]:
        """Return a description, one sentence a line."""
        return [
            (
                f"the drone flew {self.travelled_m:.0f} m ({self.speed_mps:.1f} m/s), "
                f"{self.heights_m[0]:.1f} to {self.heights_m[1]:.1f} m high; the camera turned "
                f"{self.turned_dps:.1f} deg/s"
            ),
            (
                f"robots were seen {self.ranges_m[0]:.0f} to {self.ranges_m[1]:.0f} m away, "
                f"{self.tilts_deg[0]:.0f} to {self.tilts_deg[1]:.0f} deg below the horizon, one "
                f"of them over a range of bearings of {self.directions_deg:.0f} deg"
            ),
        ]


def excitation(
    poses: Poses, images: NDArray[np.intp], robots: NDArray[np.intp], places: Array
) -> Excitation:
    """Return the excitation of a recording.

    Args:
        poses: of the images.
        images: (n,) image of each box.
        robots: (n,) robot of each box.
        places: (n, 2) East, North positions of the robots, m.
    """
    known = poses.known
    way = np.diff(poses.position[known, :2], axis=0)
    offsets = places - poses.position[images, :2]
    away, height = np.hypot(*offsets.T), poses.position[images, 2]
    down = np.degrees(np.arctan2(height, away))
    bearing = np.degrees(np.arctan2(offsets[:, 1], offsets[:, 0]))
    compass = max(_spread(bearing[robots == robot]) for robot in np.unique(robots))
    return Excitation(
        float(np.sum(np.hypot(*way.T))),
        float(np.sqrt(np.mean(np.sum(poses.velocity[known] ** 2, axis=1)))),
        math.degrees(float(np.sqrt(np.mean(np.sum(poses.turning[known] ** 2, axis=1))))),
        (float(poses.position[known, 2].min()), float(poses.position[known, 2].max())),
        compass,
        (float(down.min()), float(down.max())),
        (float(away.min()), float(away.max())),
    )


def _spread(angles: Array) -> float:
    """Return the range of bearings, in sectors of 10 deg, that angles cover, deg."""
    return 10.0 * len(np.unique(np.floor(angles / 10.0)))
