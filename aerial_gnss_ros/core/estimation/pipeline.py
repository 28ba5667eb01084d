# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image from boxes to robots: choose boxes, camera, pose, points on the water, tracks."""

from __future__ import annotations

import copy
import math
import time
from dataclasses import replace
from functools import partial

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.single_image import at_own_points, exact_points
from aerial_gnss_ros.core.faults.camera_change import CameraChange
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.frozen_input import FrozenInputDetector
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing import localization, paper
from aerial_gnss_ros.core.georeferencing.detection_filter import DetectionFilter, rejections
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.georeferencing.point_checks import PointChecks
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.depths import inflate_by_depth
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import Current, FrameResult, PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason

Reasons = list[Reason | None]

_NO_ALTITUDE = {
    "ellipsoid": "the fix brings none; give one in the message to have it.",
    "amsl": "the fix brings none; give one in the message to have it.",
    "home": "fix.altitude_datum is home; give its own altitude as fix.home_altitude_m.",
    "unknown": "fix.altitude_datum is unknown; set it to ellipsoid where the receiver says so.",
}


class Pipeline:
    """Turns one image's boxes and telemetry into a result; images come in stamp order.

    Attributes:
        boxes: decides which boxes are used.
        latency: of the images, as far as it is known.
        tracking: of the robots.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        tracking: Tracking,
        origin: MapOrigin,
        log: Events,
    ) -> None:
        self.boxes = DetectionFilter(config.detections, log)
        self.latency = LatencySearch(config, inputs)
        self._config = config
        self._inputs = inputs
        self.tracking = tracking
        self._origin = origin
        self._log = log
        self._posing = PoseBuilder(config)
        self._frozen = FrozenInputDetector(config.noise.value("box_center_px"))
        self._camera_change = CameraChange(log)
        self._checks = PointChecks(config, load_area(config.detections.area), log)
        self._altitude_told = False
        self._locate = paper.locate if config.method == "paper" else localization.locate

    @property
    def monitor(self) -> InnovationMonitor:
        """Tells how well boxes fall where they are expected."""
        return self.tracking.monitor

    @property
    def constant(self) -> tuple[type, ...]:
        """Classes of its parts that images do not change, as it is configured."""
        return (PointChecks,) if self.latency.searches else (PointChecks, LatencySearch)

    def reset(self) -> None:
        """Forget all tracks."""
        self.tracking.reset()
        self.latency.reset()
        self._frozen.reset()
        self._camera_change.reset()

    def end(self) -> Settled:
        """Decide on all boxes, since nothing more comes, and return what has been decided."""
        self.tracking.end()
        return self.tracking.settled()

    def coast(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image of which nothing else is known."""
        return self.tracking.coast(stamp_ns)

    def predicted(self, stamp_ns: int) -> FrameResult:
        """Return the robots as a copy of the tracks has them later, by prediction alone."""
        estimates = copy.deepcopy(self.tracking).coast(stamp_ns)
        return FrameResult(stamp_ns, "", estimates, (), self._origin.datum)

    def result(
        self, frame: DetectionFrame, samples: SceneTelemetry | MissingTelemetry
    ) -> FrameResult:
        """Return what one image gives."""
        began = time.perf_counter_ns()
        reasons = self.boxes.reasons(frame)
        used: list[int] = []
        for i, reason in enumerate(reasons):
            if reason is None:
                used.append(i)
        shown = frame if len(used) == len(reasons) else frame.rows(used)
        scene, pose = self._scene(shown, samples)
        posed = time.perf_counter_ns()
        platform: tuple[PlatformError, ...] = ()
        current: Current | None = None
        if isinstance(scene, Reason):
            located = posed
            reasons = [reason or scene for reason in reasons]
            blank = scene is Reason.BAD_DETECTIONS
            estimates = self.tracking.coast(frame.stamp_ns, None if blank else shown)
        else:
            sent = self._inputs.depths
            depths = sent.at(shown.class_ids, scene.pose.stamp_ns) if sent.used else None
            points = self._locate(
                scene.pose, scene.camera, shown.centers, self._config.noise, self._config, depths
            )
            if self._checks.used:
                points = self._checks.apply(scene, points)
            located = time.perf_counter_ns()
            estimates, platform, current, unused = self._tracked(scene, points)
            for i, reason in zip(used, unused, strict=True):
                reasons[i] = reason
        if estimates:
            self._origin.settle()
        datum = self._origin.datum
        settled = self.tracking.settled()
        done = time.perf_counter_ns()
        return FrameResult(
            frame.stamp_ns,
            frame.frame_id,
            estimates,
            rejections(frame, reasons) if any(reasons) else (),
            datum,
            pose,
            {
                "pose": (posed - began) * 1e-6,
                "locate": (located - posed) * 1e-6,
                "track": (done - located) * 1e-6,
            },
            platform,
            len(frame.class_ids),
            settled.used,
            settled.refused,
            current,
        )

    def _pose(self, samples: SceneTelemetry | MissingTelemetry) -> CameraPose | Reason:
        """Return the camera's pose where `map` holds for it, or why there is none."""
        if isinstance(samples, MissingTelemetry):
            return self._lacking(samples)
        pose = self._posing.pose(samples)
        if isinstance(pose, Reason):
            if self._posing.trouble:
                self._log.warn_once(self._posing.trouble, self._posing.trouble)
            return pose
        if math.isnan(pose.altitude) and not self._altitude_told:
            self._altitude_told = True
            why = _NO_ALTITUDE[self._config.fix.altitude_datum]
            self._log.warn_once("altitude", f"Published altitudes are NaN: {why}")
        return pose if self._origin.covers(pose.latitude, pose.longitude) else Reason.BAD_FIX

    def _lacking(self, samples: MissingTelemetry) -> Reason:
        """Return why there is no telemetry; say so where an input is of another time."""
        if samples.later_s > self._config.max_wait:
            name = str(samples.reason).removeprefix("no_")
            self._log.warn_once(
                f"later {name}",
                f"The oldest {name} is {samples.later_s:.1f} s later than an image, which is "
                f"refused ({samples.reason}). If it came no later, their clocks differ: "
                f"{name}.stamp says whether a message's header or its arrival counts, and a bag "
                "played in a loop has headers that begin again and arrivals that go on.",
            )
        return samples.reason

    def _scene(
        self, boxes: DetectionFrame, samples: SceneTelemetry | MissingTelemetry
    ) -> tuple[PosedFrame | Reason, CameraPose | None]:
        """Return boxes with camera and pose, or why boxes are refused: something lacks or froze.

        Also the pose, which is known without a camera as well.
        """
        pose, camera = self._pose(samples), self._inputs.cameras.at(boxes.stamp_ns)
        if isinstance(camera, Reason):
            return camera, None if isinstance(pose, Reason) else pose
        if isinstance(pose, Reason):
            return pose, None
        local = self._origin.local
        assert local is not None  # noqa: S101 - a pose needs a fix, that sets it
        in_map = MapPose.of(pose, local)
        if self._frozen.telemetry_frozen(pose.stamp_ns, in_map):
            self._log.warn_once(
                "telemetry stands",
                "All telemetry stopped dead in a motion and repeats itself to the last bit: boxes "
                "are refused until it changes (stale_fix). Its source may have frozen.",
            )
            return Reason.STALE_FIX, None
        if self._frozen.image_frozen(boxes, camera, in_map):
            self._log.warn_once(
                "picture stands",
                "Boxes repeat themselves to the last bit while the camera moves: the picture "
                "stands still, and they are refused until it changes (bad_detections).",
            )
            return Reason.BAD_DETECTIONS, None
        references = self._inputs.references
        known = references.at(pose.stamp_ns) if references.configured else ()
        scene = PosedFrame(boxes, camera, pose, in_map, self.latency.found, known)
        misfit = partial(self._misfit, scene, local)
        used = self._camera_change.update(camera, boxes.stamp_ns, misfit)
        return scene if used is camera else replace(scene, camera=used), pose

    def _misfit(self, scene: PosedFrame, local: LocalMap, camera: CameraModel) -> float:
        """Return how badly boxes fit the robots in view if this is the camera, nats."""
        seen = replace(scene, camera=camera)
        points = localization.locate(
            scene.pose, camera, scene.detections.centers, self._config.noise, self._config
        )
        return copy.deepcopy(self.tracking).misfit(seen, points, local)

    def _tracked(
        self, scene: PosedFrame, points: WaterPoints
    ) -> tuple[tuple[RobotEstimate, ...], tuple[PlatformError, ...], Current | None, Reasons]:
        """Return what an image tells of robots and platform, and why boxes measured nothing.

        Args:
            scene: boxes, camera and pose.
            points: of these boxes, by the configured method.
        """
        local, method = self._origin.local, self._config.method
        assert local is not None  # noqa: S101 - see `_scene`
        exact = exact_points(scene, points, self._config) if method == "paper" else points
        update = self.tracking.update(scene, exact, local)
        if self.latency.found is not None:
            self.latency.update(scene, update.measured, local)
        reasons: Reasons = []
        for reason, fast, gated in zip(points.reasons, update.too_fast, update.gated, strict=True):
            unused = Reason.TOO_FAST if fast else Reason.GATED if gated else None
            reasons.append(reason or unused)
        if method != "filter":
            return at_own_points(update, points, local), (), None, reasons
        # Other methods' points have the depth's share already.
        sigma_m = self._config.depth.sigma_m
        estimates = update.estimates
        if sigma_m:
            estimates = inflate_by_depth(estimates, scene.pose, local, sigma_m)
        return estimates, update.platform, update.current, reasons
