# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Result of the estimator for each image: robots, refusals, the origin of `map`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.rejection import Rejection

Array = NDArray[np.float64]


class State(str, Enum):
    """State of a robot's track; only confirmed and coasting ones are published."""

    TENTATIVE = "tentative"
    CONFIRMED = "confirmed"
    COASTING = "coasting"
    LOST = "lost"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True)
class RobotEstimate:
    """One robot's position at one image.

    Attributes:
        stamp_ns: the image's stamp, ns.
        robot_id: `<class>_<n>`, or the label bound to a start.
        class_id: class name as the detector gave it.
        state: confirmed (measured in this image) or coasting (predicted).
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        altitude: of the water under the robot above the ellipsoid, m; NaN if unknown.
        position: (2,) East, North in the frame `map`, m.
        velocity: (2,) East, North, m/s.
        covariance: (4, 4) of East, North, velocity East, velocity North; SI. Includes the
            share of the platform's slowly varying errors.
        last_seen_ns: stamp of the image that measured it last, ns.
        white: (2, 2) part of the position's covariance that the platform's slow errors and doubts
            of any kind have no share in, m²; None where it is not asked for.
    """

    stamp_ns: int
    robot_id: str
    class_id: str
    state: State
    latitude: float
    longitude: float
    altitude: float
    position: Array
    velocity: Array
    covariance: Array
    last_seen_ns: int
    white: Array | None = None

    @property
    def sigma(self) -> float:
        """One sigma of the position along the larger axis, m."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[:2, :2])[-1]))


@dataclass(frozen=True)
class MapDatum:
    """Origin of the local ENU frame `map`: latitude, longitude in rad, altitude in m or NaN."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True)
class PlatformError:
    """A slowly varying error of the platform as estimated by the filter.

    Attributes:
        name: such as heading, see `platform_model.PLATFORM`.
        value: correction to be added to the measured value; m, rad or s.
        sigma: one sigma of it.
    """

    name: str
    value: float
    sigma: float

    @property
    def is_angle(self) -> bool:
        """Whether the value is in rad."""
        return self.name in ("roll", "pitch", "heading")


@dataclass(frozen=True)
class Current:
    """Velocity of all robots that drift with the water and the wind.

    Attributes:
        velocity: (2,) East, North, m/s.
        covariance: (2, 2) of it, m²/s².
    """

    velocity: Array
    covariance: Array


@dataclass(frozen=True)
class FrameResult:
    """Result of one image: estimates ordered by robot_id, and refusals.

    Attributes:
        stamp_ns: the image's stamp, ns.
        frame_id: the image's frame.
        estimates: confirmed and coasting robots.
        rejections: detections that gave no position.
        datum: origin of `map`, None until it is settled.
        pose: the pose used, None if an input was missing.
        timings_ms: milliseconds per stage.
        platform: errors that the filter estimates; empty without measurements.
        boxes: number of boxes in the image.
        used: number of boxes of this and earlier images now known to have updated robots.
        late: boxes of earlier images now known to have updated none (`unconfirmed`).
        current: with which some robots drift; None where none do, or nobody knows.
    """

    stamp_ns: int
    frame_id: str
    estimates: tuple[RobotEstimate, ...]
    rejections: tuple[Rejection, ...]
    datum: MapDatum | None
    pose: CameraPose | None = None
    timings_ms: dict[str, float] = field(default_factory=dict)
    platform: tuple[PlatformError, ...] = ()
    boxes: int = 0
    used: int = 0
    late: tuple[Rejection, ...] = ()
    current: Current | None = None
