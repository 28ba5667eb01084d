# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The last line of defence: an image whose estimation fails changes nothing.

If processing an image fails, its boxes are refused as `internal` and all state that images change
is restored. Several such images in a row mean that the state itself is at fault: the filter
restarts, and robots get their labels back where they are detected again.

Known causes are refused where they arise, with their own reason; what reaches this module is an
internal error, and the log has what a developer needs to find it.
"""

from __future__ import annotations

import traceback
from pathlib import Path

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.snapshot import Plans, Snapshot
from aerial_gnss_ros.core.filter.plausible_state import check_estimates
from aerial_gnss_ros.core.georeferencing import detection_filter
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.identity.return_position import ReturnPosition
from aerial_gnss_ros.core.models.motion_model import ClassMotions, MotionOf
from aerial_gnss_ros.core.models.platform_model import PlatformModel
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason

_CONSTANT = (
    TelemetryBuffers,
    MotionOf,
    ClassMotions,
    PlatformModel,
    PoseBuilder,
    ReturnPosition,
)
"""Classes that images do not change, skipped by snapshots."""

_REBOUND = (Track,)
"""Classes whose instances images change only by assignment to attributes, see `Plans`."""

RESTART_AFTER = 5
"""Consecutive failed images after which the filter restarts."""


class Guard:
    """Processes images so that a failure leaves only a count and a log sentence.

    Args:
        pipeline: turns an image into a result.
        identity: of the robots.
        origin: of `map`.
        log: receives failures.
    """

    def __init__(
        self, pipeline: Pipeline, identity: Labels, origin: MapOrigin, log: Events
    ) -> None:
        self._pipeline = pipeline
        self._identity = identity
        self._origin = origin
        self._log = log
        self._roots = (pipeline, identity, log)
        self._plans = Plans((*_CONSTANT, *pipeline.constant), _REBOUND)
        self._failed = 0
        self._last: tuple[RobotEstimate, ...] = ()

    def result(
        self, frame: DetectionFrame, samples: SceneTelemetry | MissingTelemetry | Exception
    ) -> FrameResult:
        """Return the result of an image; on failure refuse its boxes and change nothing.

        Args:
            frame: the image's boxes.
            samples: telemetry at its time, or what is missing.
        """
        if isinstance(samples, Exception):
            return self._refused(frame, samples)
        before = Snapshot(self._roots, self._plans)
        try:
            result = self._pipeline.result(frame, samples)
            self._pipeline.tracking.check()
            check_estimates(result.estimates)
        except MemoryError:
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, the flight continues
            before.restore()
            return self._refused(frame, error)
        self._failed, self._last = 0, result.estimates
        return result

    def reset(self) -> None:
        """Clear the failures after a reset of time."""
        self._failed, self._last = 0, ()

    def _refused(self, frame: DetectionFrame, error: Exception) -> FrameResult:
        self._failed += 1
        self._log.counts["images_failed"] += 1
        place = _innermost(error)
        self._log.warn_once(
            f"failed {type(error).__name__} {place}",
            f"The image of {frame.stamp_ns} ns could not be processed and changed nothing "
            f"({type(error).__name__} at {place}: {error}; {len(frame)} boxes, {len(self._last)} "
            "robots): its boxes are refused as internal. This is an internal error; please "
            "report it with this sentence.",
        )
        if self._failed >= RESTART_AFTER:
            self._restart()
        refused = detection_filter.rejections(frame, [Reason.INTERNAL] * len(frame))
        datum, estimates = self._origin.datum, self._coasting(frame.stamp_ns)
        return FrameResult(
            frame.stamp_ns, frame.frame_id, estimates, refused, datum, boxes=len(frame)
        )

    def _coasting(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots for a failed image, without changing the state."""

        def coast() -> tuple[RobotEstimate, ...]:
            estimates = self._pipeline.coast(stamp_ns)
            check_estimates(estimates)
            return estimates

        before = Snapshot(self._roots, self._plans)
        found = attempt(coast)
        before.restore()
        return () if isinstance(found, Exception) else found

    def _restart(self) -> None:
        self._pipeline.reset()
        self._identity.expect(self._last)
        self._failed, self._last = 0, ()
        self._log.counts["filter_restarts"] += 1
        self._log.add(
            f"{RESTART_AFTER} images in a row could not be processed: the filter restarts, and "
            "robots get their labels back where they are detected again."
        )


def _innermost(error: Exception) -> str:
    """Return file and line of the code where an error arose."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return "an unknown place"
    return f"{Path(frames[-1].filename).name}:{frames[-1].lineno}"
