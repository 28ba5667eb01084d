# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: a published position arrives as a datagram."""

from __future__ import annotations

import socket
import threading
import xml.etree.ElementTree as ET

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from aerial_gnss_ros import cli  # noqa: E402


def publish(context, stop):
    """Publish one latched position of aqua_1 in the namespace d1, as the estimator does."""
    from sensor_msgs.msg import NavSatFix

    from aerial_gnss_ros.nodes import qos

    node = rclpy.create_node("estimator", context=context, namespace="d1")
    publisher = node.create_publisher(NavSatFix, "robots/aqua_1/fix", qos.latched())
    message = NavSatFix(latitude=13.0, longitude=-59.0, altitude=float("nan"))
    message.status.status = 0
    message.header.stamp.sec = 1_735_689_600
    message.position_covariance[0] = message.position_covariance[4] = 4.0
    publisher.publish(message)
    stop.wait(300.0)
    node.destroy_node()


def test_a_position_arrives_as_cursor_on_target(capsys):
    context, stop = rclpy.Context(), threading.Event()
    rclpy.init(context=context)
    thread = threading.Thread(target=publish, args=(context, stop), daemon=True)
    thread.start()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(90.0)
        port = receiver.getsockname()[1]
        try:
            status = cli.main(["stream", "--cot", f"127.0.0.1:{port}", "--namespace", "d1",
                               "--seconds", "10"])  # fmt: skip
            data = receiver.recv(4096)
        finally:
            stop.set()
            thread.join(90.0)
            rclpy.shutdown(context=context)
    assert status == 0
    event = ET.fromstring(data)  # noqa: S314 - our own
    assert event.get("uid") == "aerial_gnss_ros.d1.aqua_1"
    assert event.find("point").get("lat") == "13.00000000"
    assert event.find("point").get("ce") == "2.00"
    out, err = capsys.readouterr()
    assert "sent: aqua_1 1" in out
    assert "positions go to" not in err


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "no output; give --cot"),
        (("--cot", "nowhere"), "is not HOST:PORT"),
        (("--cot", "no.such.host.invalid:4242"), "cannot be resolved"),
        (("--cot", "--stale", "0"), "--stale must be above 0"),
        (("--cot", "--stale", "1e300"), "--stale must be above 0 s and at most 10000000"),
        (("--cot", "--cot-type", "a\x01"), "--cot-type must be letters and digits"),
        (("--cot", "--cot-type", "a' x='"), "--cot-type must be letters and digits"),
        (("--cot", "--namespace", "bad name", "--seconds", "1"), "is not a valid namespace"),
        (("--mavlink", "--mavlink-system", "0"), "--mavlink-system must be 1 to 255"),
    ],
)
def test_wrong_input_is_one_sentence(capsys, args, words):
    assert cli.main(["stream", *args]) == 2
    assert words in capsys.readouterr().err.strip().splitlines()[-1]
