# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector's lifecycle: it starts by itself, and frees the network on cleanup."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from lifecycle_msgs.srv import ChangeState  # noqa: E402

from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.detector_node import DetectorNode  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402

IMAGE = "sensor_msgs/msg/Image"


class Nothing:
    """Finds nothing in any image; remembers whether its memory was given back."""

    name, class_names = "nothing", ("aqua",)
    closed = 0

    def detect(self, _image):
        empty = np.zeros((0, 4))
        return Detections(empty, np.zeros(0), np.zeros(0, np.int64), ("aqua",), {"infer": 1.0})

    def close(self):
        type(self).closed += 1


class Bench:
    """A detector node, what it loaded, a camera, and its arrays."""

    def __init__(self, ros, tmp_path, text, load):
        self.ros, self.loaded = ros, []
        path = tmp_path / "p.yaml"
        path.write_text(text)

        def remember(_config):
            made = load()
            self.loaded.append(weakref.ref(made))
            return made

        self.node = ros.add(DetectorNode(Given([path]), remember))
        self.other, self.arrays = ros.node("camera"), []
        array = message_class("vision_msgs/msg/Detection2DArray")
        self.other.create_subscription(array, "detections", self.arrays.append, qos.detections())
        self.images = self.other.create_publisher(
            message_class(IMAGE), "camera/image_raw", qos.sensor(5)
        )
        self.change = self.other.create_client(ChangeState, "detector/change_state")
        ros.spin_until(self.change.service_is_ready)

    def ask(self, label):
        request = ChangeState.Request()
        request.transition.label = label
        answer = self.change.call_async(request)
        self.ros.spin_until(answer.done)
        return answer.result().success

    def look(self):
        self.ros.connect(self.images)
        before = len(self.arrays)
        fields = {"height": 4, "width": 4, "encoding": "mono8", "step": 4, "data": bytes(16)}
        self.images.publish(message(IMAGE, fields))
        self.ros.spin_until(lambda: len(self.arrays) == before + 1)

    @property
    def held(self):
        gc.collect()
        return [made for made in self.loaded if made() is not None]


@pytest.fixture
def bench(ros, tmp_path):
    return lambda text="", load=Nothing: Bench(ros, tmp_path, text, load)


def test_it_starts_by_itself_gives_the_network_back_and_takes_it_up_again(bench):
    made = bench()
    assert made.node.phase == "active"
    made.look()
    Nothing.closed = 0
    assert made.ask("deactivate")
    made.ros.spin_until(lambda: not made.images.get_subscription_count())
    assert (made.node.phase, len(made.held), made.node.inputs) == ("inactive", 1, [])
    assert made.ask("cleanup")
    assert (made.node.phase, made.held, Nothing.closed) == ("unconfigured", [], 1)
    (status,) = made.node.statuses()
    assert status.message == "unconfigured: no images are processed"
    assert made.ask("configure")
    assert made.ask("activate")
    made.look()
    assert len(made.held) == 1


def test_all_counts_begin_with_the_activation(bench):
    made = bench()
    for _ in range(5):
        made.look()
    assert made.ask("deactivate")
    made.ros.spin_until(lambda: not made.images.get_subscription_count())
    assert made.ask("activate")
    (status,) = made.node.statuses()
    assert (status.values["images_received"], status.values["images_processed"]) == (0, 0)


def test_without_autostart_nothing_is_loaded_until_it_is_asked_for(bench):
    made = bench("autostart: false\n")
    assert (made.node.phase, made.loaded) == ("unconfigured", [])
    assert not made.images.get_subscription_count()
    assert made.ask("configure")
    assert made.ask("activate")
    made.look()


def test_what_cannot_be_is_refused_and_survived(bench):
    broken = []

    def load():
        if broken:
            raise ModelError("the disk is gone.")
        return Nothing()

    made = bench(load=load)
    assert not made.ask("activate")  # it is active already
    assert not made.ask("fly")
    assert made.ask("deactivate")
    assert made.ask("cleanup")
    broken.append(True)
    assert not made.ask("configure")
    assert made.node.phase == "unconfigured"
    broken.clear()
    assert made.ask("configure")
    assert made.ask("shutdown")
    assert (made.node.phase, made.held) == ("finalized", [])
