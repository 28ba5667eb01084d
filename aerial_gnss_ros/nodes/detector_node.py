# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector node: images in, one array of boxes for every processed image out."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

from aerial_gnss_ros.adapters.camera_size import CameraSize
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import copied_header, nanoseconds
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.errors import AerialGnssError, InputError, ModelError
from aerial_gnss_ros.detection.background import begun
from aerial_gnss_ros.detection.base import Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.annotated import ANNOTATED_TYPE, AnnotatedTopic
from aerial_gnss_ros.nodes.diagnostics import OK, STALE, WARN, Status
from aerial_gnss_ros.nodes.inputs import OPTIONAL, Input
from aerial_gnss_ros.nodes.lifecycle import Managed
from aerial_gnss_ros.nodes.memory import give_freed_memory_back
from aerial_gnss_ros.nodes.refusals import Refusals
from aerial_gnss_ros.nodes.ros_messages import message
from aerial_gnss_ros.nodes.schemas import DETECTOR
from aerial_gnss_ros.nodes.supervised import Given, SupervisedNode
from aerial_gnss_ros.nodes.timings import Timings
from aerial_gnss_ros.nodes.worker import WorkEndedError, Worker
from aerial_gnss_ros.text.sentences import counted

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
_LEAVES = {leaf.name: leaf for leaf in leaves(DetectorConfig)}
_AT_START = (
    "autostart", "detections.topic", "annotated.topic", "annotated.rate_hz", "annotated.width_px",
)  # fmt: skip
MOST_FAILURES = 30
"""After this many consecutive failures only a new process can help: a GPU driver's state or
fragmented memory cannot be repaired within this one."""

_LOST_HINT = (
    "it does not send, or its images are lost between the processes: "
    "see docs/howto/image_transport.md"
)


