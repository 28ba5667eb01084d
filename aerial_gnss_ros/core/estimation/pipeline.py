# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image from boxes to robots: choose boxes, camera, pose, points on the water, tracks."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.area_of_operation import Polygon
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.image_bounds import ImageBounds
from aerial_gnss_ros.core.estimation.reference_classes import ReferenceClasses
from aerial_gnss_ros.core.estimation.single_image import at_own_points, exact_points
from aerial_gnss_ros.core.faults.camera_change import CameraChange
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.frozen_input import FrozenInputDetector
from aerial_gnss_ros.core.faults.image_orientation import ImageOrientation, PosedBoxes
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing import localization, paper
from aerial_gnss_ros.core.georeferencing.detection_filter import DetectionFilter, rejections
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.georeferencing.point_checks import PointChecks
from aerial_gnss_ros.core.models.motion_model import fastest
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
    "ellipsoid": "the fix has none; it must be in the message.",
    "amsl": "the fix has none; it must be in the message.",
    "home": "fix.altitude_datum is home; give its own altitude as fix.home_altitude_m.",
    "unknown": "fix.altitude_datum is unknown; set it to ellipsoid if the receiver's documentation "
    "says so.",
}

_TURNED = (
    "Boxes go through the image as if it was {}: they are refused (bad_detections). Turn it back "
    "in the camera's driver, or state how the camera is mounted; if the image is right, angles of "
    "the gimbal have a wrong sign."
)


