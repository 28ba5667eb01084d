# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reasons of refusal: the identifiers used in diagnostics and rejected.csv."""

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
    """A reason of refusal. `stale_`: no sample arrived in time; `gap_`: samples too far apart."""

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
        """Explanation for reports."""
        kind, _, source = self.value.partition("_")
        return _MEANINGS.get(self.value) or _FAMILIES[kind].format(source)

    @classmethod
    def no(cls, source: Input) -> Reason:
        """The input never arrived."""
        return cls(f"no_{source.value}")

    @classmethod
    def stale(cls, source: Input) -> Reason:
        """The input has arrived before, but not for this image within `max_wait`."""
        return cls(f"stale_{source.value}")

    @classmethod
    def gap(cls, source: Input) -> Reason:
        """The samples on both sides of the image are more than `max_gap` apart."""
        return cls(f"gap_{source.value}")

    @classmethod
    def bad(cls, source: Input) -> Reason:
        """The input's value is unusable: NaN, no fix, a quaternion that is not unit."""
        return cls(f"bad_{source.value}")


_MEANINGS = {
    "above_horizon": "the box's ray does not meet the water; in many images: check "
    "gimbal.reference and the sign of its pitch",
    "out_of_range": "farther away, or less certain, than surface.max_range and max_sigma_m allow",
    "outside_calibrated_image": "outside the image, or outside the valid region of the lens model",
    "no_camera_info": "no CameraInfo had arrived before this image",
    "bad_camera_info": "the CameraInfo was unusable",
    "bad_detections": "the box is not finite, or the image is frozen or turned",
    "gated": "on no robot: a false box, a second one on a robot, or outside all gates",
    "low_score": "the detector's score was below detections.min_score",
    "wrong_class": "not of detections.classes",
    "outside_area": "outside the area of operation (detections.area) by more than its uncertainty",
    "wrong_size": "longer or shorter than a robot of its class is (classes.<name>.length_m)",
    "too_fast": "it implies a speed above tracks.max_speed: the compass, the gimbal or "
    "camera.latency_s may be wrong",
    "unconfirmed": "its track ended before it was confirmed as a robot",
    "internal": "an internal error on this image, which changed nothing; the log has the details",
}
_FAMILIES = {
    "no": "{} never arrived, or only for later times than this image's",
    "stale": "{} did not arrive within max_wait or before the recording ended, or repeats itself "
    "during a motion",
    "gap": "{} has a gap longer than max_gap here",
    "bad": "{} was unusable: not finite, no fix, no rotation, or implausible",
}


class Cause(str, Enum):
    """The probable reason why a track was never confirmed."""

    TOO_FEW_IMAGES = "too_few_images"
    IMAGES_TOO_SELDOM = "images_too_seldom"
    OUT_OF_GATE = "out_of_gate"
    TOO_FAST = "too_fast"
    LOST_PLATFORM = "lost_platform"
    CLUTTER = "clutter"
    UNSURE = "unsure"
    WRONG_SIZE = "wrong_size"
    CUT_SHORT = "cut_short"

    def __str__(self) -> str:
        return self.value

    @property
    def meaning(self) -> str:
        """Explanation for summaries, with the possible cause."""
        return _CAUSES[self]


_CAUSES = {
    Cause.TOO_FEW_IMAGES: "in fewer than tracks.confirm_hits images within "
    "tracks.confirm_window_s: a false box, or a robot that is often missed",
    Cause.IMAGES_TOO_SELDOM: "images were too rare for tracks.confirm_hits of them within "
    "tracks.confirm_window_s; raise that",
    Cause.OUT_OF_GATE: "the next box was outside the gate: camera.latency_s, the compass, the "
    "gimbal or the noise.* parameters may be wrong",
    Cause.TOO_FAST: "moved faster than tracks.max_speed: camera.latency_s, the compass or the "
    "gimbal may be wrong, or robots are faster",
    Cause.LOST_PLATFORM: "seen while most robots were displaced: the compass, the gimbal, the fix "
    "or camera.latency_s may be wrong",
    Cause.CLUTTER: "seen in too few of the images, or amid many false boxes; raise "
    "detections.min_score",
    Cause.UNSURE: "its boxes score lower than those of robots do in the mean; lower "
    "tracks.confirm_score",
    Cause.WRONG_SIZE: "its boxes are longer or shorter in the mean than a robot of its class is "
    "(classes.<name>.length_m)",
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
        cause: why its track was not confirmed, if it is `unconfirmed`.
    """

    stamp_ns: int
    reason: Reason
    u_px: float
    v_px: float
    cause: Cause | None = None
