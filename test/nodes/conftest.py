# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the tests of nodes share: ROS of a test's own, nodes in other processes, a short flight."""

from __future__ import annotations

import math
import os
import re
import runpy
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
START_NS = 1_700_000_000_000_000_000
PATIENCE_S = 90.0
"""For what surely comes: long, as the machine may be busy."""
LATITUDE, LONGITUDE = math.radians(13.19394), math.radians(-59.64151)
SIZE = (640, 360)
FOCAL_PX = 500.0
ROBOTS = {"aqua_1": (1.0, 9.0, 0.0), "aqua_2": (6.0, 12.0, 0.3)}  # east, north, m; speed east


@pytest.fixture
def ros():
    """Give a test an initialised rclpy with an executor, and leave nothing behind."""
    rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    rclpy.init(args=[])
    made = Ros()
    yield made
    made.close()
    rclpy.try_shutdown()


class Ros:
    """Nodes of this process in one executor."""

    def __init__(self):
        from rclpy.executors import SingleThreadedExecutor

        self.executor = SingleThreadedExecutor()
        self.nodes = []

    def add(self, node):
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def node(self, name="listener"):
        import rclpy

        return self.add(rclpy.create_node(name))

    def spin_until(self, true, seconds=PATIENCE_S):
        """Spin until `true()`; fail if it never is."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.05)
            if true():
                return
        pytest.fail(f"not within {seconds} s")

    def connect(self, *publishers):
        """Spin until publishers and those who listen in this process know one another.

        A subscription that does not know its publisher yet drops what comes, though the publisher
        counts it already.
        """
        topics = {publisher.topic_name for publisher in publishers}

        def connected():
            heard = [
                subscription.get_publisher_count()
                for node in self.nodes
                for subscription in node.subscriptions
                if subscription.topic_name in topics
            ]
            return all(heard) and all(one.get_subscription_count() for one in publishers)

        self.spin_until(connected)

    def spin(self, seconds):
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.05)

    def close(self):
        for node in self.nodes:
            node.destroy_node()
        self.executor.shutdown()


class Program:
    """A program of the package in a process of its own, with what it says."""

    def __init__(self, module, *arguments):
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-u",
                *(() if module == "-c" else ("-m",)),
                module,
                *map(str, arguments),
            ],
            cwd=REPOSITORY,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | {"RCUTILS_COLORIZED_OUTPUT": "0"},
        )
        self.lines = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line.rstrip())

    @property
    def text(self):
        return "\n".join(self.lines)

    def wait_for(self, pattern, seconds=PATIENCE_S):
        """Return the first match in what the program says."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            found = re.search(pattern, self.text)
            if found:
                return found
            if self.process.poll() is not None and not self._reader.is_alive():
                break
            time.sleep(0.02)
        found = re.search(pattern, self.text)
        assert found, f"{pattern!r} is not in:\n{self.text}"
        return found

    def end(self, number=signal.SIGINT, seconds=PATIENCE_S):
        """Send a signal and return the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        status = self.process.wait(timeout=seconds)
        self._reader.join(timeout=PATIENCE_S)
        return status


@pytest.fixture
def start():
    """Return a function that starts a module as a process; all end with the test."""
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    programs = []

    def begin(module, *arguments):
        programs.append(Program(module, *arguments))
        return programs[-1]

    yield begin
    for program in programs:
        if program.process.poll() is None:
            program.process.kill()
            program.process.wait()


@pytest.fixture
def hovering(ros):
    """Return a function that makes a hovering drone (see hovering.py)."""
    kind = runpy.run_path(str(Path(__file__).with_name("hovering.py")))["Drone"]
    return lambda *arguments, **more: kind(ros, *arguments, **more)


@pytest.fixture
def in_step(start, tmp_path):
    """Return a function that starts a player, the messages of one topic in step with answers."""
    kind = runpy.run_path(str(Path(__file__).with_name("stepping.py")))["InStep"]
    return lambda topic, *arguments: kind(start, tmp_path, topic, *arguments)


def drone(t):
    """Return east, north, height in m and roll, pitch, yaw of the camera in rad at a time."""
    angles = (0.02 * math.sin(t), math.radians(50.0) + 0.05 * math.sin(0.7 * t), math.pi / 2)
    return 0.5 * t, 0.1 * t, 10.0 + 0.02 * t, *angles  # height has no stamp: it changes slowly


def boxes(t):
    """Return the pixels (n, 2) of the robots at a time, by the project's own camera."""
    from aerial_gnss_ros.core.camera.model import CameraModel
    from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy

    camera = CameraModel(*SIZE, "plumb_bob", np.array(matrix_k()).reshape(3, 3))
    east, north, height, *angles = drone(t)
    enu_from_optical = matrix_from_rpy(*angles) @ FLU_FROM_OPTICAL
    points = [(e + v * t - east, n - north, -height) for e, n, v in ROBOTS.values()]
    pixels, valid = camera.project(np.array(points) @ enu_from_optical)
    assert valid.all()
    assert camera.inside(pixels).all()
    return pixels