class Pipeline:
    """Turns one image's boxes and telemetry into a result; images come in stamp order.

    Attributes:
        boxes: selects the boxes.
        latency: estimate of the images' latency.
        tracking: of the robots.
        measured: the last image that was tracked, and the box of each labelled robot.
        corrects: label of the robot that each reference is which corrected its positions.
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
        self._orientation, self._turned = ImageOrientation(), False
        self._fastest = fastest(config)
        self._checks = PointChecks(config, load_area(config.detections.area), log)
        self._references = ReferenceClasses(config.references, log)
        given = config.camera.source == "topic"
        self._bounds = ImageBounds("camera_info" if given else "camera.image_width_px", log)
        if config.noise.exact and config.method == "filter":
            names = ", ".join(f"noise.{name}" for name in config.noise.exact)
            log.warn_once(
                "exact sensors",
                f"Stated to be 0: {names}. No sensor is exact, and published covariances do not "
                "contain these errors; state how large they may be, or leave the lines out.",
            )
        self._altitude_told = False
        self.measured: tuple[PosedFrame, dict[str, int]] | None = None
        self.corrects: Mapping[str, str] = {}
        self._locate = paper.locate if config.method == "paper" else localization.locate

    @property
    def monitor(self) -> InnovationMonitor:
        """Innovation statistics of the tracker."""
        return self.tracking.monitor

    @property
    def constant(self) -> tuple[type, ...]:
        """Classes of its parts that images do not change."""
        return (PointChecks,) if self.latency.searches else (PointChecks, LatencySearch)

    def reconfigure(self, config: EstimatorConfig, area: tuple[Polygon, ...]) -> None:
        """Use another configuration from the next image on; tracks continue.

        Args:
            config: differs in parameters that may be changed in flight.
            area: its area of operation.
        """
        change = CalibrationChange.between(self._config, config)
        self.boxes.min_score = config.detections.min_score
        self.boxes.classes = config.detections.classes
        self._checks = PointChecks(config, area, self._log)
        if config.references != self._config.references:
            self._references = ReferenceClasses(config.references, self._log)
        self.tracking.reconfigure(config, change)
        self._config, self._fastest = config, fastest(config)
        if change:
            self._posing = PoseBuilder(config)
            former, self.latency = self.latency, LatencySearch(config, self._inputs)
            self.latency.follow(former)
            self._camera_change.reset()
            self._frozen.recalibrate()

    def reset(self) -> None:
        """Drop all tracks."""
        self.tracking.reset()
        self.latency.reset()
        self._frozen.reset()
        self._camera_change.reset()
        self._orientation.reset()
        self._turned = False

    def end(self) -> Settled:
        """Decide on all pending boxes at the end of input, and return the decisions."""
        self.tracking.end()
        self._references.end()
        return self.tracking.settled()

    def coast(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image without further data."""
        return self.tracking.coast(stamp_ns)

    def predicted(self, stamp_ns: int) -> FrameResult:
        """Return robots predicted to a later time with a copy of the tracks."""
        estimates = copy.deepcopy(self.tracking).coast(stamp_ns)
        return FrameResult(stamp_ns, "", estimates, (), self._origin.datum)

    def result(
        self, frame: DetectionFrame, samples: SceneTelemetry | MissingTelemetry
    ) -> FrameResult:
        """Return the result of one image."""
        began = time.perf_counter_ns()
        reasons = self.boxes.reasons(frame)
        self._references.update(frame)
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
        """Return the camera's pose if `map` is valid there, or why there is none."""
        if isinstance(samples, MissingTelemetry):
            return samples.reason
        pose = self._posing.pose(samples)
        if isinstance(pose, Reason):
            if self._posing.trouble:
                # The sentence has numbers, which differ from image to image.
                self._log.counts[f"images_{pose}"] += 1
                self._log.warn_once(f"pose {pose}", self._posing.trouble)
            return pose
        if math.isnan(pose.altitude) and not self._altitude_told:
            self._altitude_told = True
            why = _NO_ALTITUDE[self._config.fix.altitude_datum]
            self._log.warn_once("altitude", f"Published altitudes are NaN: {why}")
        return pose if self._origin.covers(pose.latitude, pose.longitude) else Reason.BAD_FIX

    def _scene(
        self, boxes: DetectionFrame, samples: SceneTelemetry | MissingTelemetry
    ) -> tuple[PosedFrame | Reason, CameraPose | None]:
        """Return boxes with camera and pose, or why boxes are refused: missing or frozen input.

        Also the pose, which does not need a camera.
        """
        pose, camera = self._pose(samples), self._inputs.cameras.at(boxes.stamp_ns)
        if isinstance(camera, Reason):
            return camera, None if isinstance(pose, Reason) else pose
        self._bounds.update(boxes, camera)
        if isinstance(pose, Reason):
            return pose, None
        local = self._origin.local
        assert local is not None  # noqa: S101 - a pose needs a fix, which sets it
        in_map = MapPose.of(pose, local)
        if self._frozen.telemetry_frozen(pose.stamp_ns, in_map):
            self._log.warn_once(
                "telemetry stands",
                "All telemetry froze during a motion and repeats itself to the last bit: boxes "
                "are refused until it changes (stale_fix). Its source may have frozen.",
            )
            return Reason.STALE_FIX, None
        if self._frozen.image_frozen(boxes, camera, in_map):
            self._log.warn_once(
                "picture stands",
                "Boxes repeat themselves to the last bit while the camera moves: the image is "
                "frozen, and they are refused until it changes (bad_detections).",
            )
            return Reason.BAD_DETECTIONS, None
        if self._image_turned(PosedBoxes(pose, camera, boxes.centers)):
            return Reason.BAD_DETECTIONS, None
        references = self._inputs.references
        known = references.at(pose.stamp_ns) if references.configured else ()
        jumped = samples.fix.jumped if isinstance(samples, SceneTelemetry) else ()
        scene = PosedFrame(boxes, camera, pose, in_map, self.latency.found, known, jumped)
        misfit = partial(self._misfit, scene, local)
        used = self._camera_change.update(camera, boxes.stamp_ns, misfit)
        return scene if used is camera else replace(scene, camera=used), pose

    def _image_turned(self, image: PosedBoxes) -> bool:
        """Return whether boxes show that the image is turned, or have shown it.

        It is right again once things need not move at half the speed that no robot reaches.
        """
        found, before = self._orientation, self._turned
        found.update(image)
        sure = bool(found.way) and found.speed > self._fastest
        self._turned = sure or (before and found.speed > 0.5 * self._fastest)
        if self._turned and not before:
            self._log.counts["image_turned"] += 1
            self._log.warn_once(f"image {found.way}", _TURNED.format(found.way))
            self.tracking.reset()
        return self._turned

    def _misfit(self, scene: PosedFrame, local: LocalMap, camera: CameraModel) -> float:
        """Return the negative log likelihood of the boxes with this camera, nats."""
        seen = replace(scene, camera=camera)
        points = localization.locate(
            scene.pose, camera, scene.detections.centers, self._config.noise, self._config
        )
        return copy.deepcopy(self.tracking).misfit(seen, points, local)

    def _tracked(
        self, scene: PosedFrame, points: WaterPoints
    ) -> tuple[tuple[RobotEstimate, ...], tuple[PlatformError, ...], Current | None, Reasons]:
        """Return an image's estimates of robots and platform, and the reasons of refused boxes.

        Args:
            scene: boxes, camera and pose.
            points: of these boxes, by the configured method.
        """
        local, method = self._origin.local, self._config.method
        assert local is not None  # noqa: S101 - see `_scene`
        exact = exact_points(scene, points, self._config) if method == "paper" else points
        update = self.tracking.update(scene, exact, local)
        self.measured, self.corrects = (scene, update.measured), update.corrects
        if self.latency.found is not None:
            self.latency.update(scene, update.measured, local)
        reasons: Reasons = []
        too_fast, gates = update.too_fast.tolist(), update.gated.tolist()
        for reason, fast, gated in zip(points.reasons, too_fast, gates, strict=True):
            unused = Reason.TOO_FAST if fast else Reason.GATED if gated else None
            reasons.append(reason or unused)
        if method != "filter":
            return at_own_points(update, points, local), (), None, reasons
        # Other methods' points already contain the depth's uncertainty.
        sigma_m = self._config.depth.sigma_m
        estimates = update.estimates
        if sigma_m:
            estimates = inflate_by_depth(estimates, scene.pose, local, sigma_m)
        return estimates, update.platform, update.current, reasons
