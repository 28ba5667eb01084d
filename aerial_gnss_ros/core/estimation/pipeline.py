# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image from boxes to robots: choose boxes, camera, pose, points on the water, tracks."""

from __future__ import annotations

import copy
import math
import time
from dataclasses import replace

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.camera_change import CameraChange
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.frozen_input import FrozenInputDetector
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.local_map import LocalMap
from aerial_gnss_ros.core.georeferencing import detection_filter, localization, paper
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.models.measurement_model import MapFrame
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.corrections import scaled_camera
from aerial_gnss_ros.core.telemetry.depths import inflate_by_depth
from aerial_gnss_ros.core.telemetry.input_status import InputState, InputStatus
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.protocol import Tracking, TrackUpdate
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input, Reason

_TELEMETRY = frozenset(source.value for source in Input)
_NO_ALTITUDE = {
    "ellipsoid": "the fix brings none; give one in the message to have it.",
    "amsl": "the fix brings none; give one in the message to have it.",
    "home": "fix.altitude_datum is home; give its own altitude as fix.home_altitude_m.",
    "unknown": "fix.altitude_datum is unknown; set it to ellipsoid where the receiver says so.",
}


class Pipeline:
    """Turns one image's boxes and telemetry into a result; images come in stamp order.

    Attributes:
        min_score: boxes below are refused.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        tracking: Tracking,
        origin: MapOrigin,
        log: Events,
    ) -> None:
        self.min_score = config.detections.min_score
        self._config = config
        self._inputs = inputs
        self._tracking = tracking
        self._origin = origin
        self._log = log
        self._posing = PoseBuilder(config)
        self._latency = LatencySearch(config, inputs)
        self._crowd = detection_filter.BoxCountMonitor()
        self._strangers = detection_filter.UnknownClassMonitor()
        self._standstill = FrozenInputDetector(config.noise.value("box_center_px"))
        self._frame_of_map: MapFrame | None = None
        self._fixed_camera = camera_of(config)
        self._scaled: tuple[CameraModel, CameraModel] | None = None
        self._camera_change = CameraChange(log)
        self._locate = paper.locate if config.method == "paper" else localization.locate

    @property
    def latency_ns(self) -> int:
        """How long before an image's stamp its scene was, as far as it is known, ns."""
        return self._latency.scene_ns

    @property
    def monitor(self) -> InnovationMonitor:
        """Tells how well boxes fall where they are expected."""
        return self._tracking.monitor

    @property
    def searches_latency(self) -> bool:
        """Whether the latency is searched for, by telemetry of some time."""
        return self._latency.searches

    @property
    def constant(self) -> tuple[type, ...]:
        """Classes of its parts that images do not change, as it is configured."""
        return () if self._latency.searches else (LatencySearch,)

    def reset(self) -> None:
        """Forget all tracks."""
        self._tracking.reset()
        self._latency.reset()
        self._standstill.reset()
        self._camera_change.reset()

    def check(self) -> None:
        """Check that what images have come to can be.

        Raises:
            StateError: it cannot.
        """
        self._tracking.check()

    def end(self) -> Settled:
        """Decide on all boxes, since nothing more comes, and return what has been decided."""
        self._tracking.end()
        return self._tracking.settled()

    def coast(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image of which nothing else is known."""
        return self._tracking.coast(stamp_ns)

    def without_messages(self, status: InputStatus) -> InputStatus:
        """Return an input's status, unused or constant where no message is needed for it."""
        name, state = status.name, None
        if name in _TELEMETRY:
            state = self._inputs.state_without_messages(Input(name))
        elif name != "detections":
            given = self._fixed_camera is not None if name == "camera_info" else not status.count
            if given:
                state = InputState.CONSTANT
            elif status.state is InputState.STALE:
                state = InputState.OK  # a camera or a level holds until replaced
        return status if state is None else replace(status, state=state)

    def result(
        self, frame: DetectionFrame, samples: SceneTelemetry | MissingTelemetry
    ) -> FrameResult:
        """Return what one image gives."""
        began = time.perf_counter_ns()
        reasons = detection_filter.refusals(frame, self.min_score, self._config.detections.classes)
        self._look_for_crowd(reasons.count(None))
        self._look_for_strangers(frame, reasons)
        camera = self._camera(frame.stamp_ns)
        pose = (
            self._refusal(samples) if isinstance(samples, MissingTelemetry) else self._pose(samples)
        )
        posed = time.perf_counter_ns()
        local = self._origin.local
        if isinstance(pose, CameraPose) and not self._origin.covers(pose.latitude, pose.longitude):
            pose = Reason.BAD_FIX
        elif isinstance(pose, CameraPose) and isinstance(camera, CameraModel) and local is not None:
            use = [i for i, reason in enumerate(reasons) if reason is None]
            pose = self._unless_still(_only(frame, use), camera, pose, local)
        if isinstance(camera, Reason) or isinstance(pose, Reason) or local is None:
            refusal = camera if isinstance(camera, Reason) else pose
            assert isinstance(refusal, Reason)  # noqa: S101 - a pose needs a fix, that sets local
            use = [i for i, reason in enumerate(reasons) if reason is None]
            shown = _only(frame, use) if refusal is not Reason.BAD_DETECTIONS else None
            reasons = [reason or refusal for reason in reasons]
            estimates = self._tracking.coast(frame.stamp_ns, shown)
            platform: tuple[PlatformError, ...] = ()
            located = posed
        else:
            use = [i for i, reason in enumerate(reasons) if reason is None]
            camera = self._fitting_camera(camera, _only(frame, use), pose, local)
            seen = PosedFrame(_only(frame, use), camera, pose, self._latency.found)
            found = seen.detections
            depths = self._inputs.depths.at(found.class_ids, pose.stamp_ns)
            points = self._locate(
                pose, camera, found.centers, self._config.noise, self._config, depths
            )
            located = time.perf_counter_ns()
            update = self._tracking.update(seen, self._tracked(seen, points), local)
            self._latency.update(seen, update.measured, local)
            for row, i in enumerate(use):
                reasons[i] = points.reasons[row] or _unused(update, row)
            estimates, platform = self._published(update, points), update.platform
            if self._config.method == "filter":  # other methods' points have it already
                estimates = inflate_by_depth(estimates, pose, local, self._config.depth.sigma_m)
        if estimates:
            self._origin.settle()
        settled = self._tracking.settled()
        done = time.perf_counter_ns()
        return FrameResult(
            frame.stamp_ns,
            frame.frame_id,
            estimates,
            detection_filter.rejections(frame, reasons),
            self._origin.datum,
            pose if isinstance(pose, CameraPose) else None,
            {
                "pose": (posed - began) * 1e-6,
                "locate": (located - posed) * 1e-6,
                "track": (done - located) * 1e-6,
            },
            platform if self._config.method == "filter" else (),
            len(frame),
            settled.used,
            settled.refused,
        )

    def _unless_still(
        self, frame: DetectionFrame, camera: CameraModel, pose: CameraPose, local: LocalMap
    ) -> CameraPose | Reason:
        """Return the pose, or why boxes are refused: picture or telemetry only repeats itself."""
        if self._frame_of_map is None or self._frame_of_map.local is not local:
            self._frame_of_map = MapFrame(local)
        in_map = self._frame_of_map.pose(pose)
        if self._standstill.telemetry_frozen(pose.stamp_ns, in_map):
            self._log.warn_once(
                "telemetry stands",
                "All telemetry stopped dead in a motion and repeats itself to the last bit: boxes "
                "are refused until it changes (stale_fix). Its source may have frozen.",
            )
            return Reason.STALE_FIX
        if self._standstill.image_frozen(frame, camera, in_map):
            self._log.warn_once(
                "picture stands",
                "Boxes repeat themselves to the last bit while the camera moves: the picture "
                "stands still, and they are refused until it changes (bad_detections).",
            )
            return Reason.BAD_DETECTIONS
        return pose

    def predicted(self, stamp_ns: int) -> FrameResult:
        """Return the robots as a copy of the tracks has them later, by prediction alone."""
        estimates = copy.deepcopy(self._tracking).coast(stamp_ns)
        return FrameResult(stamp_ns, "", estimates, (), self._origin.datum)

    def _tracked(self, seen: PosedFrame, points: WaterPoints) -> WaterPoints:
        """Return the points that names are kept by: the exact ones, whatever is published."""
        if self._config.method != "paper":
            return points
        centers = seen.detections.centers
        exact = localization.locate(
            seen.pose, seen.camera, centers, self._config.noise, self._config
        )
        both = zip(points.reasons, exact.reasons, strict=True)
        return replace(exact, reasons=tuple(one or other for one, other in both))

    def _look_for_crowd(self, count: int) -> None:
        usual = self._crowd.update(count)
        if usual is None:
            return
        self._log.counts["images_crowded"] += 1
        self._log.warn_once(
            "crowd",
            f"An image has {count} boxes, those before it about {usual:.0f}: nearly all must be "
            "false. Those not seen again become no robots; if it goes on, raise "
            "detections.min_score.",
        )

    def _look_for_strangers(self, frame: DetectionFrame, reasons: list[Reason | None]) -> None:
        came = self._strangers.update(frame.class_ids, reasons)
        if came:
            self._log.warn_once(
                "strangers",
                f"All boxes so far are of class {_listed(came)} and refused as wrong_class: "
                f"detections.classes is {_listed(self._config.detections.classes)}; put the names "
                "there that the detector gives to robots.",
            )

    def _camera(self, stamp_ns: int) -> CameraModel | Reason:
        """Return the newest camera not later than an image."""
        if self._fixed_camera is not None:
            return self._corrected(self._fixed_camera)
        entry = self._inputs.cameras.latest(stamp_ns)
        if entry is None:
            return Reason.NO_CAMERA_INFO
        if entry.camera is None:
            return Reason.BAD_CAMERA_INFO
        return self._corrected(entry.camera)

    def _fitting_camera(
        self, given: CameraModel, boxes: DetectionFrame, pose: CameraPose, local: LocalMap
    ) -> CameraModel:
        """Return the camera that an image was taken with: the newest, unless boxes contradict."""

        def misfit(camera: CameraModel) -> float:
            seen = PosedFrame(boxes, camera, pose, self._latency.found)
            points = localization.locate(
                pose, camera, boxes.centers, self._config.noise, self._config
            )
            return copy.deepcopy(self._tracking).misfit(seen, points, local)

        return self._camera_change.update(given, boxes.stamp_ns, misfit)

    def _corrected(self, camera: CameraModel) -> CameraModel:
        """Return a camera with the calibrated focal length; made once for each camera."""
        scale = self._config.calibration.focal_scale
        if scale == 1.0:
            return camera
        if self._scaled is None or self._scaled[0] is not camera:
            self._scaled = camera, scaled_camera(camera, scale)
        return self._scaled[1]

    def _refusal(self, lacking: MissingTelemetry) -> Reason:
        """Return why there is no telemetry; say so where an input is of another time."""
        if lacking.later_s > self._config.max_wait:
            name = str(lacking.reason).removeprefix("no_")
            self._log.warn_once(
                f"later {name}",
                f"The oldest {name} is {lacking.later_s:.1f} s later than an image, which is "
                f"refused ({lacking.reason}). If it came no later, their clocks differ: "
                f"{name}.stamp says whether a message's header or its arrival counts, and a bag "
                "played in a loop has headers that begin again and arrivals that go on.",
            )
        return lacking.reason

    def _pose(self, samples: SceneTelemetry) -> CameraPose | Reason:
        pose = self._posing.pose(samples)
        if self._posing.trouble:
            self._log.warn_once(self._posing.trouble, self._posing.trouble)
        if isinstance(pose, CameraPose) and math.isnan(pose.altitude):
            why = _NO_ALTITUDE[self._config.fix.altitude_datum]
            self._log.warn_once("altitude", f"Published altitudes are NaN: {why}")
        return pose

    def _published(self, update: TrackUpdate, points: WaterPoints) -> tuple[RobotEstimate, ...]:
        """Return the estimates of the configured method.

        With `single` and `paper` the tracker gives the name and the velocity; the position of a
        robot in view is its own point, with the whole covariance of a point used by itself.
        """
        if self._config.method == "filter":
            return update.estimates
        return tuple(
            self._single(estimate, points, update.measured[estimate.robot_id])
            if estimate.robot_id in update.measured
            else estimate
            for estimate in update.estimates
        )

    def _single(self, estimate: RobotEstimate, points: WaterPoints, row: int) -> RobotEstimate:
        assert self._origin.local is not None  # noqa: S101 - a robot is seen from a pose
        latitude, longitude = float(points.latitude[row]), float(points.longitude[row])
        covariance = estimate.covariance.copy()
        covariance[:2, 2:] = covariance[2:, :2] = 0.0
        covariance[:2, :2] = points.covariance[row]
        return replace(
            estimate,
            latitude=latitude,
            longitude=longitude,
            position=self._origin.local.positions([latitude], [longitude])[0],
            covariance=covariance,
        )


def _unused(update: TrackUpdate, row: int) -> Reason | None:
    """Return why a box with a point measured nothing; None if it did."""
    if update.too_fast[row]:
        return Reason.TOO_FAST
    return Reason.GATED if update.gated[row] else None


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(map(repr, names))


def _only(frame: DetectionFrame, rows: list[int]) -> DetectionFrame:
    if len(rows) == len(frame):
        return frame
    return DetectionFrame(
        frame.stamp_ns,
        frame.frame_id,
        frame.centers[rows],
        frame.sizes[rows],
        frame.scores[rows],
        tuple(frame.class_ids[i] for i in rows),
    )


def camera_of(config: EstimatorConfig) -> CameraModel | None:
    """Return the camera that the parameters describe, None where CameraInfo does."""
    camera = config.camera
    if camera.source != "parameters":
        return None
    return CameraModel.from_focal_length(
        camera.focal_length_mm * 1e-3,
        camera.sensor_width_mm * 1e-3,
        None if math.isnan(camera.sensor_height_mm) else camera.sensor_height_mm * 1e-3,
        camera.image_width_px,
        camera.image_height_px,
    )