class DetectorNode(Managed, SupervisedNode):
    """Detects robots in images, in its own thread; only the newest waiting image is processed.

    Lifecycle: when configured it holds the network, when active it also subscribes and detects. It
    activates itself unless `autostart` is false.

    Args:
        given: parameter files and namespace.
        load: creates the detector of a configuration.
        meanwhile: load in a separate thread; `begin` waits for it and must be called.

    Attributes:
        timings: milliseconds of each stage.

    Raises:
        AerialGnssError: a parameter or the model cannot be used.
    """

    CHANGEABLE = True

    def __init__(
        self,
        given: Given | None = None,
        load: Callable[[DetectorConfig], Detector] = load_detector,
        *,
        meanwhile: bool = False,
    ) -> None:
        SupervisedNode.__init__(self, DETECTOR, given or Given())
        self._config = detector_config(self.values)
        self._load = load
        self._detector: Detector | None = None
        self._wanted = self._config
        self._early: Future[Detector] | None = None
        self._begun = False
        self._worker: Worker[Any] = Worker(self._attempt)
        self._images: Input | None = None
        self._camera: Input | None = None
        self._camera_size = CameraSize("let the driver publish both in one size")
        self._published = 0
        self._refused = Refusals()
        self._failures = 0
        self.timings = Timings()
        self._image_age_s = float("nan")
        self._publisher = self.announce(
            self._config.detections.topic, DETECTIONS_TYPE, qos.detections()
        )
        self._annotated = AnnotatedTopic(
            self.announce(self._config.annotated.full_topic, ANNOTATED_TYPE, qos.pictures()),
            self._config.annotated,
        )
        self.claim(self._config.detections.topic)
        self.follow(detector_config, self._set_config)
        self.every(0.5, self._fail_if_thread_failed)
        if not meanwhile:
            self.begin()
        elif self._config.autostart:
            config = self._config
            self._early = begun(lambda: load(config), "loading")

    def begin(self) -> None:
        """Activate if `autostart` is true; only with `meanwhile` is anything left to do.

        Raises:
            AerialGnssError: the model cannot be used.
        """
        if self._begun:
            return
        self._begun = True
        self.manage(self._config.autostart)
        if not self._config.autostart:
            self.get_logger().info("waiting for the transitions configure and activate")

    def load(self) -> None:
        """Load the network."""
        early, self._early = self._early, None
        if early is not None and self._wanted == self._config:
            self._detector = early.result()
            return
        self._config = self._wanted
        self._detector = self._load(self._config)

    def start(self) -> None:
        """Subscribe to images, process them, and count from 0: arrivals begin anew, too."""
        self._published, self._refused = 0, Refusals()
        self._worker.start()
        self._subscribe()
        self.get_logger().info(self._start_message())

    def stop(self) -> None:
        """Unsubscribe and end the thread, which finishes its current image first."""
        self._worker.stop()
        for source in (self._images, self._camera):
            if source is not None:
                self.listen_no_more(source)
        self._images = self._camera = None

    def release(self) -> None:
        """Release the network's memory."""
        detector, self._detector = self._detector, None
        close = getattr(detector, "close", None)  # dropping the reference is not enough
        if close is not None:
            close()
        del detector, close
        gc.collect()
        give_freed_memory_back()

    def _subscribe(self) -> None:
        config = self._config
        compressed = config.image.transport == "compressed"
        self._images = self.listen(
            "images",
            config.image.full_topic,
            "sensor_msgs/msg/CompressedImage" if compressed else "sensor_msgs/msg/Image",
            qos.sensor(1),
            self._worker.put,
            hint=_LOST_HINT,
        )
        self._camera = self.listen(
            "camera_info",
            config.camera_info.topic,
            "sensor_msgs/msg/CameraInfo",
            qos.sensor(10),
            self._camera_size.update,
            expected=OPTIONAL,
            sent_once=True,
        )

    def destroy_node(self) -> None:
        """End the thread, then the node."""
        self._worker.stop(timeout_s=5.0)
        super().destroy_node()

    def _attempt(self, msg: Any) -> None:
        """Process an image; a failure does not stop the following ones."""
        try:
            self._process(msg)
        except Exception as error:
            self._failures += 1
            if self._failures >= MOST_FAILURES or not self.context.ok():
                raise
            if isinstance(
                error, ModelError
            ):  # for example out of memory: the next image may succeed
                self._refuse("failed", str(error))
                return
            self._refused.add("internal", f"{type(error).__name__}: {error}", self.steady_ns())
            self.survive(error)

    def _process(self, msg: Any) -> None:
        """Process an image; runs in the worker's thread."""
        self._reload_if_wanted()
        assert self._detector is not None  # noqa: S101 - no thread without a network
        assert self._images is not None  # noqa: S101
        started = time.perf_counter()
        image = self._decoded(msg, self._images.topic)
        if image is None:
            return
        decoded = time.perf_counter()
        found = self._detector.detect(image)
        detected = time.perf_counter()
        fields = detection_array(found, copied_header(msg.header))
        self._publisher.publish(message(DETECTIONS_TYPE, fields))
        self._failures = 0
        ended = time.perf_counter()
        self._annotated.show(image, found, fields["header"], self.steady_ns())
        total = {"decode": (decoded - started) * 1e3, "total": (ended - started) * 1e3}
        publish = {"publish": (ended - detected) * 1e3}
        self.timings.add({**total, **found.timings_ms, **publish})
        self._image_age_s = (self.now_ns() - nanoseconds(msg.header.stamp)) / 1e9
        self._published += 1
        if self._published == 1:
            self.get_logger().info(
                f"first image from {self._images.topic}: {image.shape[1]} x {image.shape[0]}, "
                f"{counted(len(found), 'box')}, {total['total']:.0f} ms"
            )

    def _decoded(self, msg: Any, topic: str) -> Image | None:
        """Return an image of the camera's size, or None if it was refused."""
        try:
            image = decode(msg, self._config.image.max_pixels)
        except InputError as error:
            self._refuse("bad_image", f"{topic}: {error}")
            return None
        described = self.resolve_topic_name(self._config.camera_info.topic)
        refusal = self._camera_size.refusal(image.shape[1], image.shape[0], described)
        if refusal is not None:
            self._refuse(*refusal)
            return None
        return image

    def _refuse(self, reason: str, sentence: str) -> None:
        self._refused.add(reason, sentence, self.steady_ns())
        self.warn_seldom(sentence)

    def fixed(self, name: str) -> str:
        """Return why a parameter cannot be changed now: most can while unconfigured."""
        leaf = _LEAVES.get(name)
        if leaf is None or leaf.key.dynamic:
            return ""
        if name in _AT_START:
            return f"{name} can only be set at the start"
        if self.phase == "unconfigured":
            return ""
        return (
            f"{name} can be changed while the detector is unconfigured, not {self.phase}: "
            "`ros2 lifecycle set` deactivate, then cleanup"
        )

    def _set_config(self, config: DetectorConfig) -> None:
        self._wanted = config

    def _reload_if_wanted(self) -> None:
        wanted = self._wanted
        if wanted == self._config:
            return
        try:
            self._detector = self._load(wanted)
        except AerialGnssError as error:
            self.get_logger().warning(f"the previous parameters remain in use: {error}")
            self._wanted = self._config
            return
        self._config = wanted

    def _fail_if_thread_failed(self) -> None:
        if self._worker.failure is not None and self.context.ok():
            raise WorkEndedError from self._worker.failure

    def _start_message(self) -> str:
        assert self._detector is not None  # noqa: S101 - active
        assert self._images is not None  # noqa: S101
        return (
            f"model {self._detector.name}, classes {', '.join(self._detector.class_names)}; "
            f"{self._images.topic} -> {self._publisher.topic_name}"
        )

    def advice(self, source: Input) -> str:
        """Return a hint if images arrive in the form that `image.transport` does not name."""
        image = self._config.image
        other = "raw" if image.transport == "compressed" else "compressed"
        topic = self.resolve_topic_name(replace(image, transport=other).full_topic)
        if source is not self._images or not self.count_publishers(topic):
            return ""
        return f"but {topic} has publishers: set image.transport to {other}"

    def statuses(self) -> list[Status]:
        """Return the status of images and the time each stage takes."""
        if self._images is None or self._detector is None:
            return [Status("detection", STALE, f"{self.phase}: no images are processed")]
        received = self._images.arrivals.count
        lost, refused = self._images.lost, self._refused.recent(self.steady_ns())
        level, words = OK, "detecting"
        if not received:
            level, words = STALE, "no image yet"
        elif refused:
            level, words = WARN, f"{self._refused.total} of {received} images refused: {refused}"
        elif lost > received:
            level, words = WARN, f"{lost} of {lost + received} images were lost in transport"
        values: dict[str, Any] = {
            "images_published": received + lost,
            "images_received": received,
            "images_lost_in_transport": lost,
            "images_dropped_for_newer": self._worker.dropped,
            "images_processed": self._published,
            "image_age_s": self._image_age_s,
        }
        values |= self._refused.values()
        values |= {f"ms_{stage}": mean for stage, mean in self.timings.means_ms().items()}
        values |= {f"ms_p95_{stage}": p95 for stage, p95 in self.timings.p95_ms().items()}
        return [Status("detection", level, words, {"model": self._detector.name, **values})]
