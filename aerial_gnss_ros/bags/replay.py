# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drives the estimator with recorded messages: the core that flies, as fast as possible."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.overview import input_lights, overview_text
from aerial_gnss_ros.bags.detect import ImageDetector, detections_message
from aerial_gnss_ros.bags.plan import Plan, make_plan, resolve
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.telemetry.depths import depth_input
from aerial_gnss_ros.core.telemetry.reference_places import reference_input
from aerial_gnss_ros.core.values.errors import CameraError, InputError
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.core.values.rejection import Cause
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.text.sentences import counted

CAMERA_INFO = "camera_info"


@dataclass
class Summary:
    """Statistics of a replay.

    Attributes:
        frames: images with a result, including those without boxes.
        detections_from: source of the boxes, in words.
        positions: rows for each robot, by robot_id.
        coasting: those of `positions` that were predicted, as the image did not show the robot.
        boxes: detections of the images with a result.
        used: detections that updated robots; the others are refused.
        rejections: refused detections by reason.
        causes: `unconfirmed` detections by the reason why their tracks were not confirmed.
        interval_s: usual time between images, s; 0 with fewer than two.
        images_refused: images that could not be decoded.
        images_dropped: images out of order or with a repeated stamp, by reason.
        notes: sentences for the user.
    """

    frames: int = 0
    detections_from: str = ""
    positions: Counter[str] = field(default_factory=Counter)
    coasting: Counter[str] = field(default_factory=Counter)
    boxes: int = 0
    used: int = 0
    rejections: Counter[str] = field(default_factory=Counter)
    causes: Counter[Cause] = field(default_factory=Counter)
    interval_s: float = 0.0
    images_refused: int = 0
    images_dropped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def add(self, result: FrameResult) -> None:
        """Count one image's result."""
        self.frames += 1
        self.positions.update(estimate.robot_id for estimate in result.estimates)
        self.coasting.update(
            estimate.robot_id for estimate in result.estimates if estimate.state is State.COASTING
        )
        self.boxes += result.boxes
        self.used += result.used
        refused = (*result.rejections, *result.late)
        self.rejections.update(str(one.reason) for one in refused)
        self.causes.update(one.cause for one in refused if one.cause is not None)


def no_detector(_config: DetectorConfig) -> Detector:
    """Take the place of `load` where bags are known to hold boxes.

    Raises:
        AssertionError: always; the bag holds none.
    """
    raise AssertionError("the bag holds no boxes")


