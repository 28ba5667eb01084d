# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tracks that are published: the configured latency's, or another's once it is found right.

`LatencyDoubt` weighs whether images come by another latency than configured, and tries that one
beside. What follows for what is published is here: the mixture of both while it is undecided, and
the other tracks alone from the image after it is found right.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.area_of_operation import Polygon
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.estimation.fix_latency_doubt import FixLatencyDoubt
from aerial_gnss_ros.core.estimation.guard import Guard
from aerial_gnss_ros.core.estimation.latency_doubt import LatencyDoubt
from aerial_gnss_ros.core.estimation.latency_trial import LatencyTrial
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.recent_images import RecentImages, SeenImage
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import Box, Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.events import Events

_UNTOLD = (
    "Images have not told yet whether camera.latency_s is right: until they do, covariances "
    "contain others of up to 3 s either way, all together with a chance of one in ten. Change "
    "speed or direction, or set camera.find_latency to false if images and telemetry are stamped "
    "by one clock."
)


class PublishedTracks:
    """Tracks robots from image to image.

    Args:
        config: all parameters.
        inputs: telemetry buffers.
        origin: of `map`.
        labels: of the robots.
        log: receives sentences.
        tracking: a tracker that replaces the default one; its latency is not doubted.

    Attributes:
        pipeline: turns images into results.
        labels: of its robots.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        origin: MapOrigin,
        labels: Labels,
        log: Events,
        tracking: Tracking | None = None,
    ) -> None:
        self._config = config
        self._inputs, self._origin, self._log = inputs, origin, log
        self.labels = labels
        tracker = tracking or Tracker(config, labels, log)
        self.pipeline = Pipeline(config, inputs, tracker, origin, log)
        self._guard = self._new_guard()
        self._behind: deque[DetectionFrame] = deque()
        self._pending: set[Box] = set()
        self._recent = RecentImages()
        self._replaced, self._corrected = tracking is not None, False
        self.doubt_latencies()
        self._wrap: Callable[[Tracking], Tracking] = _as_it_is

    def doubt_latencies(self) -> None:
        """Ask whether latencies are as configured, from now on."""
        config, self._doubt, self._fix_doubt = self._config, None, None
        if self._replaced or config.noise.value("latency_s") > 0.0:
            return
        if config.camera.find_latency:
            self._doubt = LatencyDoubt(config, self._inputs, self._recent)
        if config.fix.find_latency and config.fix.source == "topic":
            self._fix_doubt = FixLatencyDoubt(config, self._inputs)

    def wrap_tracking(self, wrap: Callable[[Tracking], Tracking]) -> None:
        """Put something around the tracker, and around the one that may follow it."""
        self._wrap = wrap
        self.pipeline.tracking = wrap(self.pipeline.tracking)

    def reconfigure(self, config: EstimatorConfig, area: tuple[Polygon, ...]) -> None:
        """Use another configuration from the next image on; a latency that was found stays.

        Args:
            config: differs in parameters that may be changed in flight.
            area: its area of operation.
        """
        if self._doubt is not None:
            config = self._doubt.reconfigure(config)
        if self._fix_doubt is not None:
            self._fix_doubt.reconfigure(config)
        self._config = config
        self.pipeline.reconfigure(config, area)

    def telemetry(self, frame: DetectionFrame) -> SceneTelemetry | MissingTelemetry | Exception:
        """Return the telemetry of an image's scene, what is missing, or why it cannot be used."""
        return attempt(self._inputs.at, frame.stamp_ns - self.pipeline.latency.scene_ns)

    def result(
        self, frame: DetectionFrame, samples: SceneTelemetry | MissingTelemetry | Exception
    ) -> FrameResult:
        """Return the result of an image; see `Guard.result`."""
        if self._behind:
            self._catch_up()
        result = self._guard.result(frame, samples)
        seen = self.pipeline.measured
        if self._doubt is not None and seen is not None:
            self._doubt.note(seen[0], self.pipeline.corrects)
        if self._fix_doubt is not None and seen is not None:
            self._fix_doubt.note(seen[0], self.pipeline.corrects)
        return self._mixed(result)

    def predicted(self, stamp_ns: int) -> FrameResult:
        """Return robots predicted to a later time; the state is not changed."""
        return self._mixed(self.pipeline.predicted(stamp_ns))

    def weigh_latency(self, frame: DetectionFrame) -> Settled:
        """Change to the tracks of another latency if that seems right by the last image.

        So it does if telemetry was wrong until then.

        Args:
            frame: the last image.

        Returns:
            Decisions on boxes that were pending with the former tracks.
        """
        local, seen = self._origin.local, self.pipeline.measured
        if local is None or seen is None or seen[0].detections.stamp_ns != frame.stamp_ns:
            seen, image = None, SeenImage(frame, None, self.pipeline.corrects)
        else:
            image = SeenImage(seen[0].detections, seen[1], self.pipeline.corrects)
        self._recent.add(image)
        if self._corrected:
            return self._follow_correction()
        if seen is not None and local is not None:
            if self._weigh_fix_latency(image, seen[0], local):
                return self._follow_fix_latency()
            self._weigh_image_latency(seen, local)
        return self._try_another(image)

    def _weigh_image_latency(
        self, seen: tuple[PosedFrame, dict[str, int]], local: LocalMap
    ) -> None:
        """Weigh the latency of the images by the last one, if it is due."""
        doubt = self._doubt
        if doubt is None or not doubt.active or seen[0].detections.stamp_ns < doubt.due_ns:
            return
        failed = attempt(doubt.update, *seen, local, self._fix_nats)
        if failed is not None:
            doubt.close()
        elif doubt.long_open:
            self._log.warn_once("latency untold", _UNTOLD)

    def _try_another(self, image: SeenImage) -> Settled:
        """Let the tracks of another latency take in an image, and follow them if they are right."""
        doubt = self._doubt
        if doubt is None or not doubt.active:
            return Settled()
        found = attempt(doubt.try_another, image, self._origin, self.labels)
        if isinstance(found, Exception):
            doubt.close()
        elif found is not None:
            settled = self._take_over(found)
            self._say_latency(doubt.odds.stamped_seldom)
            return settled
        return Settled()

    @property
    def _fix_nats(self) -> float:
        """Log odds of another latency of the fix."""
        return -math.inf if self._fix_doubt is None else self._fix_doubt.nats

    def _weigh_fix_latency(self, image: SeenImage, scene: PosedFrame, local: LocalMap) -> bool:
        """Weigh the fix's latency by the last image; return whether another one is used now.

        Args:
            image: as the tracker took it in.
            scene: its boxes and the camera's pose.
            local: the frame `map`.
        """
        doubt, images = self._fix_doubt, self._doubt
        if doubt is None or not doubt.open:
            return False
        if images is not None and (images.doubted or images.odds.stamped_seldom):
            doubt.close()  # all telemetry is late, the fix as well
            return False
        found = attempt(doubt.update, image, scene, local)
        if isinstance(found, Exception):
            doubt.close()
            return False
        return found

    def _follow_fix_latency(self) -> Settled:
        """Go on with another latency of the fix."""
        if self._doubt is not None:
            self._doubt = LatencyDoubt(self._config, self._inputs, self._recent)
        self._log.add(
            f"The fix is {self._inputs.fix_later_ns * 1e-9:.2f} s later than fix.latency_s says, "
            "which is corrected from now on. State fix.latency_s if you know it."
        )
        return self._take_in_again()

    def note_correction(self) -> None:
        """Note that telemetry was wrong, and is right now from the beginning."""
        self._corrected = not self._replaced

    def _follow_correction(self) -> Settled:
        """Go on with telemetry as it is now."""
        self._corrected, self._inputs.fix_later_ns = False, 0
        self.doubt_latencies()
        return self._take_in_again()

    def _take_in_again(self) -> Settled:
        """Take the last images in with telemetry as it is now, and go on from there."""
        search = LatencySearch(self._config, self._inputs)
        given = self._config, self._inputs, self._origin, self.labels
        trial = LatencyTrial(*given, search, self._recent.images)
        trial.take_all()
        return self._take_over(trial)

    def forget_images(self) -> None:
        """Try no latency with the images so far: telemetry or `map` are others now."""
        self._recent.images.clear()
        if self._doubt is not None:
            self._doubt.forget_images()
        if self._fix_doubt is not None:
            self._fix_doubt.forget_images()

    def reset(self) -> None:
        """End all tracks; robots get new labels."""
        self._recent.images.clear()
        if self._doubt is not None and self._doubt.active:
            self._doubt.reset()
        if self._fix_doubt is not None and self._fix_doubt.open:
            self._fix_doubt.reset()
        self._behind.clear()
        self.pipeline.reset()
        self._guard.reset()
        self.labels.release()

    def _new_guard(self) -> Guard:
        return Guard(self.pipeline, self.labels, self._origin, self._log)

    def _mixed(self, result: FrameResult) -> FrameResult:
        """Return a result with what another latency would make of it."""
        if self._fix_doubt is not None:
            result = self._fix_doubt.mixed(result)
        return result if self._doubt is None else self._doubt.mixed(result, self._origin.local)

    def _take_over(self, trial: LatencyTrial) -> Settled:
        """Publish a trial's tracks from the next image on; return what it decides of boxes."""
        trial.adopt_labels()
        settled = trial.settled(self.pipeline.end())
        trial.log.join(self._log)
        self.labels, self.pipeline = trial.identity, trial.pipeline
        self.pipeline.tracking = self._wrap(self.pipeline.tracking)
        self._behind = deque(image.frame for image in trial.waiting)
        self._pending = trial.pending
        self._guard = self._new_guard()
        return settled

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
            self._guard.result(frame, self.telemetry(frame))
        self.pipeline.tracking.keep_pending(self._pending)


def _as_it_is(tracking: Tracking) -> Tracking:
    return tracking
