# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The programs as a user starts them: what they say, and how they end."""

from __future__ import annotations

import re
import signal
import time

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from aerial_gnss_ros.nodes.ros_messages import message_class

ESTIMATOR = "aerial_gnss_ros.nodes.estimator"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_node_with_status_0(start, number):
    program = start(ESTIMATOR)
    program.wait_for("method filter")
    assert program.end(number) == 0, program.text
    assert "Traceback" not in program.text


def test_silence_and_mismatches_are_reported(ros, start):
    """One run, as each takes five seconds: silence, wrong type, wrong reliability, durability."""
    node = ros.node()
    array = message_class("vision_msgs/msg/Detection2DArray")
    careless = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_publisher(array, "/d/detections", careless)
    node.create_publisher(String, "/d/height", 10)
    program = start(ESTIMATOR, "--ros-args", "-r", "__ns:=/d", "-r", "gimbal:=mount/attitude")
    program.wait_for("detections /d/detections.*gimbal /d/mount/attitude")
    program.wait_for(
        "/d/detections: a publisher has an incompatible reliability, .* which asks for reliable; "
        "set the publisher's reliability to reliable"
    )
    program.wait_for(r"no fix for 5 s on /d/fix \(publishers: 0\): start its publisher")
    program.wait_for(r"no gimbal for 5 s on /d/mount/attitude \(publishers: 0\)")
    program.wait_for(r"no height for 5 s on /d/height \(publishers: 1\): std_msgs/msg/String is")
    program.wait_for(r"no detections for 5 s on /d/detections \(publishers: 1\): its quality of")
    assert "no attitude" not in program.text  # the gimbal refers to the earth
    assert "no water_level" not in program.text
    fixes = message_class("sensor_msgs/msg/NavSatFix")
    publisher = node.create_publisher(fixes, "/d/fix", 10)

    def is_back():
        publisher.publish(fixes())
        return re.search(r"fix is back on /d/fix after \d", program.text)

    ros.spin_until(is_back)
    assert program.end() == 0


def test_a_subscriber_that_cannot_be_served_reads_what_to_change(ros):
    from aerial_gnss_ros.detection.base import Detections
    from aerial_gnss_ros.nodes.detector_node import DetectorNode

    class Nothing:
        name, class_names = "nothing", ("aqua",)

        def detect(self, image):
            raise AssertionError(Detections, image)

    node = ros.add(DetectorNode(load=lambda _config: Nothing()))
    said = []
    node.get_logger().warning = said.append
    array = message_class("vision_msgs/msg/Detection2DArray")
    wish = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    ros.node().create_subscription(array, "detections", print, wish)
    ros.spin_until(lambda: said)
    assert said[0] == (
        "/detections: a subscriber has an incompatible durability, so nothing passes between it "
        "and this node, which offers volatile; set the subscriber's durability to volatile"
    )


def test_wrong_input_ends_the_process_with_status_2(start, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("/**:\n  ros__parameters: {model: /absent/robots.onnx}\n")
    program = start("aerial_gnss_ros.nodes.detector", "--ros-args", "--params-file", path)
    program.wait_for(r"detector: .*/absent/robots\.onnx")
    assert program.process.wait(timeout=90.0) == 2
    assert "Traceback" not in program.text


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_the_program_still_imports_ends_it_properly(start, number):
    script = (
        "import os, sys; from aerial_gnss_ros.nodes import estimator as n, executable as e;"
        "own = e.leave_on_signals;"
        f"e.leave_on_signals = lambda: (own(), os.kill(os.getpid(), {number}));"
        "sys.exit(n.main())"
    )
    program = start("-c", script)
    assert program.process.wait(timeout=90.0) == 0
    assert "Traceback" not in program.text


def test_without_ros_the_executable_says_how_to_get_it(monkeypatch, capsys):
    import importlib.util

    from aerial_gnss_ros.nodes import detector

    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "rclpy" else find(name)
    )
    monkeypatch.setattr(signal, "signal", lambda *_: None)  # pytest keeps its own
    assert detector.main() == 2
    assert "source /opt/ros/jazzy/setup.bash" in capsys.readouterr().err


OFTEN = """
import os, random, signal, threading
from aerial_gnss_ros.nodes import process
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode

chance = random.Random(5)

def node():
    delay = chance.uniform(0.0, 0.4)
    threading.Timer(delay, os.kill, (os.getpid(), signal.SIGINT)).start()
    return EstimatorNode()

for _ in range(15):
    assert process.spin([node], ["estimator"]) == 0
print("all ended well")
"""


def test_a_signal_ends_busy_nodes_properly_at_any_moment(ros, start):
    """Inside rclpy's C++ what a signal raises comes out as another error."""
    program = start("-c", OFTEN)
    node = ros.node()
    kinds = {"fix": "sensor_msgs/msg/NavSatFix", "attitude": "sensor_msgs/msg/Imu"}
    publishers = [
        (node.create_publisher(message_class(kind), name, 10), message_class(kind)())
        for name, kind in kinds.items()
    ]
    ended = time.monotonic() + 120.0
    while program.process.poll() is None and time.monotonic() < ended:
        for publisher, msg in publishers:
            publisher.publish(msg)
        time.sleep(0.0005)
    assert program.end() == 0, program.text
    assert "all ended well" in program.text
    assert "Traceback" not in program.text


def test_programs_started_afterwards_can_be_ended(start):
    script = (
        "import subprocess, sys; from aerial_gnss_ros.nodes import leaving, process;"
        "leaving.leave_on_signals(); process.work(lambda: None, ['program']);"
        "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(30)']);"
        "child.terminate(); sys.exit(child.wait())"
    )
    program = start("-c", script)
    assert program.process.wait(timeout=90.0) == 256 - signal.SIGTERM, program.text
