# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The values that pass between adapters, core and outputs; none knows a message type."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from aerial_gnss_ros.core.camera import CameraModel
    from aerial_gnss_ros.core.rejection import Rejection

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fix:
    """The drone's GNSS position.

    Attributes:
        stamp_ns: time of validity, ns.
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        altitude: m in the datum that `fix.altitude_datum` names; NaN when unknown.
        covariance: (3, 3) East, North, Up in m², or None when the message gives none.
        valid: False when the receiver reports no fix (NavSatFix status -1).
    """

    stamp_ns: int
    latitude: float
    longitude: float
    altitude: float
    covariance: Array | None = None
    valid: bool = True


@dataclass(frozen=True)
class Orientation:
    """Body FLU or camera FLU relative to the frame that the input's reference names.

    Attributes:
        stamp_ns: time of validity, ns.
        quaternion: (4,) x, y, z, w.
        reference: of this sample, where the message itself says it (`earth`, `heading`, `body`);
            empty: as the configuration says.
    """

    stamp_ns: int
    quaternion: Array
    reference: str = ""


@dataclass(frozen=True)
class Scalar:
    """Height of the drone or level of the water.

    Attributes:
        stamp_ns: time of validity, ns.
        value: m, up positive.
    """

    stamp_ns: int
    value: float


@dataclass(frozen=True)
class DetectionFrame:
    """All boxes found in one image.

    Attributes:
        stamp_ns: the image's stamp, ns.
        frame_id: the image's frame, copied.
        centers: (n, 2) box centres u, v in pixels of the source image.
        sizes: (n, 2) box widths and heights, px.
        scores: (n,) 0 to 1.
        class_ids: n class names.
    """

    stamp_ns: int
    frame_id: str
    centers: Array
    sizes: Array
    scores: Array
    class_ids: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.class_ids)

    def keep(self, mask: NDArray[np.bool_]) -> DetectionFrame:
        """Return the detections where `mask` (n,) is true."""
        names = tuple(name for name, kept in zip(self.class_ids, mask, strict=True) if kept)
        return DetectionFrame(
            self.stamp_ns,
            self.frame_id,
            self.centers[mask],
            self.sizes[mask],
            self.scores[mask],
            names,
        )


@dataclass(frozen=True)
class CameraPose:
    """Where the camera was and how it stood at the time of the scene.

    Attributes:
        stamp_ns: time of the scene (image stamp less `camera.latency_s`), ns.
        latitude: of the camera itself (lever arm applied), rad, WGS84.
        longitude: rad, WGS84.
        height: camera above the water, m.
        altitude: camera above the WGS84 ellipsoid, m; NaN when the datum is unknown.
        enu_from_camera: (3, 3) camera FLU in ENU at the camera.
        fix_covariance: (2, 2) horizontal East, North covariance that the fix reports, m², or
            None when it reports none.
        oldest_age_s: largest distance in time from the scene to a sample used, s.
    """

    stamp_ns: int
    latitude: float
    longitude: float
    height: float
    altitude: float
    enu_from_camera: Array
    fix_covariance: Array | None = None
    oldest_age_s: float = 0.0


@dataclass(frozen=True)
class PosedFrame:
    """One image's boxes with the camera and its pose: everything that estimation needs.

    Attributes:
        latency: what is known of the correction of `camera.latency_s` that the pose allows for,
            mean and sigma, s; None where it is not estimated.
    """

    detections: DetectionFrame
    camera: CameraModel
    pose: CameraPose
    latency: tuple[float, float] | None = None


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
        robot_id: `<class>_<n>`, or the name bound to a start.
        class_id: class name as the detector gave it.
        state: confirmed (measured in this image) or coasting (predicted).
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        altitude: of the water under the robot above the ellipsoid, m; NaN when unknown.
        position: (2,) East, North in the frame `map`, m.
        velocity: (2,) East, North, m/s.
        covariance: (4, 4) of East, North, velocity East, velocity North; SI. Includes the
            share of the platform's slowly varying errors.
        last_seen_ns: stamp of the image that measured it last, ns.
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


@dataclass(frozen=True)
class MapDatum:
    """Origin of the local ENU frame `map`: latitude, longitude in rad, altitude in m or NaN."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True)
class PlatformError:
    """A slowly varying error of the platform as the filter sees it.

    Attributes:
        name: such as heading, see `joint_platform.PLATFORM`.
        value: what is added to the measured value to have the true one; m, rad or s.
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
class FrameResult:
    """What one image gave: estimates ordered by robot_id, and what was refused.

    Attributes:
        stamp_ns: the image's stamp, ns.
        frame_id: the image's frame.
        estimates: confirmed and coasting robots.
        rejections: detections that gave no position.
        datum: origin of `map`, None until it is settled.
        pose: the pose used, None when an input was missing.
        timings_ms: milliseconds per stage.
        platform: errors that the filter estimates; empty where nothing was measured.
        boxes: how many the image had.
        used: how many boxes it showed to have measured robots, of this image and those before it.
        late: boxes of images before it that it showed to have measured none (`unconfirmed`).
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


def empty_detections(stamp_ns: int, frame_id: str = "camera") -> DetectionFrame:
    """Return the frame of an image in which nothing was found."""
    return DetectionFrame(stamp_ns, frame_id, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), ())
