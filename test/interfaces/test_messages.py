# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""vision_msgs and geographic_msgs: built here, from apt and in bags they are the same types."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import pytest

rclpy = pytest.importorskip("rclpy", reason="no ROS: install the extra [ros] and interfaces/")
pytest.importorskip("vision_msgs", reason="no vision_msgs: install interfaces/")

from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[2]
TEXTS = sorted((REPOSITORY / "aerial_gnss_ros" / "bags" / "msg").glob("*/msg/*.msg"))
NAMES = [f"{path.parts[-3]}/msg/{path.stem}" for path in TEXTS]

# Hashes of the definitions published upstream (branch ros2 of vision_msgs and geographic_info),
# so that a mistake in our texts, which both sides would share, is noticed.
UPSTREAM = {
    "vision_msgs/msg/Detection2DArray": (
        "RIHS01_214274120007f4a683866481336b70310268cfa107aebe9d594a6acf75bda968"
    ),
    "geographic_msgs/msg/GeoPoseWithCovarianceStamped": (
        "RIHS01_e8e87d7bc02d092be564be3b6a2ca2302ff6997a82b996e4c6a9052b88e09aac"
    ),
}


def message_class(name: str) -> type:
    package, _, message = name.split("/")
    return getattr(import_module(f"{package}.msg"), message)


@pytest.fixture(scope="module")
def hashes_on_the_graph() -> dict[str, str]:
    """Advertise every type and read back the type hash that the middleware announces."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("type_hashes", context=context, start_parameter_services=False)
    found = {}
    try:
        for name in NAMES:
            topic = "hash/" + name.replace("/", "_")
            node.create_publisher(message_class(name), topic, 1)
            deadline = time.monotonic() + 90.0
            while not (infos := node.get_publishers_info_by_topic(topic)):
                assert time.monotonic() < deadline, f"{topic} never appeared on the graph"
                time.sleep(0.02)
            found[name] = "RIHS01_" + bytes(infos[0].topic_type_hash.value).hex()
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_type_hash_equals_that_of_bags(name: str, hashes_on_the_graph: dict[str, str]) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for text, text_name in zip(TEXTS, NAMES, strict=True):
        types.update(get_types_from_msg(text.read_text(), text_name))
    store.register(types)
    assert hashes_on_the_graph[name] == store.hash_rihs01(name)


@pytest.mark.parametrize("name", sorted(UPSTREAM))
def test_type_hash_equals_that_of_upstream(name: str, hashes_on_the_graph: dict[str, str]) -> None:
    assert hashes_on_the_graph[name] == UPSTREAM[name]


RECEIVER = """
import sys, time
import rclpy
from rclpy.qos import QoSProfile
from vision_msgs.msg import Detection2DArray
rclpy.init()
node = rclpy.create_node("receiver")
got = []
node.create_subscription(Detection2DArray, "boxes", got.append, QoSProfile(depth=10))
deadline = time.monotonic() + 90
while not got and time.monotonic() < deadline:
    rclpy.spin_once(node, timeout_sec=0.1)
box = got[0].detections[0]
print(got[0].header.frame_id, box.bbox.center.position.x, box.bbox.size_y, box.id,
      box.results[0].hypothesis.class_id, box.results[0].hypothesis.score, len(got[0].detections))
"""


def test_a_message_reaches_another_process() -> None:
    from vision_msgs.msg import Detection2D, Detection2DArray, ObjectHypothesisWithPose

    message = Detection2DArray(detections=[Detection2D(id="7"), Detection2D()])
    message.header.frame_id = "camera"
    message.detections[0].bbox.center.position.x = 640.25
    message.detections[0].bbox.size_y = 12.5
    result = ObjectHypothesisWithPose()
    result.hypothesis.class_id = "aqua"
    result.hypothesis.score = 0.75
    message.detections[0].results.append(result)

    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("sender", context=context)
    publisher = node.create_publisher(Detection2DArray, "boxes", 10)
    receiver = subprocess.Popen(
        [sys.executable, "-c", RECEIVER], stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    )
    try:
        while receiver.poll() is None:
            publisher.publish(message)
            time.sleep(0.1)
        output = receiver.communicate(timeout=90)[0]
    finally:
        receiver.kill()
        node.destroy_node()
        rclpy.shutdown(context=context)
    assert output.split() == ["camera", "640.25", "12.5", "7", "aqua", "0.75", "2"]
