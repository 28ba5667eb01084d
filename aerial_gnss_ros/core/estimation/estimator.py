# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator: from detections and telemetry to robots, for live nodes and replay.

Inputs are added in any order as they arrive; `advance` gets the time and returns the results that
are complete, in the order of the images' stamps (see `FrameProcessor`). Every image gives exactly
one result, including its refused boxes, except images older than the last one processed, which are
dropped and counted in `dropped`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.frame_processor import FrameProcessor
from aerial_gnss_ros.core.estimation.health import Health, RobotSummary, summary
from aerial_gnss_ros.core.estimation.intake import Intake
from aerial_gnss_ros.core.estimation.origin_file import OriginKeeper
from aerial_gnss_ros.core.estimation.overview import overview
from aerial_gnss_ros.core.estimation.published_tracks import PublishedTracks
from aerial_gnss_ros.core.estimation.state_file import NameKeeper
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.input_status import InputStatus
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.overview import Overview
from aerial_gnss_ros.core.values.rejection import Cause, Input, Reason, Rejection
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


class Estimator:
    """Tracks robots over time.

    Args:
        config: all parameters.
        tracking: a tracker that replaces the default one (see `Tracking`).
        session: file that keeps labels over a restart of the node if `state_file` is empty; the
            origin of `map` is kept beside it.

    Attributes:
        dropped: images that gave no result: `duplicate` stamp, `out_of_order` (older than the last
            one processed), `wrong_stamp` (an outlier), or `no_stamp` (0: never filled in).

    Raises:
        ConfigError: the state file is damaged or its folder is missing.
        CameraError: the camera given by parameters is unusable.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        tracking: Tracking | None = None,
        session: Path | None = None,
    ) -> None:
        self.dropped: Counter[str] = Counter()
        self._log = log = Events()
        self._config = config
        names, kept_origin = NameKeeper(config.state_file, log, session), OriginKeeper(session)
        labels = Labels(config, names.load(), log)
        self._inputs = inputs = TelemetryBuffers(config)
        self._origin = MapOrigin(config, inputs.constant_fix, log, kept_origin.load())
        self._tracks = PublishedTracks(config, inputs, self._origin, labels, log, tracking)
        self._time = TimeBase()
        self._frames = FrameProcessor(
            config,
            inputs,
            self._origin,
            self._tracks,
            self._time,
            names,
            kept_origin,
            self.dropped,
            log,
        )
        self._intake = Intake(config, inputs, self._time, self.dropped, log, self._frames)
        self._results = self._frames.results

    def wrap_tracking(self, wrap: Callable[[Tracking], Tracking]) -> None:
        """Put something around the tracker that sees what it is given and returns.

        It is called again where the estimator begins anew with another tracker.
        """
        self._tracks.wrap_tracking(wrap)

    @property
    def events(self) -> list[str]:
        """Sentences for the log, the oldest first; `take_events` empties it."""
        return self._log.sentences

    def take_events(self) -> list[str]:
        """Return the sentences for the log and clear them."""
        return self._log.drain()

    @property
    def counts(self) -> Counter[Reason]:
        """Refused detections by reason."""
        return self._results.counts

    @property
    def causes(self) -> Counter[Cause]:
        """`unconfirmed` detections by the reason why their tracks were not confirmed."""
        return self._results.causes

    @property
    def boxes(self) -> int:
        """Detections of all images with a result."""
        return self._results.boxes

    @property
    def used(self) -> int:
        """Number of `boxes` that updated robots; some are undecided until `flush`."""
        return self._results.used

    @property
    def ending(self) -> tuple[Rejection, ...]:
        """Detections that `flush` decided after the last result."""
        return self._results.ending

    @property
    def happened(self) -> Counter[str]:
        """Counts of events: time went backward, the drone's position jumped, and so on."""
        return self._log.counts

    @property
    def failure(self) -> str:
        """Why the configuration gives no positions, a sentence; empty if it does."""
        return self._origin.trouble

    @property
    def min_score(self) -> float:
        """Boxes with a lower score are refused."""
        return self._tracks.pipeline.boxes.min_score

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Use another configuration from the next image on; robots keep labels and positions.

        What differs may be: score, classes and area of `detections`, `tracks.confirm_score`,
        `classes`, `references`, `calibration` and `camera.latency_s`. A calibration moves robots as
        `recalibration` derives; images that wait are processed with the new one. Of a class that is
        refused now, robots are predicted until their tracks end. The level of the water is added by
        `add_water_level`.

        Raises:
            ConfigError: the area of operation cannot be read; nothing has changed.
        """
        area = load_area(config.detections.area)
        self._config = config
        self._inputs.reconfigure(config)
        self._intake.expect_references()
        self._tracks.reconfigure(config, area)

    @property
    def inputs(self) -> dict[str, InputStatus]:
        """Status of each input, by its name."""
        return self._intake.statuses(self._frames.patience_ns)

    @property
    def robots(self) -> tuple[RobotSummary, ...]:
        """The robots at the last image, ordered by label."""
        return tuple(summary(estimate) for estimate in self._results.robots)

    @property
    def health(self) -> Health:
        """Consistency of the stated sensor noise with the measurements."""
        monitor = self._tracks.pipeline.monitor
        return Health(monitor.fit, monitor.complaints, self._results.platform)

    @property
    def complaint(self) -> str:
        """Why most boxes are refused, a sentence; empty if most update robots."""
        return self._results.complaint

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""
        self._intake.add_fix(fix)

    def add_attitude(self, attitude: Orientation) -> None:
        """Add an orientation of the body."""
        self._intake.add(Input.ATTITUDE, attitude)

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Add an orientation of the camera."""
        self._intake.add(Input.GIMBAL, gimbal)

    def add_height(self, height: Scalar) -> None:
        """Add a height of the drone."""
        self._intake.add(Input.HEIGHT, height)

    def add_water_level(self, level: Scalar) -> None:
        """Add a water level, valid until replaced."""
        self._intake.add_water_level(level)

    def add_depth(self, class_id: str, depth: Scalar) -> None:
        """Add a depth that robots of a class send (empty: all); it is valid for a while."""
        self._intake.add_depth(class_id, depth)

    def add_reference(self, name: str, fix: Fix) -> None:
        """Add a position sent by a reference."""
        self._intake.add_reference(name, fix)

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Add the camera model; None if it was unusable."""
        self._intake.add_camera(stamp_ns, camera)

    def refuse(self, name: str, trouble: str) -> None:
        """Count an unreadable message.

        Args:
            name: of the input.
            trouble: why, in words.
        """
        self._intake.refuse(name, trouble)

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add one image's boxes, which `advance` processes."""
        self._intake.add_detections(frame)

    def advance(self, now_ns: int, steady_ns: int | None = None) -> list[FrameResult]:
        """Return the results that are due, in the order of their images' stamps.

        Args:
            now_ns: the node's clock, or the bag's log time; only its differences count.
            steady_ns: a monotonic clock, if there is one: gives the elapsed time when the node's
                clock is set together with all stamps.
        """
        self._intake.tick(now_ns, steady_ns)
        return self._frames.advance(now_ns)

    def predicted(self, stamp_ns: int) -> FrameResult | None:
        """Return the robots predicted without an image; the state is not changed.

        A waiting image will have its own result. To keep stamps in order, the prediction is for a
        time before it.

        Args:
            stamp_ns: time of the prediction, on the images' clock, ns.

        Returns:
            The coasting robots, without those lost by then; None if no image was processed, or no
            time is free before a waiting image.
        """
        return self._frames.predicted(stamp_ns)

    def overview(self, result: FrameResult) -> Overview:
        """Return a recent result with its surroundings, for people; the state is not changed."""
        return overview(result, self._inputs, self._config, self._time.shift_ns)

    def flush(self) -> list[FrameResult]:
        """Return results for all waiting images at the end of input (end of a bag)."""
        self._intake.arrivals.flush()
        return self._frames.flush()
