# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight whose answer is known by hand, for the commands that read bags."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.writer import RELIABLE, SENSOR, BagWriter
from aerial_gnss_ros.commands import replay as command
from aerial_gnss_ros.detection.base import Detections

START = 1_000_000_000_000
STEP = 100_000_000
HALF = math.sqrt(0.5)


@dataclass
class MadeFlight:
    """Hovers 20 m above the water and looks straight down, the image's top to the east.

    With a focal length of 500 px a pixel is 4 cm: a robot u px left of the middle is 0.04 u m north
    of the drone, one v px above the middle 0.04 v m east.
    """

    latitude: float = 13.19
    longitude: float = -59.64
    altitude: float = -25.0  # above the ellipsoid; the water is at -45 m
    images: int = 20
    robots: tuple[tuple[float, float], ...] = ((-100.0, 0.0), (50.0, -75.0))
    size: tuple[int, int] = (640, 480)

    def true_east_north(self):
        """Return (n, 2) places of the robots relative to the drone, m."""
        return np.array([(-0.04 * v, -0.04 * u) for u, v in self.robots])

    def stamps(self):
        """Return the stamps of the telemetry while images are taken."""
        return range(START, START + (self.images + 1) * STEP, STEP)

    def boxes(self, stamp):
        width, height = self.size
        header = header_fields(stamp, "camera")
        return {
            "header": header,
            "detections": [
                {
                    "header": header,
                    "results": [{"hypothesis": {"class_id": "aqua", "score": 0.9}}],
                    "bbox": {
                        "center": {"position": {"x": width / 2 + u, "y": height / 2 + v}},
                        "size_x": 16.0,
                        "size_y": 11.0,
                    },
                }
                for u, v in self.robots
            ],
        }

    def telemetry(self, stamp):
        width, height = self.size
        header = header_fields(stamp, "drone")
        yield (
            "camera/camera_info",
            "sensor_msgs/msg/CameraInfo",
            {
                "header": header,
                "width": width,
                "height": height,
                "distortion_model": "plumb_bob",
                "d": [0.0] * 5,
                "k": [500.0, 0.0, width / 2, 0.0, 500.0, height / 2, 0.0, 0.0, 1.0],
            },
        )
        yield (
            "fix",
            "sensor_msgs/msg/NavSatFix",
            {
                "header": header,
                "latitude": self.latitude,
                "longitude": self.longitude,
                "altitude": self.altitude,
            },
        )
        yield "attitude", "sensor_msgs/msg/Imu", {"header": header, "orientation": {"w": 1.0}}
        yield (
            "gimbal",
            "geometry_msgs/msg/QuaternionStamped",
            {
                "header": header,
                "quaternion": {"x": 0.0, "y": HALF, "z": 0.0, "w": HALF},
            },
        )
        yield "height", "std_msgs/msg/Float64", {"data": 20.0}

    def picture(self, stamp):
        width, height = self.size
        return {
            "header": header_fields(stamp, "camera"),
            "width": width,
            "height": height,
            "encoding": "mono8",
            "step": width,
            "data": np.zeros(width * height, dtype=np.uint8),
        }

    def write(self, path, without=(), namespace="", images=False, change=None):
        """Write the bag.

        Args:
            path: the bag's folder.
            without: topics to leave out.
            namespace: of all topics.
            images: images instead of detections.
            change: takes and returns topic, type and fields of each message.
        """
        with BagWriter(path, namespace=namespace) as bag:

            def put(topic, msgtype, stamp, fields, qos):
                if change is not None:
                    topic, msgtype, fields = change(topic, msgtype, fields)
                if topic not in without:
                    bag.write(topic, msgtype, stamp, fields, qos)

            for i in range(-5, self.images + 5):
                stamp = START + i * STEP
                for topic, msgtype, fields in self.telemetry(stamp):
                    put(topic, msgtype, stamp, fields, SENSOR)
                if not 0 <= i < self.images:
                    continue
                taken = stamp + STEP // 2  # between two samples of telemetry
                if images:
                    put("camera/image_raw", "sensor_msgs/msg/Image", taken, self.picture(taken),
                        SENSOR)  # fmt: skip
                else:
                    put("detections", "vision_msgs/msg/Detection2DArray", taken,
                        self.boxes(taken), RELIABLE)  # fmt: skip
        return path


@pytest.fixture
def flight():
    """Return the hover with two robots."""
    return MadeFlight()


@pytest.fixture
def drawn():
    """Use this where a report's pictures matter; drawing them is most of a replay's time."""


@pytest.fixture(autouse=True)
def _undrawn(request, monkeypatch):
    """Put an empty picture in the place of each that nobody looks at."""
    if "drawn" in request.fixturenames:
        return
    buffer = io.BytesIO()
    Image.new("RGB", (1, 1)).save(buffer, "png")
    dot = buffer.getvalue()
    monkeypatch.setattr(Figure, "savefig", lambda _figure, file, **_options: file.write(dot))


@pytest.fixture
def replay():
    """Return a function that replays a bag, or several, and returns the exit status."""

    def run(bag, out, *extra):
        bags = bag if isinstance(bag, list) else [bag]
        return cli.main(["replay", *map(str, bags), "-o", str(out), *map(str, extra)])

    return run


@pytest.fixture
def refusal(replay, capsys):
    """Return a function that checks that a replay is refused, and returns the sentence."""

    def refused(bag, out, *extra):
        before = out.exists()
        capsys.readouterr()
        assert replay(bag, out, *extra) == 2
        assert out.exists() == before
        assert not list(out.parent.glob(".*.partial"))
        sentence = capsys.readouterr().err.strip().splitlines()[-1]
        assert sentence.startswith("aerial-gnss: ")
        return sentence

    return refused


class TwoRobots:
    """Stands for the network: finds what the made flight shows."""

    name = "two robots, on paper"
    class_names = ("aqua",)

    def __init__(self, flight):
        self.flight = flight
        self.calls = 0

    def detect(self, image):
        assert image.shape == (480, 640, 3)
        self.calls += 1
        boxes = [(320.0 + u, 240.0 + v, 16.0, 11.0) for u, v in self.flight.robots]
        return Detections(np.array(boxes), np.full(2, 0.9), np.zeros(2, dtype=int), ("aqua",))


@pytest.fixture
def detector(flight, monkeypatch):
    """Return a detector that `aerial-gnss replay` uses instead of a network."""
    made = TwoRobots(flight)
    monkeypatch.setattr(command, "load_detector", lambda _config: made)
    return made
