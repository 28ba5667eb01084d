# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator: from detections and telemetry to robots, for live nodes and replay.

Inputs are added in any order as they arrive; `advance` gets the time and returns the results that
are complete, in the order of the images' stamps. An image waits until telemetry brackets its scene,
at most `max_wait` from the first `advance` after its arrival (longer by a negative latency, whose
telemetry arrives later). Every image gives exactly one result, including its refused boxes, except
images older than the last one processed, which are dropped and counted in `dropped`.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.estimation.found_again import FoundAgain
from aerial_gnss_ros.core.estimation.guard import Guard
from aerial_gnss_ros.core.estimation.health import Health, RobotSummary, summary
from aerial_gnss_ros.core.estimation.image_queue import ImageQueue
from aerial_gnss_ros.core.estimation.intake import Intake
from aerial_gnss_ros.core.estimation.latency_doubt import LatencyDoubt
from aerial_gnss_ros.core.estimation.latency_trial import LatencyTrial
from aerial_gnss_ros.core.estimation.origin_file import OriginKeeper
from aerial_gnss_ros.core.estimation.overview import overview
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.recent_images import SeenImage
from aerial_gnss_ros.core.estimation.state_file import NameKeeper
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.identity.labels import Box, Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.input_status import InputStatus
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.telemetry.steady import Steady
from aerial_gnss_ros.core.tracker.box_account import complaint
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.events import Events, WarningText
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
        counts: refused detections by reason.
        causes: `unconfirmed` detections by the reason why their tracks were not confirmed.
        boxes: detections of all images with a result.
        used: number of these that updated robots; some are undecided until `flush`.
        ending: detections that `flush` decided after the last result.
        dropped: images that gave no result: `duplicate` stamp, `out_of_order` (older than the last
            one processed), or `wrong_stamp` (an outlier).
        events: sentences for the log, the oldest first; `take_events` empties it.
        min_score: boxes below are refused.

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
        self.counts: Counter[Reason] = Counter()
        self.causes: Counter[Cause] = Counter()
        self.boxes = self.used = 0
        self.ending: tuple[Rejection, ...] = ()
        self.dropped: Counter[str] = Counter()
        self._log = Events()
        self._config = config
        self._names = NameKeeper(config.state_file, self._log, session)
        self._identity = Labels(config, self._names.load(), self._log)
        self._inputs = TelemetryBuffers(config)
        self._keeps_files = bool(config.state_file or session)
        self._kept_origin = OriginKeeper(session)
        self._origin = MapOrigin(
            config, self._inputs.constant_fix, self._log, self._kept_origin.load()
        )
        self._pipeline = Pipeline(
            config,
            self._inputs,
            tracking or Tracker(config, self._identity, self._log),
            self._origin,
            self._log,
        )
        self._guard = self._new_guard()
        self._behind: deque[DetectionFrame] = deque()
        self._pending: set[Box] = set()
        finds = config.camera.find_latency and tracking is None
        searches = config.noise.value("latency_s") > 0.0
        self._doubt = LatencyDoubt(config, self._inputs) if finds and not searches else None
        self._time = TimeBase()
        self._intake = Intake(config, self._inputs, self._time, self.dropped, self._log, self)
        self._steady = Steady()
        self._image_steady_ns: int | None = None
        self._found_again = FoundAgain()
        self._images = ImageQueue(self._patience_ns, self.dropped)
        self._ready: list[FrameResult] = []
        self._newest_image_ns: int | None = None
        self._wrap: Callable[[Tracking], Tracking] = _as_it_is
        self._estimates: tuple[RobotEstimate, ...] = ()
        self._platform: tuple[PlatformError, ...] = ()

    def wrap_tracking(self, wrap: Callable[[Tracking], Tracking]) -> None:
        """Put something around the tracker that sees what it is given and returns.

        It is called again where the estimator begins anew with another tracker.
        """
        self._wrap = wrap
        self._pipeline.tracking = wrap(self._pipeline.tracking)

    def _new_guard(self) -> Guard:
        return Guard(self._pipeline, self._identity, self._origin, self._log)

    @property
    def events(self) -> list[str]:
        """Sentences for the log, not drained yet."""
        return self._log.sentences

    def take_events(self) -> list[str]:
        """Return the sentences for the log and clear them."""
        return self._log.drain()

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
        return self._pipeline.boxes.min_score

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
        if self._doubt is not None:
            config = self._doubt.reconfigure(config)
        self._config = config
        self._inputs.reconfigure(config)
        self._intake.expect_references()
        self._pipeline.reconfigure(config, area)

    @property
    def _patience_ns(self) -> int:
        """Longest wait of an image for telemetry of its scene, ns: from the scene's time on."""
        config, scene_ns = self._config, self._pipeline.latency.scene_ns
        late_s = max(0.0, config.fix.latency_s, config.height.latency_s)
        return round((config.max_wait + late_s) * 1e9) + max(0, -scene_ns)

    @property
    def inputs(self) -> dict[str, InputStatus]:
        """Status of each input, by its name."""
        return self._intake.statuses(self._newest_image_ns, self._patience_ns)

    @property
    def robots(self) -> tuple[RobotSummary, ...]:
        """The robots at the last image, ordered by label."""
        return tuple(summary(estimate) for estimate in self._estimates)

    @property
    def health(self) -> Health:
        """Consistency of the stated sensor noise with the measurements."""
        monitor = self._pipeline.monitor
        return Health(monitor.fit, monitor.complaints, self._platform)

    @property
    def complaint(self) -> str:
        """Why most boxes are refused, a sentence; empty if most update robots."""
        return complaint(self.used, self.counts, self.causes)

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

    def receive_image(self, frame: DetectionFrame) -> None:
        """Queue an image until telemetry of its scene arrives."""
        if self._newest_image_ns is None or frame.stamp_ns > self._newest_image_ns:
            self._newest_image_ns = frame.stamp_ns
        self._image_steady_ns = self._steady.now_ns
        if self._images.add(self._time.shifted(frame)):
            self._finish_first()

    def advance(self, now_ns: int, steady_ns: int | None = None) -> list[FrameResult]:
        """Return the results that are due, in the order of their images' stamps.

        Args:
            now_ns: the node's clock, or the bag's log time; only its differences count.
            steady_ns: a monotonic clock, if there is one: gives the elapsed time when the node's
                clock is set together with all stamps.
        """
        self._intake.arrivals.tick(now_ns, self._steady.update(now_ns, steady_ns))
        self._images.tick(now_ns)
        self._images.patience_ns = self._patience_ns
        while self._images.waiting:
            if not self._finish_first(self._images.is_late(now_ns)):
                break
        results, self._ready = self._ready, []
        return results

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
        time_ns = self._images.time_before(stamp_ns + self._time.shift_ns)
        if time_ns is None:
            return None
        return self._time.stamped(self._mixed(self._pipeline.predicted(time_ns)))

    def overview(self, result: FrameResult) -> Overview:
        """Return a recent result with its surroundings, for people; the state is not changed."""
        return overview(result, self._inputs, self._config, self._time.shift_ns)

    def flush(self) -> list[FrameResult]:
        """Return results for all waiting images at the end of input (end of a bag)."""
        self._intake.arrivals.flush()
        self._origin.settle()
        while self._images.waiting:
            self._finish_first()
        self._names.save(self._identity, self._time.shift_ns)
        settled = self._pipeline.end()
        self.used += settled.used
        self._count(settled.refused)
        self.ending = self._time.refused(settled.refused)
        results, self._ready = self._ready, []
        return results

    def _count(self, refused: tuple[Rejection, ...]) -> None:
        """Count refused boxes."""
        for one in refused:
            self.counts[one.reason] += 1
            if one.cause is not None:
                self.causes[one.cause] += 1

    def receive_fix(self, fix: Fix) -> str:
        """Pass a usable fix to the map; return why it is still unusable, else empty."""
        before = self._origin.local
        lasted_s = self._inputs.plausibility.agreed_s
        trouble = self._origin.accept(fix, lasted_s, bool(self._estimates))
        if before is not None and self._origin.local is not before:
            self._pipeline.reset()
            if self._doubt is not None:
                self._doubt.forget_images()
        return trouble

    def begin_elsewhere(self, moved: str) -> None:
        """End all tracks after the drone turned out to be elsewhere.

        Its earlier or its new position was wrong, and with it all positions of robots from there.

        Args:
            moved: the change, in words.
        """
        robots = bool(self._estimates)
        self._forget_robots()
        self._log.counts["began_elsewhere"] += 1
        ended = ": tracks are cleared, and robots get new labels" if robots else ""
        self._log.add(WarningText(f"{moved}{ended}."))

    def _finish_first(self, final: bool = True) -> bool:
        """Process the oldest image; return False if it must keep waiting."""
        frame = self._images.waiting[0].frame
        scene_ns = frame.stamp_ns - self._pipeline.latency.scene_ns
        samples = attempt(self._inputs.at, scene_ns)  # on failure the image is refused
        if isinstance(samples, MissingTelemetry) and samples.can_arrive and not final:
            return False
        if self._behind:
            self._catch_up()
        result = self._guard.result(frame, samples)
        seen = self._pipeline.measured
        if self._doubt is not None and seen is not None:
            self._doubt.note(seen[0], self._pipeline.corrects)
        published = self._mixed(result)
        self._images.pop()  # by now: an exception that ends the program leaves it in the queue
        stamped = self._time.stamped(published) if self._time.begins else published
        self._estimates = stamped.estimates
        self._platform = result.platform or self._platform
        self.boxes += result.boxes
        self.used += result.used
        if result.rejections or result.late:
            self._count((*result.rejections, *result.late))
        self._ready.append(stamped)
        if self._keeps_files:
            self._keep_names(result)
        if self._doubt is not None and self._doubt.active:
            self._weigh_latency(self._doubt, frame)
        if self._found_again.names and self._found_again.failed(result):
            self._log.add(
                "Robots are not detected where they were before time was reset: it is another "
                "scene, tracks are cleared, and robots get new labels."
            )
            self._forget_robots()
        return True

    def _mixed(self, result: FrameResult) -> FrameResult:
        """Return a result with what another latency would make of it."""
        return result if self._doubt is None else self._doubt.mixed(result, self._origin.local)

    def _weigh_latency(self, doubt: LatencyDoubt, frame: DetectionFrame) -> None:
        """Estimate the latency from now on if it seems to be another one."""
        local, seen = self._origin.local, self._pipeline.measured
        measured = None
        if local is not None and seen is not None and seen[0].detections.stamp_ns == frame.stamp_ns:
            measured = seen[1]
            if frame.stamp_ns >= doubt.due_ns and attempt(doubt.update, *seen, local) is not None:
                doubt.close()
                return
        image = SeenImage(frame, measured, self._pipeline.corrects)
        found = attempt(doubt.try_another, image, self._origin, self._identity)
        if isinstance(found, Exception):
            doubt.close()
        elif found is not None:
            self._take_over(found, doubt.unknown)
            self._say_latency(doubt.stamped_seldom)

    def _take_over(self, trial: LatencyTrial, config: EstimatorConfig) -> None:
        """Publish what was tracked with another latency from the next image on."""
        trial.adopt_labels()
        settled = trial.settled(self._pipeline.end())
        self.used += settled.used
        self._count(settled.refused)
        late = self._time.refused(settled.refused)
        last = self._ready[-1]
        self._ready[-1] = replace(last, used=last.used + settled.used, late=(*last.late, *late))
        trial.log.join(self._log)
        self._config, self._identity, self._pipeline = config, trial.identity, trial.pipeline
        self._pipeline.tracking = self._wrap(self._pipeline.tracking)
        self._behind = deque(image.frame for image in trial.waiting)
        self._pending = trial.pending
        self._guard = self._new_guard()

    def _say_latency(self, stamped_seldom: bool) -> None:
        """Say once that the latency is estimated, and why."""
        if self._log.counts["latency_doubted"]:
            return
        self._log.counts["latency_doubted"] += 1
        why = "Boxes do not fit camera.latency_s"
        if stamped_seldom:
            why = "Telemetry has the stamps of images that are far apart, and is late by up to that"
        self._log.add(
            f"{why}: the latency of the images is estimated from now on, and positions are as "
            "uncertain as that makes them. State camera.latency_s if you know it."
        )

    def _catch_up(self) -> None:
        """Take in images that were published with the configured latency, in the right order."""
        behind, self._behind = self._behind, deque()
        for frame in behind:
            scene_ns = frame.stamp_ns - self._pipeline.latency.scene_ns
            self._guard.result(frame, attempt(self._inputs.at, scene_ns))
        self._pipeline.tracking.keep_pending(self._pending)

    def _keep_names(self, result: FrameResult) -> None:
        """Save labels if due; positions matter more than the file."""

        def keep() -> None:
            self._kept_origin.keep(result.datum)
            self._names.keep(result, self._identity, self._time.shift_ns)

        error = attempt(keep)
        if error is not None:
            self._log.warn_once(
                "state_file", f"state_file cannot be written ({type(error).__name__}: {error})."
            )

    def reset_time(self, decision: Decision) -> None:
        """Discard what precedes a reset of time or of an input's clock."""
        if not decision.time_reset:
            self._inputs.forget(decision.moved)
            self._log.add(f"{decision}; its earlier telemetry is discarded.")
            return
        while self._images.waiting:
            self._finish_first()
        by_ns = self._moved_ns(decision)
        if by_ns is None or self._pipeline.latency.searches:
            cleared = "telemetry and tracks are cleared, and robots get new labels"
            self._inputs.clear(decision.kept)
            self._forget_robots()
            self._time.reset()
            self._images.last_ns = None
        else:
            cleared = "telemetry is cleared; robots that are where they were keep their labels"
            self._inputs.clear()
            if self._doubt is not None:
                self._doubt.forget_images()
            self._time.step(by_ns, self._images.last_ns or 0)
            self._found_again.expect(self._estimates)
        self._newest_image_ns = None
        for tally in self._intake.tallies.values():
            tally.reset_stamps()
        self._log.counts[f"time_went_{'backward' if decision.by_ns < 0 else 'forward'}"] += 1
        self._log.add(f"{decision}: {cleared}.")

    def _moved_ns(self, decision: Decision) -> int | None:
        """Return the step of stamps beyond the elapsed time, ns; None: unknown."""
        by_ns = decision.by_ns
        if not decision.timed:
            passed_s = self._steady.since_s(self._image_steady_ns)
            if not decision.stepped or passed_s is None:
                return None
            by_ns -= round(passed_s * 1e9)
        if self._images.last_ns is None:
            return None
        # Arrivals vary, but the first image is after the last one in any case.
        return min(by_ns, decision.first_ns + self._time.shift_ns - self._images.last_ns - 1)

    def _forget_robots(self) -> None:
        if self._doubt is not None and self._doubt.active:
            self._doubt.reset()
        self._behind.clear()
        self._found_again.reset()
        self._pipeline.reset()
        self._guard.reset()
        self._identity.release()
        self._names.reset()
        self._estimates, self._platform = (), ()


def _as_it_is(tracking: Tracking) -> Tracking:
    return tracking
