# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Why a detection gave no position: the only words used in diagnostics and rejected.csv."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Input(str, Enum):
    """A telemetry input of the estimator; the value is its canonical topic name."""

    FIX = "fix"
    ATTITUDE = "attitude"
    GIMBAL = "gimbal"
    HEIGHT = "height"

    def __str__(self) -> str:
        return self.value


class Reason(str, Enum):
    """A typed refusal. `stale_`: no sample came in time; `gap_`: neighbours too far apart."""

    ABOVE_HORIZON = "above_horizon"
    OUT_OF_RANGE = "out_of_range"
    OUTSIDE_CALIBRATED_IMAGE = "outside_calibrated_image"
    NO_CAMERA_INFO = "no_camera_info"
    NO_FIX = "no_fix"
    NO_ATTITUDE = "no_attitude"
    NO_GIMBAL = "no_gimbal"
    NO_HEIGHT = "no_height"
    STALE_FIX = "stale_fix"
    STALE_ATTITUDE = "stale_attitude"
    STALE_GIMBAL = "stale_gimbal"
    STALE_HEIGHT = "stale_height"
    GAP_FIX = "gap_fix"
    GAP_ATTITUDE = "gap_attitude"
    GAP_GIMBAL = "gap_gimbal"
    GAP_HEIGHT = "gap_height"
    BAD_FIX = "bad_fix"
    BAD_ATTITUDE = "bad_attitude"
    BAD_GIMBAL = "bad_gimbal"
    BAD_HEIGHT = "bad_height"
    BAD_CAMERA_INFO = "bad_camera_info"
    BAD_DETECTIONS = "bad_detections"
    GATED = "gated"
    LOW_SCORE = "low_score"
    WRONG_CLASS = "wrong_class"
    OUTSIDE_AREA = "outside_area"
    WRONG_SIZE = "wrong_size"
    TOO_FAST = "too_fast"
    UNCONFIRMED = "unconfirmed"
    INTERNAL = "internal"

    def __str__(self) -> str:
        return self.value

    @property
    def meaning(self) -> str:
        """What happened, in words for whoever reads a report."""
        kind, _, source = self.value.partition("_")
        return _MEANINGS.get(self.value) or _FAMILIES[kind].format(source)

    @classmethod
    def no(cls, source: Input) -> Reason:
        """The input never came."""
        return cls(f"no_{source.value}")

    @classmethod
    def stale(cls, source: Input) -> Reason:
        """The input came once, but not for this image within `max_wait`."""
        return cls(f"stale_{source.value}")

    @classmethod
    def gap(cls, source: Input) -> Reason:
        """The samples on both sides of the image are more than `max_gap` apart."""
        return cls(f"gap_{source.value}")

    @classmethod
    def bad(cls, source: Input) -> Reason:
        """The input's value cannot be used: NaN, no fix, a quaternion that is not unit."""
        return cls(f"bad_{source.value}")


_MEANINGS = {
    "above_horizon": "the box is so high in the image that its ray meets no water; in many images: "
    "check gimbal.reference and the sign of its pitch",
    "out_of_range": "farther away, or less sure, than surface.max_range and max_sigma_m allow",
    "outside_calibrated_image": "where the lens model does not hold, or outside the image",
    "no_camera_info": "no CameraInfo had come before this image",
    "bad_camera_info": "the CameraInfo could not be used",
    "bad_detections": "the box is not a number, or the picture stands still while the camera moves",
    "gated": "on no robot: a false box, a second one on a robot, or too far from where it can be",
    "low_score": "the detector was less sure than detections.min_score asks",
    "wrong_class": "not of detections.classes",
    "outside_area": "outside the area of operation (detections.area) by more than its uncertainty",
    "wrong_size": "longer or shorter than a robot of its class is (classes.<name>.length_m)",
    "too_fast": "by it a robot would be faster than tracks.max_speed: the compass, the gimbal or "
    "camera.latency_s may be wrong",
    "unconfirmed": "its track ended before it was confirmed as a robot",
    "internal": "the program failed on this image, which changed nothing; the log says where",
}
_FAMILIES = {
    "no": "{} never came, or only for later times than this image's",
    "stale": "{} did not come within max_wait, or repeats itself in the middle of a motion",
    "gap": "{} has a gap longer than max_gap here",
    "bad": "{} was of no use here: not a number, no fix, no rotation, or impossible",
}


class Cause(str, Enum):
    """Why a track was never confirmed, as far as can be told."""

    TOO_FEW_IMAGES = "too_few_images"
    IMAGES_TOO_SELDOM = "images_too_seldom"
    OUT_OF_GATE = "out_of_gate"
    TOO_FAST = "too_fast"
    LOST_PLATFORM = "lost_platform"
    CLUTTER = "clutter"
    CUT_SHORT = "cut_short"

    def __str__(self) -> str:
        return self.value

    @property
    def meaning(self) -> str:
        """What happened and what may be the reason, in words for whoever reads a summary."""
        return _CAUSES[self]


_CAUSES = {
    Cause.TOO_FEW_IMAGES: "in fewer than tracks.confirm_hits images within "
    "tracks.confirm_window_s: a false box, or a robot that is often missed",
    Cause.IMAGES_TOO_SELDOM: "images came too seldom for tracks.confirm_hits of them within "
    "tracks.confirm_window_s; raise that",
    Cause.OUT_OF_GATE: "the next box lay outside the gate: camera.latency_s, the compass, the "
    "gimbal or the noise.* parameters may be wrong",
    Cause.TOO_FAST: "moved faster than tracks.max_speed: camera.latency_s, the compass or the "
    "gimbal may be wrong, or robots are faster",
    Cause.LOST_PLATFORM: "seen while robots were not where they should be: the compass, the "
    "gimbal, the fix or camera.latency_s may be wrong",
    Cause.CLUTTER: "seen in fewer than half of the images, or amid many false boxes; raise "
    "detections.min_score",
    Cause.CUT_SHORT: "the recording ended, or tracks were cleared, before it was decided",
}


@dataclass(frozen=True)
class Rejection:
    """One detection that gave no position.

    Attributes:
        stamp_ns: stamp of the image, ns.
        reason: the typed refusal.
        u_px: column of the box centre, px.
        v_px: row of the box centre, px.
        cause: why its track was not confirmed, of one that is `unconfirmed`.
    """

    stamp_ns: int
    reason: Reason
    u_px: float
    v_px: float
    cause: Cause | None = None