def matrix_k():
    width, height = SIZE
    return [FOCAL_PX, 0.0, width / 2, 0.0, FOCAL_PX, height / 2, 0.0, 0.0, 1.0]


def header(t):
    ns = START_NS + round(t * 1e9)
    return {
        "stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9},
        "frame_id": "camera_optical",
    }


def picture(t):
    """Return the water in blue with a red square on each robot."""
    image = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    image[:] = (120, 60, 20)
    for u, v in boxes(t):
        left, top = round(u) - 6, round(v) - 3
        image[top : top + 7, left : left + 13] = (30, 30, 220)
    return image


def telemetry(t_step):
    """Yield (time, topic, msgtype, fields) of all telemetry of one step of 50 ms."""
    from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
    from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu

    t = 0.05 * t_step
    east, north, height, *angles = drone(t)
    x, y, z, w = (float(q) for q in quaternion_from_matrix(matrix_from_rpy(*angles)))
    quaternion = {"x": x, "y": y, "z": z, "w": w}
    yield (
        "gimbal",
        "geometry_msgs/msg/QuaternionStamped",
        {"header": header(t), "quaternion": quaternion},
    )
    if t_step % 2 == 0:
        yield "height", "std_msgs/msg/Float64", {"data": height}
    if t_step % 4 == 0:
        place = geodetic_from_enu(east, north, height, LATITUDE, LONGITUDE, 0.0)
        latitude, longitude = (math.degrees(float(value)) for value in place[:2])
        fix = {
            "header": header(t), "latitude": latitude, "longitude": longitude,
            "altitude": height, "status": {"status": 0},
        }  # fmt: skip
        yield "fix", "sensor_msgs/msg/NavSatFix", fix


def info(t, size=SIZE, k=None):
    return {
        "header": header(t), "width": size[0], "height": size[1],
        "distortion_model": "plumb_bob", "d": [0.0] * 5, "k": k or matrix_k(),
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [FOCAL_PX, 0.0, SIZE[0] / 2, 0.0, 0.0, FOCAL_PX, SIZE[1] / 2, 0.0, 0.0, 0.0, 1.0, 0.0],
    }  # fmt: skip


def image_fields(t, image=None):
    image = picture(t) if image is None else image
    height, width = image.shape[:2]
    return {
        "header": header(t), "width": width, "height": height, "encoding": "bgr8",
        "step": 3 * width, "data": image.tobytes(),
    }  # fmt: skip


def array_fields(t):
    found = [
        {
            "results": [{"hypothesis": {"class_id": "aqua", "score": 0.9}}],
            "bbox": {"center": {"position": {"x": u, "y": v}}, "size_x": 13.0, "size_y": 7.0},
        }
        for u, v in boxes(t).tolist()
    ]
    return {"header": header(t), "detections": found}


@pytest.fixture(scope="session")
def flight(tmp_path_factory):
    """Return a function that writes a bag: 5 s over two robots, boxes or images at 5 Hz."""
    from aerial_gnss_ros.bags.writer import SENSOR, BagWriter

    folder = tmp_path_factory.mktemp("flights")

    def write(kind, seconds=5.0, namespace=""):
        path = folder / f"{kind}_{seconds}_{namespace}"
        if path.exists():
            return path
        with BagWriter(path, namespace=namespace) as bag:
            for step in range(round(seconds / 0.05) + 1):
                log_ns = START_NS + step * 50_000_000
                for topic, msgtype, fields in telemetry(step):
                    bag.write(topic, msgtype, log_ns, fields, SENSOR)
                if step % 4:
                    continue
                t = 0.05 * step
                bag.write(
                    "camera/camera_info", "sensor_msgs/msg/CameraInfo", log_ns, info(t), SENSOR
                )
                later = log_ns + 20_000_000
                if kind == "boxes":
                    array = "vision_msgs/msg/Detection2DArray"
                    bag.write("detections", array, later, array_fields(t))
                else:
                    image = "sensor_msgs/msg/Image"
                    bag.write("camera/image_raw", image, later, image_fields(t), SENSOR)
        return path

    return write
