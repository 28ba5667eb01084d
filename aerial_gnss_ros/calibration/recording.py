# SPDX-License-Identifier: Apache-2.0
"""Collects what a calibration needs from a replay: all telemetry, and which box is which robot."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from aerial_gnss_ros.core.account import Settled
from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.estimator import Estimator
from aerial_gnss_ros.core.identity import Identity
from aerial_gnss_ros.core.innovation_monitor import InnovationMonitor
from aerial_gnss_ros.core.inputs import Inputs, Lacking
from aerial_gnss_ros.core.joint_geometry import MapFrame, MapPose
from aerial_gnss_ros.core.local_map import LocalMap
from aerial_gnss_ros.core.localize import WaterPoints
from aerial_gnss_ros.core.posing import Posing
from aerial_gnss_ros.core.rejection import Input, Reason
from aerial_gnss_ros.core.tracking import Tracking, TrackUpdate
from aerial_gnss_ros.core.tracks import Tracker
from aerial_gnss_ros.core.values import (
    Array,
    Fix,
    Orientation,
    PosedFrame,
    RobotEstimate,
    Scalar,
)

WHOLE_FLIGHT_S = 1e6


@dataclass(frozen=True)
class Sighting:
    """The robots in one image.

    Attributes:
        stamp_ns: of the image.
        camera: as the image was taken.
        robots: m robot ids.
        pixels: (m, 2) box centres, refraction taken out.
        places: (m, 2) East, North where the tracker has them, m.
    """

    stamp_ns: int
    camera: CameraModel
    robots: tuple[str, ...]
    pixels: Array
    places: Array


class Recording(Estimator):
    """An estimator that remembers: drive it through a replay.

    Args:
        config: the estimator's parameters; corrections in it are applied already.

    Attributes:
        sightings: images with confirmed robots, in order.
        local: the frame `map`, None before the first image.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        config = replace(config, state_file="")
        self.sightings: list[Sighting] = []
        self.local: LocalMap | None = None
        super().__init__(config, _Watched(Tracker(config, Identity(config)), self))
        self._all = Inputs(config, WHOLE_FLIGHT_S)
        self._posing = Posing(config)
        self._frame: MapFrame | None = None

    def add_fix(self, fix: Fix) -> None:
        """Take a position of the drone."""
        super().add_fix(fix)
        self._all.add(Input.FIX, fix)

    def add_attitude(self, attitude: Orientation) -> None:
        """Take an orientation of the body."""
        super().add_attitude(attitude)
        self._all.add(Input.ATTITUDE, attitude)

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Take an orientation of the camera."""
        super().add_gimbal(gimbal)
        self._all.add(Input.GIMBAL, gimbal)

    def add_height(self, height: Scalar) -> None:
        """Take a height of the drone."""
        super().add_height(height)
        self._all.add(Input.HEIGHT, height)

    def add_water_level(self, level: Scalar) -> None:
        """Take a level of the water."""
        super().add_water_level(level)
        self._all.add_level(level)

    def pose(self, scene_ns: int) -> MapPose | None:
        """Return the camera in `map` at the time of a scene; None where telemetry lacks."""
        if self.local is None:
            return None
        if self._frame is None:
            self._frame = MapFrame(self.local)
        samples = self._all.at(scene_ns)
        pose = Reason.NO_FIX if isinstance(samples, Lacking) else self._posing.pose(samples)
        return None if isinstance(pose, Reason) else self._frame.pose(pose)


class _Watched:
    """A tracker whose decisions are written down."""

    def __init__(self, inner: Tracking, recording: Recording) -> None:
        self._inner, self._recording = inner, recording

    @property
    def monitor(self) -> InnovationMonitor:
        return self._inner.monitor

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        update = self._inner.update(frame, points, local)
        self._recording.local = local
        rows = [row for row in update.measured.values() if points.valid[row]]
        if rows:
            ids = {row: name for name, row in update.measured.items()}
            self._recording.sightings.append(
                Sighting(
                    frame.detections.stamp_ns, frame.camera, tuple(ids[row] for row in rows),
                    points.pixels[rows],
                    local.positions(points.latitude[rows], points.longitude[rows]),
                )
            )  # fmt: skip
        return update

    def coast(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        return self._inner.coast(stamp_ns)

    def settled(self) -> Settled:
        return self._inner.settled()

    def end(self) -> None:
        self._inner.end()

    def check(self) -> None:
        self._inner.check()

    def reset(self) -> None:
        self._inner.reset()


def thinned(sightings: list[Sighting], most: int) -> list[Sighting]:
    """Return at most so many sightings, evenly over the recording."""
    if len(sightings) <= most:
        return sightings
    return [sightings[i] for i in np.unique(np.linspace(0, len(sightings) - 1, most, dtype=int))]
