# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss check` on live topics: a real publisher in another thread."""

from __future__ import annotations

import json
import threading

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from aerial_gnss_ros import cli  # noqa: E402


class Vehicle:
    """Publishes a hover, heading 90 deg, camera 30 deg down, at 20 Hz, in a context of its own."""

    def __init__(self, camera=False):
        from geometry_msgs.msg import QuaternionStamped
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import qos_profile_sensor_data as qos
        from sensor_msgs.msg import CameraInfo, Imu, NavSatFix
        from std_msgs.msg import Float64

        self.context = Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("vehicle", context=self.context, namespace="d1")
        types = {"fix": NavSatFix, "attitude": Imu, "gimbal": QuaternionStamped, "height": Float64}
        if camera:
            types["camera/camera_info"] = CameraInfo
        self.publishers = {
            name: (kind, self.node.create_publisher(kind, name, qos))
            for name, kind in types.items()
        }
        self.node.create_timer(0.05, self.send)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()

    def send(self):
        stamp = self.node.get_clock().now().to_msg()
        for name, (kind, publisher) in self.publishers.items():
            message = kind()
            if name == "height":
                message.data = 10.0
            else:
                message.header.stamp = stamp
            if name == "camera/camera_info":
                message.width, message.height, message.distortion_model = 640, 360, "plumb_bob"
                message.k = [500.0, 0.0, 320.0, 0.0, 500.0, 180.0, 0.0, 0.0, 1.0]
                message.d = [0.0] * 5
            if name == "fix":
                message.status.status = 0
                message.latitude, message.longitude = 13.0, -59.0
            if name == "gimbal":
                q = message.quaternion
                q.x, q.y, q.z, q.w = 0.0, 0.25881904510252074, 0.0, 0.9659258262890683
            publisher.publish(message)

    def stop(self):
        self.executor.shutdown()
        self.thread.join(90.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.mark.parametrize("camera", [False, True])
def test_the_live_check_says_where_the_camera_points(capsys, camera):
    vehicle = Vehicle(camera)
    try:
        status = cli.main(["check", "--namespace", "d1", "--seconds", "10", "--json"])
    finally:
        vehicle.stop()
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["camera"]["distance_m"] == pytest.approx(17.3, abs=0.1)
    assert found["inputs"]["gimbal"]["problem"] == ""
    missing = "" if camera else "nobody publishes /d1/camera/camera_info"
    assert found["inputs"]["camera_info"]["problem"] == missing
    assert "17 m ahead, heading 90 deg, 30 deg below the horizon" in err
    assert status == (0 if camera else 1), out  # no camera, no positions


def test_the_doctor_finds_the_profile_of_a_live_vehicle(capsys):
    vehicle = Vehicle()
    try:
        status = cli.main(["doctor", "--seconds", "8", "--json"])
    finally:
        vehicle.stop()
    found = json.loads(capsys.readouterr().out)
    best = found["profiles"][0]
    assert (best["profile"], best["namespace"]) == ("generic", "d1")
    assert set(best["matched"]) == {"fix", "attitude", "gimbal", "height"}
    assert best["missing"] == ["camera_info"]
    assert status == 1
    rates = {topic["name"]: topic["rate_hz"] for topic in found["topics"]}
    assert rates["/d1/fix"] > 0.0


def test_a_bad_namespace_is_one_sentence(capsys):
    assert cli.main(["check", "--namespace", "bad name", "--seconds", "1"]) == 2
    assert "is not a valid namespace" in capsys.readouterr().err.strip().splitlines()[-1]
