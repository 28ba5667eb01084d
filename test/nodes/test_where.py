# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss where`: one question, one answer, also from a topic that was latched before."""

from __future__ import annotations

import json
import threading

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from sensor_msgs.msg import NavSatFix  # noqa: E402

from aerial_gnss_ros import cli  # noqa: E402
from aerial_gnss_ros.nodes import qos  # noqa: E402


@pytest.fixture
def estimator():
    """Return a publisher of aqua_1 in the namespace d1, and what it publishes."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("estimator", context=context, namespace="d1")
    publisher = node.create_publisher(NavSatFix, "robots/aqua_1/fix", qos.latched())

    def say(status=0, sigma=2.0, stamp_s=1_735_689_600):
        message = NavSatFix(latitude=13.0, longitude=-59.0, altitude=float("nan"))
        message.status.status = status
        message.header.stamp.sec = stamp_s
        message.position_covariance[0] = message.position_covariance[4] = sigma**2
        publisher.publish(message)

    yield say
    node.destroy_node()
    rclpy.shutdown(context=context)


def where(capsys, *more, namespace="d1"):
    status = cli.main(["where", "aqua_1", "--namespace", namespace, "--seconds", "90", *more])
    return status, *capsys.readouterr()


def test_the_position_known_is_reported(estimator, capsys):
    estimator()
    status, out, _ = where(capsys)
    assert status == 0
    assert "d1/aqua_1 is at 13.0000000, -59.0000000, 95 % within 4.9 m; measured" in out
    status, out, _ = where(capsys, "--json")
    answer = json.loads(out)
    assert (answer["state"], answer["sigma_m"], answer["altitude_m"]) == ("measured", 2.0, None)
    assert 0.0 < answer["asked_to_answered_s"] <= 90.0
    assert where(capsys, namespace="//d1/")[0] == 0  # a slash too many


def test_a_prediction_is_no_measurement(estimator, capsys):
    estimator(status=-1)
    status, out, _ = where(capsys)
    assert status == 1
    assert "; predicted, 2025-01-01 00:00:00 UTC" in out
    estimator(status=-1, sigma=1000.0)
    status, out, _ = where(capsys)
    assert status == 1
    assert "d1/aqua_1 has been lost since 2025-01-01" in out


def test_a_new_measurement_is_waited_for(estimator, capsys):
    estimator()
    end = threading.Event()

    def go_on():
        for second in range(1, 1000):
            estimator(status=-1 if second < 10 else 0, stamp_s=1_735_689_600 + second)
            if end.wait(0.1):
                break

    thread = threading.Thread(target=go_on, daemon=True)
    thread.start()
    status, out, _ = where(capsys, "--measured", "--json")
    end.set()
    thread.join(90.0)
    assert status == 0
    assert json.loads(out)["stamp_ns"] >= 1_735_689_610 * 10**9


def test_an_old_measurement_is_none_that_was_waited_for(estimator, capsys):
    estimator()
    status, _, err = where(capsys, "--measured", "--seconds", "6")
    assert status == 2
    assert "aqua_1 was not measured within 6 s" in err


def test_who_is_not_there_is_said(estimator, capsys):
    estimator()
    status = cli.main(["where", "aqua_7", "--namespace", "d1", "--seconds", "6"])
    assert status == 2
    assert (
        "no position of aqua_7 within 6 s; only aqua_1 is published here" in capsys.readouterr().err
    )
    assert cli.main(["where", "a b", "--seconds", "1"]) == 2
    assert "is invalid" in capsys.readouterr().err
