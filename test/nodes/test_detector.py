# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector node: one array for every image that can be used, and words for the others."""

from __future__ import annotations

import threading
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.search import searching
from aerial_gnss_ros.detection.select import load_detector

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rclpy.parameter import Parameter  # noqa: E402

from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.detector_node import MOST_FAILURES, DetectorNode  # noqa: E402
from aerial_gnss_ros.nodes.diagnostics import OK, STALE, WARN  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402
from aerial_gnss_ros.nodes.worker import WorkEndedError  # noqa: E402

IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
COMPRESSED = "sensor_msgs/msg/CompressedImage"


class OneBox:
    """Finds a box in the middle of every image that is not black."""

    name, class_names = "one box", ("aqua",)

    def __init__(self, config):
        self.config, self.gate, self.begun = config, threading.Event(), threading.Event()
        self.gate.set()
        self.error = None

    def detect(self, image):
        if self.error is not None:
            raise self.error
        self.begun.set()
        self.gate.wait(90.0)
        count = int(image.any())
        height, width = image.shape[:2]
        xywh = np.array([[width / 2, height / 2, 10.0, 5.0]] * count).reshape(-1, 4)
        zeros = np.zeros(count, np.int64)
        return Detections(xywh, np.full(count, 0.75), zeros, ("aqua",), {"infer": 2.0})


@pytest.fixture
def seen(ros, tmp_path):
    """Return a detector node with a camera in front of it and what it publishes."""

    def make(yaml="", load=OneBox):
        path = tmp_path / "p.yaml"
        path.write_text(yaml)
        node = ros.add(DetectorNode(Given([path] if yaml else []), load))
        camera = ros.node("camera")
        arrays = []
        array = message_class("vision_msgs/msg/Detection2DArray")
        camera.create_subscription(array, "detections", arrays.append, qos.detections())
        compressed = "compressed" in yaml
        images = camera.create_publisher(
            message_class(COMPRESSED if compressed else IMAGE),
            "camera/image_raw" + ("/compressed" if compressed else ""),
            qos.sensor(5),
        )
        infos = camera.create_publisher(message_class(INFO), "camera/camera_info", qos.sensor(5))
        ros.connect(images, infos)
        ros.spin_until(lambda: node.count_publishers("/camera/image_raw") or compressed)
        ros.spin_until(node._publisher.get_subscription_count)
        return SimpleNamespace(
            node=node, arrays=arrays, images=images, infos=infos, ros=ros,
            detector=lambda: node._detector,
        )  # fmt: skip

    return make


def picture(stamp, value=50, size=(64, 36), encoding="bgr8"):
    width, height = size
    return message(
        IMAGE,
        {
            "header": {"stamp": {"sec": stamp, "nanosec": 123456789}, "frame_id": "optical"},
            "width": width, "height": height, "encoding": encoding, "step": 3 * width,
            "data": [value] * (3 * width * height),
        },
    )  # fmt: skip


def camera_info(size=(64, 36), focal=50.0):
    k = [focal, 0.0, 32.0, 0.0, focal, 18.0, 0.0, 0.0, 1.0]
    return message(INFO, {"width": size[0], "height": size[1], "k": k})


def detection_status(node):
    return node.statuses()[0]


def test_every_image_gives_an_array_with_its_header_also_an_empty_one(seen):
    s = seen()
    assert detection_status(s.node).level == STALE
    for stamp, value in ((11, 50), (12, 0)):
        s.images.publish(picture(stamp, value))
        s.ros.spin_until(lambda count=stamp - 10: len(s.arrays) == count)
    full, empty = s.arrays
    box = full.detections[0]
    for header in (full.header, box.header):
        assert (header.stamp.sec, header.stamp.nanosec) == (11, 123456789)
        assert header.frame_id == "optical"
    center = box.bbox.center.position
    assert (center.x, center.y, box.bbox.size_x, box.bbox.size_y) == (32.0, 18.0, 10.0, 5.0)
    hypothesis = box.results[0].hypothesis
    assert (hypothesis.class_id, hypothesis.score) == ("aqua", 0.75)
    assert (len(empty.detections), empty.header.stamp.sec) == (0, 12)
    status = detection_status(s.node)
    assert (status.level, status.values["images_processed"]) == (OK, 2)
    assert status.values["ms_infer"] == 2.0
    assert status.values["images_lost_in_transport"] == 0


