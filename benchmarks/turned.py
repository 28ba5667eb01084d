# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights whose camera or telemetry turns by itself: what `runaway` and `glitches` share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Cell
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, State
from aerial_gnss_ros.evaluation.bound import TrueFrame
from aerial_gnss_ros.simulation.experiment import LEAD_S, Experiment
from aerial_gnss_ros.simulation.flight import Flight, Motion
from aerial_gnss_ros.simulation.sensors import Sensors

Array = NDArray[np.float64]

AXES = {"roll": 0, "pitch": 1, "yaw": 2}
CONFIDENT = 13.8
"""Squared distance that one in a thousand of a planar normal law exceeds."""
STATED = {"noise.robot_acceleration": 0.05, "tracks.max_speed": 1.5}
"""The defaults, also where robots stay: the filter does not know that they do."""


@dataclass(frozen=True)
class Turned:
    """A flight whose camera is turned about an axis, by an angle (rad) at each time (s)."""

    flight: Flight
    axis: str
    angle: Callable[[Array], Array]

    @property
    def origin(self) -> MapDatum:
        """As the flight's own."""
        return self.flight.origin

    @property
    def duration_s(self) -> float:
        """As the flight's own."""
        return self.flight.duration_s

    @property
    def words(self) -> str:
        """As the flight's own."""
        return self.flight.words

    def sample(self, t: ArrayLike) -> Motion:
        """Return the motion with the camera turned."""
        motion = self.flight.sample(t)
        turned = motion.enu_from_camera.copy()
        for i, angle in enumerate(self.angle(motion.t)):
            axis = error_axes(turned[i])[:, AXES[self.axis]]
            turned[i] = rotation_matrix(angle * axis) @ turned[i]
        return replace(motion, enu_from_camera=turned)


def tell(made: Experiment, flight: Flight, seed: int) -> None:
    """Let a flight's telemetry report another flight; the camera shows its own.

    Args:
        made: changed in place.
        flight: which telemetry reports.
        seed: of telemetry's errors.
    """
    margin = LEAD_S + abs(made.clock.latency_s)
    span = -margin, made.flight.duration_s + margin
    made.sensors = Sensors(flight, made.sensors_plan, seed, *span)


def errors(
    result: FrameResult, frame: TrueFrame, own: dict[str, int]
) -> list[tuple[int, float, float, float]]:
    """Return robot, error (m), sigma (m), squared distance of each measured position of an image.

    Args:
        result: of the image.
        frame: its truth.
        own: the robot of each name; a new one's is whichever is nearest.
    """
    found = []
    for one in result.estimates:
        if one.state is not State.CONFIRMED:
            continue
        apart = one.position - frame.positions
        nearest = int(np.argmin(np.linalg.norm(apart, axis=1)))
        robot = own.get(one.robot_id, nearest)
        P, error = one.covariance[:2, :2], apart[robot]
        squared = float(error @ np.linalg.solve(P, error))
        sigma = math.sqrt(0.5 * float(np.trace(P)))
        found.append((robot, float(np.hypot(*error)), sigma, squared))
    return found


def cell_of(flight: str, motion: str) -> Cell:
    """Return the cell of a flight, such as `hover 30`, over robots still or moving."""
    family, height = flight.split()
    return Cell(family, float(height), "rtk", motion == "moving")


def arguments(words: str, robots: str, flights: str, axes: str) -> argparse.ArgumentParser:
    """Return the options that both tables have.

    Args:
        words: of the program; the first line is told.
        robots: how many by default, and
        flights: which, and
        axes: about which.
    """
    parser = argparse.ArgumentParser(description=words.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="flights of each kind (default 1)")
    parser.add_argument("--first-seed", type=int, default=0, help="the first one (default 0)")
    parser.add_argument("--axes", default=axes, help="of yaw, pitch, roll")
    parser.add_argument("--robots", default=robots, help="how many, comma separated")
    parser.add_argument("--flights", default=flights, help="families")
    parser.add_argument("--motion", default="still,moving", help="of still, moving")
    parser.add_argument("--markdown", type=Path, help="write the table here too")
    return parser
