# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The live page's node, with the real estimator: what it fetches, and when it subscribes."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402

from aerial_gnss_ros.adapters.overview import Light  # noqa: E402
from aerial_gnss_ros.core.values.errors import ConfigError  # noqa: E402
from aerial_gnss_ros.nodes.overviews import OverviewListener, lights_of  # noqa: E402

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import browser, wait_for  # noqa: E402


@pytest.fixture
def listener():
    """Return a function that makes a listener; it leaves ROS at the end."""
    made = []

    def make(namespace=""):
        made.append(OverviewListener(namespace, "camera/image_raw", "detections"))
        return made[-1]

    yield make
    for one in made:
        one.close()


def fetched(fetch, seconds=90.0):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = fetch()
        if found:
            return found
        time.sleep(0.05)
    pytest.fail(f"nothing within {seconds} s")


def test_overviews_and_lights_come_while_they_are_watched(listener, start, flight):
    estimator = start("aerial_gnss_ros.nodes.estimator", "--ros-args", "-p", "use_sim_time:=true")
    estimator.wait_for("method filter")
    shown = listener()
    assert shown.overview() is None
    shown.watch()
    arguments = ["--wait-for", "estimator", "--rate", "0.25"]  # 20 s: all comes before the end
    start("aerial_gnss_ros.cli", "play", flight("boxes"), *arguments)

    def complete():
        fields = json.loads(shown.overview() or "{}")
        return fields.get("robots") and fields["drone"] and fields

    fields = fetched(complete)
    assert {one["state"] for one in fields["robots"]} <= {"confirmed", "coasting"}
    assert len(fields["footprint"]) > 3
    assert fields["drone"]["height_m"] == pytest.approx(10.0, abs=0.3)
    fetched(lambda: [one for one in shown.lights() if (one.name, one.level) == ("fix", "ok")])
    boxes = shown.look() or fetched(lambda: list(shown.detections()))
    assert boxes[0].detections
    shown.rest()
    assert shown.overview() is None


def status(name, level, words="words"):
    return DiagnosticStatus(name=name, level=level, message=words)


def test_lights_are_those_of_this_drone_without_its_robots():
    array = DiagnosticArray(
        status=[
            status("d1/estimator: fix", DiagnosticStatus.WARN, "silent for 5 s"),
            status("d1/estimator: robot aqua_1", DiagnosticStatus.WARN),
            status("d1/detector: images", DiagnosticStatus.STALE, "never received"),
            status("d2/estimator: fix", DiagnosticStatus.ERROR),
            status("estimator: fix", DiagnosticStatus.ERROR),
        ]
    )
    nodes = {"d1/estimator": "", "d1/detector": "detector "}
    assert list(lights_of(array, nodes)) == [
        Light("fix", "warning", "silent for 5 s"),
        Light("detector images", "error", "never received"),
    ]


def test_images_are_found_on_the_topic_that_begins_later(listener):
    from sensor_msgs.msg import CompressedImage

    from aerial_gnss_ros.nodes import qos

    shown = listener()
    shown.look()
    assert shown.image() is None
    camera = rclpy.create_node("camera")
    publisher = camera.create_publisher(
        CompressedImage, "camera/image_raw/compressed", qos.sensor(1)
    )

    def seen():
        publisher.publish(CompressedImage(format="jpeg"))
        return shown.image()

    assert fetched(seen).format == "jpeg"
    camera.destroy_node()


def test_a_namespace_that_no_topic_can_have_is_one_sentence(listener):
    with pytest.raises(ConfigError, match="bad name"):
        listener("bad name")
    listener("good_name")  # ROS was left, and can be entered again


@pytest.mark.browser
def test_the_page_shows_the_live_estimator_and_says_when_it_has_ended(start, flight):
    estimator = start("aerial_gnss_ros.nodes.estimator", "--ros-args", "-p", "use_sim_time:=true")
    page = start("aerial_gnss_ros.cli", "view", "--port", "0")
    url = page.wait_for(r"open (http\S+) in a browser")[1]
    with browser() as driver:
        driver.get(url)
        banner = "return document.getElementById('banner').textContent"
        wait_for(driver, banner)
        assert driver.execute_script(banner) == "Waiting for the first positions."
        start("aerial_gnss_ros.cli", "play", flight("boxes"), "--wait-for", "estimator")
        wait_for(driver, "return document.querySelectorAll('.confirmed .state').length == 2")
        assert not driver.find_element("id", "banner").is_displayed()
        estimator.end()
        wait_for(driver, "return document.querySelectorAll('.old .state').length == 2")
        assert "positions are old" in driver.execute_script(banner)
        words = "return document.getElementById('trouble').textContent"
        wait_for(driver, f"return (() => {{ {words} }})().includes('no diagnostics')")
        assert page.end() == 0
        wait_for(driver, f"return (() => {{ {banner} }})().includes('No connection')")
    assert "Traceback" not in page.text