def test_whoever_subscribes_gets_the_image_with_its_boxes(seen):
    s = seen("annotated: {rate_hz: 50.0}")
    s.images.publish(picture(11))
    s.ros.spin_until(lambda: len(s.arrays) == 1)
    assert s.node._annotated._last_ns is None  # nobody looks
    viewer, got = s.ros.node("viewer"), []
    topic = "annotated/compressed"
    viewer = viewer.create_subscription(message_class(COMPRESSED), topic, got.append, 10)
    s.ros.spin_until(viewer.get_publisher_count)
    s.images.publish(picture(12))
    s.ros.spin_until(lambda: got)
    assert (got[0].header.stamp.sec, got[0].header.frame_id, got[0].format) == (
        12,
        "optical",
        "jpeg",
    )
    shown = cv2.imdecode(np.frombuffer(bytes(got[0].data), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (36, 64, 3)
    assert shown[18, 27:38].max() > 120  # the box's sides; the image is a grey of 50


def test_what_the_middleware_cannot_have_counted_is_left_out(seen):
    s = seen()
    _, _, subscription = s.node._attached["images"]
    (lost,) = (
        handler.callback
        for handler in subscription.event_handlers
        if handler.event_type.name == "RCL_SUBSCRIPTION_MESSAGE_LOST"
    )
    for total, change in ((1, 1), (2**64 - 2**31, 2**31 - 1), (2**64 - 2**31 + 2, 2)):
        lost(SimpleNamespace(total_count=total, total_count_change=change))
    assert detection_status(s.node).values["images_lost_in_transport"] == 3


def test_the_newest_image_wins_while_the_network_is_busy(seen):
    s = seen()
    s.detector().gate.clear()
    s.images.publish(picture(1))
    s.ros.spin_until(s.detector().begun.is_set)
    for stamp in (2, 3, 4):  # the executor goes on meanwhile
        s.images.publish(picture(stamp))
        s.ros.spin_until(lambda count=stamp: s.node._images.arrivals.count == count)
    s.detector().gate.set()
    s.ros.spin_until(lambda: len(s.arrays) == 2)
    assert [array.header.stamp.sec for array in s.arrays] == [1, 4]
    assert detection_status(s.node).values["images_dropped_for_newer"] == 2


@pytest.mark.parametrize(
    ("info", "image", "reason"),
    [
        (camera_info((640, 360)), picture(1), "camera_info_size"),
        (camera_info((0, 0)), picture(1), "camera_info_zeros"),
        (camera_info(focal=0.0), picture(1), "camera_info_zeros"),
        (camera_info(), picture(1, encoding="bayer_rggb8"), "bad_image"),
        (camera_info(), picture(1, encoding="mono16"), "bad_image"),
        (camera_info(), picture(1, size=(0, 0)), "bad_image"),
    ],
)
def test_what_cannot_be_used_is_refused_counted_and_survived(seen, info, image, reason):
    s = seen()
    s.infos.publish(info)
    s.ros.spin_until(lambda: s.node._camera_size.size is not None)
    s.images.publish(image)
    s.ros.spin_until(lambda: s.node._refused.total == 1)
    assert detection_status(s.node).values[f"refused_{reason}"] == 1
    status = detection_status(s.node)
    assert status.level == WARN
    assert status.message.startswith("1 of 1 images refused: ")
    s.infos.publish(camera_info())
    s.ros.spin_until(lambda: s.node._camera_size.size == (64, 36))
    s.images.publish(picture(2))
    s.ros.spin_until(lambda: len(s.arrays) == 1)
    assert s.arrays[0].header.stamp.sec == 2
    later = s.node.steady_ns() + 11 * 10**9
    s.node.steady_ns = lambda: later
    assert detection_status(s.node).level == OK  # one bad image is no warning for a day


def test_compressed_images_and_a_corrupt_one(seen):
    s = seen("image: {transport: compressed}\n")
    jpeg = cv2.imencode(".jpg", np.full((36, 64, 3), 90, np.uint8))[1].tobytes()
    for stamp, data in ((1, b""), (2, jpeg[: len(jpeg) // 2]), (3, jpeg)):
        fields = {"header": {"stamp": {"sec": stamp}}, "format": "jpeg", "data": data}
        s.images.publish(message(COMPRESSED, fields))
        s.ros.spin_until(lambda n=stamp: s.node._refused.counts["bad_image"] + len(s.arrays) == n)
    assert s.arrays[0].header.stamp.sec == 3
    assert any("has no bytes" in sentence for sentence in s.node._said)
    assert any("cut off" in sentence for sentence in s.node._said)


def test_images_may_change_their_size_in_mid_stream_through_the_real_network(seen):
    s = seen(load=lambda config: load_detector(replace(config, backend="onnxruntime")))
    for stamp, size in ((1, (64, 36)), (2, (320, 180)), (3, (100, 101)), (4, (64, 36))):
        s.images.publish(picture(stamp, size=size))
        s.ros.spin_until(lambda count=stamp: len(s.arrays) == count)
    assert detection_status(s.node).level == OK


def test_a_model_of_other_classes_than_configured_is_named(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("class_names: [leader, follower]\nbackend: onnxruntime\n")
    with pytest.raises(ModelError, match=r"knows 1 class \(aqua\), but class_names has 2"):
        ros.add(DetectorNode(Given([path])))


def test_thresholds_change_while_running(seen):
    s = seen()
    s.node.set_parameters([Parameter("score_threshold", value=0.5)])
    s.images.publish(picture(1))
    s.ros.spin_until(lambda: len(s.arrays) == 1)
    assert s.detector().config.score_threshold == 0.5


def test_an_image_that_the_network_cannot_take_is_counted_and_survived(seen):
    s = seen()
    s.detector().error = ModelError("m.onnx ran out of memory on an image")
    s.images.publish(picture(1))
    s.ros.spin_until(lambda: detection_status(s.node).values.get("refused_failed") == 1)
    s.detector().error = None
    s.images.publish(picture(2))
    s.ros.spin_until(lambda: [a.header.stamp.sec for a in s.arrays] == [2])


def test_a_failure_of_the_network_is_survived_and_an_endless_one_ends_the_node(seen):
    s = seen()
    whole, s.detector().detect = s.detector().detect, lambda _image: 1 / 0
    for stamp in range(1, MOST_FAILURES):
        s.images.publish(picture(stamp))
        s.ros.spin_until(lambda n=stamp: s.node._refused.counts["internal"] == n)
    s.detector().detect = whole
    s.images.publish(picture(100))
    s.ros.spin_until(lambda: [a.header.stamp.sec for a in s.arrays] == [100])
    status = s.node._node_status()
    assert (status.level, status.values["internal_errors"]) == (WARN, MOST_FAILURES - 1)
    assert "ZeroDivisionError: division by zero" in status.message
    s.detector().detect = lambda _image: 1 / 0
    stamps = count(200)
    with pytest.raises(WorkEndedError):
        s.ros.spin_until(lambda: s.images.publish(picture(next(stamps))))


def test_a_network_that_fails_for_every_image_ends_the_node(seen):
    s = seen()
    s.detector().error = ModelError("m.onnx ran out of memory on an image")
    for stamp in range(1, MOST_FAILURES):
        s.images.publish(picture(stamp))
        s.ros.spin_until(lambda n=stamp: s.node._refused.counts["failed"] == n)
    s.images.publish(picture(90, encoding="bayer_rggb8"))  # never reaches the network
    s.ros.spin_until(lambda: s.node._refused.counts["bad_image"] == 1)
    s.images.publish(picture(100))
    with pytest.raises(WorkEndedError) as ended:
        s.ros.spin_until(lambda: False)
    assert "ran out of memory" in str(ended.value.__cause__)


def test_a_following_detector_works_in_the_node(seen):
    inner = []

    def load(config):
        inner.append(OneBox(config))
        return searching(inner[-1], config)

    s = seen("search: {mode: roi}\n", load)
    for stamp in (1, 2, 3):
        s.images.publish(picture(stamp, size=(640, 360)))
        s.ros.spin_until(lambda count=stamp: len(s.arrays) == count)
    whole, *windows = s.arrays
    assert whole.detections[0].bbox.center.position.x == 320.0
    assert all(len(array.detections) >= 1 for array in windows)
    assert "following the robots" in detection_status(s.node).values["model"]


def test_a_missing_model_is_named(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("model: /absent/robots.onnx\n")
    assert ros
    with pytest.raises(ModelError, match=r"/absent/robots\.onnx"):
        DetectorNode(Given([path]))


def test_images_in_the_other_form_are_pointed_out(ros):
    node = ros.add(DetectorNode(load=OneBox))
    assert node.advice(node._images) == ""
    topic = "/camera/image_raw/compressed"
    ros.node("camera").create_publisher(message_class(COMPRESSED), topic, qos.sensor(5))
    ros.spin_until(lambda: node.advice(node._images))
    assert node.advice(node._images).endswith("has publishers: set image.transport to compressed")