class Replay:
    """One pass over recorded bags.

    Args:
        bag: open.
        config: the estimator's parameters.
        detector_config: names the image topic; `load` loads the model only if needed.
        load: creates the detector.
        namespace: that relative topics were recorded in.
        detect: run the detector even if the bag has detections.
        estimator: to drive; None: a new one.

    Attributes:
        method: filter, single or paper.
        plan: the topics used.
        summary: counts; complete when `results` is exhausted.

    Raises:
        InputError: a topic is missing or has another type.
        ModelError: the model is unusable.
    """

    def __init__(
        self,
        bag: BagReader,
        config: EstimatorConfig,
        detector_config: DetectorConfig,
        load: Callable[[DetectorConfig], Detector],
        *,
        namespace: str = "",
        detect: bool = False,
        estimator: Estimator | None = None,
    ) -> None:
        self.method = config.method
        self._bag = bag
        # A replay neither uses the labels of a later flight nor changes a node's state file.
        self._estimator = estimator or Estimator(replace(config, state_file=""))
        self._feed = Feed(config, self._estimator, self._camera_problem)
        self.plan: Plan = make_plan(
            bag,
            self._feed.subscriptions,
            detector_config.image.topic,
            namespace=namespace,
            detect=detect,
        )
        self.summary = Summary(detections_from="recorded detections")
        self._tell_absent(config, namespace)
        self._images: ImageDetector | None = None
        if self.plan.image_topic is not None:
            detector = load(detector_config)
            self._images = _image_detector(
                detector, self.plan.image_topic, config, namespace, detector_config.image.max_pixels
            )
            self.summary.detections_from = f"images, {detector.name}"
        self._camera_seen = False
        self._area = load_area(config.detections.area)

    def overview(self, result: FrameResult) -> str:
        """Return the JSON text of a result just yielded, with its surroundings."""
        estimator = self._estimator
        complaints = [estimator.complaint, *estimator.health.complaints]
        lights = input_lights(estimator.inputs, complaints)
        seen = estimator.overview(result)
        return overview_text(seen, result.stamp_ns, self._area, lights)

    def _tell_absent(self, config: EstimatorConfig, namespace: str) -> None:
        """Say which depths and references the bag lacks: nothing else would show it."""
        without = {
            depth_input(name): "which depth.topics names: robots count as deep as depth.robots_m "
            "and depth.classes say."
            for name in config.depth.by_topic()
        }
        for one in config.references:
            without[reference_input(one.name)] = (
                f"which references.{one.name}.topic names: nothing refers to it."
            )
        for subscription in self._feed.subscriptions:
            topic, why = resolve(subscription.topic, namespace), without.get(subscription.name)
            if why is not None and topic not in self.plan.routes:
                self.summary.notes.append(f"The bag has no messages on {topic}, {why}")

    @property
    def message_count(self) -> int:
        """Number of messages to read."""
        return sum(self._bag.topics[name].count for name in self.plan.topics)

    def results(
        self,
        on_message: Callable[[int], None] = lambda _done: None,
        on_detections: Callable[[int, dict[str, Any]], None] = lambda _log_ns, _fields: None,
    ) -> Iterator[FrameResult]:
        """Yield one result for each image, in order of completion.

        Args:
            on_message: called with the number of messages read so far.
            on_detections: called with log time and fields of each detected array.

        Raises:
            InputError: a bag is damaged, the first images or CameraInfo are unusable, or the
                configured origin of map is too far from the flight.
        """
        last: FrameResult | None = None
        stamps_ns: list[int] = []
        for result in self._all_results(on_message, on_detections):
            if last is not None:
                yield self._counted(last)
            last = result
            stamps_ns.append(result.stamp_ns)
        if last is not None:  # only now the last boxes are decided
            yield self._counted(replace(last, late=(*last.late, *self._estimator.ending)))
        if len(stamps_ns) > 1:
            self.summary.interval_s = float(np.median(np.diff(stamps_ns))) * 1e-9

    def _all_results(
        self,
        on_message: Callable[[int], None],
        on_detections: Callable[[int, dict[str, Any]], None],
    ) -> Iterator[FrameResult]:
        for done, recorded in enumerate(self._bag.messages(self.plan.topics), start=1):
            message = recorded.message()
            if recorded.topic == self.plan.image_topic:
                self._detect(message, recorded.log_ns, on_detections)
            else:
                self._take(recorded.topic, message, recorded.log_ns)
            yield from self._estimator.advance(recorded.log_ns)
            self._check()
            on_message(done)
        if self._images is not None:
            self._images.check()
        yield from self._estimator.flush()
        self._check()
        self.summary.images_dropped.update(self._estimator.dropped)
        self.summary.notes += self._estimator.take_events()
        if self._images is not None and self._images.refused:
            self.summary.images_refused = self._images.refused
            self.summary.notes += [
                f"{counted(count, 'image')} skipped: {why}"
                for why, count in self._images.refusals.items()
            ]

    def _check(self) -> None:
        """Raise an error if the configuration cannot give positions."""
        if self._estimator.failure:
            raise InputError(self._estimator.failure)

    def _take(self, topic: str, message: Any, log_ns: int) -> None:
        subscription = self.plan.routes[topic]
        if subscription.name == CAMERA_INFO and self._images is not None:
            self._images.camera_size.update(message)
        subscription.handle(message, log_ns)
        self._camera_seen = self._camera_seen or subscription.name == CAMERA_INFO

    def _detect(
        self, message: Any, log_ns: int, on_detections: Callable[[int, dict[str, Any]], None]
    ) -> None:
        fields = None if self._images is None else self._images.detect(message)
        if fields is not None:
            on_detections(log_ns, fields)
            self.plan.detections.handle(detections_message(fields), log_ns)

    def _counted(self, result: FrameResult) -> FrameResult:
        self.summary.add(result)
        return result

    def _camera_problem(self, sentence: str) -> None:
        """Raise an error if the first CameraInfo is unusable; report later ones."""
        if not self._camera_seen:
            raise CameraError(sentence)
        self.summary.notes.append(sentence)


def _image_detector(
    detector: Detector, topic: str, config: EstimatorConfig, namespace: str, max_pixels: int
) -> ImageDetector:
    """Return the detector of recorded images, which refuses those not of the camera's size."""
    camera = config.camera
    if camera.source == "topic":
        return ImageDetector(detector, topic, resolve(camera.topic, namespace), max_pixels)
    described = "camera.image_width_px and camera.image_height_px"
    images = ImageDetector(detector, topic, described, max_pixels)
    images.camera_size.size = (camera.image_width_px, camera.image_height_px)
    return images
