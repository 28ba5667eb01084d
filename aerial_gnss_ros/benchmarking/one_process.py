# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The pipeline in one process, as fast as possible: image messages in, position messages out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.results import detection_array, result_messages
from aerial_gnss_ros.adapters.stamps import copied_header
from aerial_gnss_ros.bags.detect import detections_message
from aerial_gnss_ros.bags.plan import Plan, make_plan
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.benchmarking.loop import Loop
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.simulation.sensors import START_NS

WARM_UP = 10
"""Number of images before the measurement, to fill buffers and caches."""


@dataclass
class Run:
    """Measurements of one run.

    Attributes:
        samples_ms: duration of each stage for each image.
        wall_s: all stages of all images together, s.
        processor_s: CPU time of all cores, s.
        images: how many.
        positions: published in all.
    """

    samples_ms: dict[str, list[float]] = field(default_factory=dict)
    wall_s: float = 0.0
    processor_s: float = 0.0
    images: int = 0
    positions: int = 0

    def add(self, stage: str, milliseconds: float) -> None:
        """Add the duration of a stage for one image."""
        self.samples_ms.setdefault(stage, []).append(milliseconds)


class OneProcess:
    """The whole pipeline without nodes.

    Args:
        plan: topics of the inputs.
        estimator: to drive.
        detector: detects the boxes.
        serialise: makes a message of type and fields, and bytes of it.
    """

    def __init__(
        self,
        plan: Plan,
        estimator: Estimator,
        detector: Detector,
        serialise: Callable[[str, dict[str, Any]], Any],
    ) -> None:
        self._plan, self._estimator, self._detector = plan, estimator, detector
        self._serialise = serialise
        self._run = Run()
        self._estimate_ms = 0.0

    def run(self, loop: Loop, images: int, report: Callable[[int], None]) -> Run:
        """Process some images after a warm-up, and return the measurements."""
        done = -WARM_UP
        for moment in loop.moments():
            message = moment.entry.message(START_NS + moment.stamp_ns)  # reading does not count
            is_image, now_ns = loop.is_image(moment), START_NS + moment.due_ns
            if is_image and done == images:
                break
            if is_image and done == 0:
                self._run = Run()
            started, processor = time.perf_counter(), time.process_time()
            if is_image:
                self._see(message, now_ns)
            else:
                self._take(moment.entry.topic, message, now_ns)
            self._run.wall_s += time.perf_counter() - started
            self._run.processor_s += time.process_time() - processor
            if is_image:
                done += 1
                report(max(0, done))
        self._run.images = images
        return self._run

    def _take(self, topic: str, message: Any, now_ns: int) -> None:
        started = time.perf_counter()
        self._plan.routes[topic].handle(message, now_ns)
        self._estimate_ms += 1e3 * (time.perf_counter() - started)
        self._advance(now_ns)

    def _see(self, message: Any, now_ns: int) -> None:
        started = time.perf_counter()
        image = decode(message)
        decoded = time.perf_counter()
        found = self._detector.detect(image)
        self._run.add("decode", 1e3 * (decoded - started))
        for stage, milliseconds in found.timings_ms.items():
            self._run.add(stage, milliseconds)
        started = time.perf_counter()
        boxes = detections_message(detection_array(found, copied_header(message.header)))
        made = time.perf_counter()
        self._run.add("publish boxes", 1e3 * (made - started))
        self._plan.detections.handle(boxes, now_ns)
        self._estimate_ms += 1e3 * (time.perf_counter() - made)
        self._advance(now_ns)

    def _advance(self, now_ns: int) -> None:
        started = time.perf_counter()
        results = self._estimator.advance(now_ns)
        self._estimate_ms += 1e3 * (time.perf_counter() - started)
        for result in results:
            self._run.add("estimate", self._estimate_ms)
            self._estimate_ms = 0.0
            self._publish(result)

    def _publish(self, result: FrameResult) -> None:
        started = time.perf_counter()
        for outgoing in result_messages(result):
            self._serialise(outgoing.msgtype, outgoing.fields)
        self._run.add("publish", 1e3 * (time.perf_counter() - started))
        self._run.positions += len(result.estimates)


def plan_and_estimator(
    bag: BagReader, config: EstimatorConfig, image_topic: str
) -> tuple[Plan, Estimator]:
    """Return the topics to play from a bag, and the estimator that they feed.

    Raises:
        InputError: a topic is missing or has another type.
    """
    estimator = Estimator(config)
    feed = Feed(config, estimator, lambda _sentence: None)
    return make_plan(bag, feed.subscriptions, image_topic, detect=True), estimator
