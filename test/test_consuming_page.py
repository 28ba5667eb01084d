# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The code and YAML of docs/howto/consuming.md: it runs, and robot_localization knows its keys."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading

import numpy as np
import pytest
import yaml

from aerial_gnss_ros.adapters.results import position_update
from aerial_gnss_ros.core.values.estimates import MapDatum, RobotEstimate, State

# robot_localization, branch ros2: params/ekf.yaml and src/ros_filter.cpp.
KEYS = {
    "frequency", "two_d_mode", "map_frame", "odom_frame", "base_link_frame", "world_frame",
    "publish_tf", "smooth_lagged_data", "history_length",
}  # fmt: skip
SENSOR_KEYS = {"config", "differential", "relative", "queue_size"}
STATE = 15
X_Y = [True, True] + [False] * 13


@pytest.fixture(scope="module")
def blocks(repository):
    """Return the page's fenced blocks by language."""
    text = (repository / "docs/howto/consuming.md").read_text(encoding="utf-8")
    found = {}
    for language, block in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        found.setdefault(language, []).append(block)
    return found


def test_robot_localization_gets_x_and_y_of_position_update_alone(blocks):
    [node] = yaml.safe_load(blocks["yaml"][0]).values()
    parameters = node["ros__parameters"]
    sensors = {"odom0", "imu0", "pose0"}
    for key, value in parameters.items():
        name, _, rest = key.partition("_")
        if name not in sensors:
            assert key in KEYS, key
        elif rest:
            assert rest in SENSOR_KEYS, key
        if rest == "config":
            assert len(value) == STATE
    assert parameters["pose0"] == "/robots/aqua_1/position_update"
    assert parameters["pose0_config"] == X_Y
    assert parameters["world_frame"] == parameters["map_frame"]


def test_what_it_gets_is_in_its_world_frame_with_a_covariance_of_what_it_uses(blocks):
    """As its documentation has it: a pose is taken in world_frame, unused rows of it are cut out.

    robot_localization, doc/state_estimation_nodes.rst and src/ros_filter.cpp (preparePose).
    """
    [node] = yaml.safe_load(blocks["yaml"][0]).values()
    parameters = node["ros__parameters"]
    robot = RobotEstimate(
        0, "aqua_1", "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, np.array([3.0, -4.0]), np.zeros(2),
        np.diag([4.0, 9.0, 1.0, 1.0]), 0,
    )  # fmt: skip
    outgoing = position_update(robot, MapDatum(0.2, -1.0, 0.0))
    assert parameters["pose0"] == f"/{outgoing.topic}"
    assert outgoing.msgtype == "geometry_msgs/msg/PoseWithCovarianceStamped"
    assert outgoing.fields["header"]["frame_id"] == parameters["world_frame"]
    used = np.flatnonzero(parameters["pose0_config"][:6])  # x, y, z, roll, pitch, yaw
    pose = outgoing.fields["pose"]
    whole = np.reshape(pose["covariance"], (6, 6))
    assert whole[np.ix_(used, used)].tolist() == [[4.0, 0.0], [0.0, 9.0]]
    place = pose["pose"]["position"]
    assert [list(place.values())[index] for index in used] == [3.0, -4.0]


STUBS = {
    "rclcpp/rclcpp.hpp": """
#pragma once
#include <memory>
#include <string>
namespace rclcpp {
struct QoS { explicit QoS(int); QoS & reliable(); QoS & transient_local(); };
template <class T> struct Subscription {};
struct Node {
  template <class T, class F>
  std::shared_ptr<Subscription<T>> create_subscription(const std::string &, const QoS &, F && call)
  { const T message{}; call(message); return nullptr; }
};
}
""",
    "sensor_msgs/msg/nav_sat_fix.hpp": """
#pragma once
namespace sensor_msgs::msg {
struct NavSatStatus { signed char status; };
struct NavSatFix { NavSatStatus status; double position_covariance[9]; };
}
""",
    "geometry_msgs/msg/pose_with_covariance_stamped.hpp": """
#pragma once
namespace geometry_msgs::msg { struct PoseWithCovarianceStamped {}; }
""",
}


def test_the_lines_in_cpp_compile_against_stubs_of_the_declarations_that_they_use(blocks, tmp_path):
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("g++ is not installed")
    for name, text in STUBS.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    includes = "\n".join(f"#include <{name}>" for name in STUBS)
    (tmp_path / "page.cpp").write_text(
        f"{includes}\nvoid on_update(const geometry_msgs::msg::PoseWithCovarianceStamped &);\n"
        f"void page(std::shared_ptr<rclcpp::Node> node) {{\n{blocks['cpp'][0]}"
        "(void)fixes; (void)updates; }\n"
    )
    done = subprocess.run(
        [compiler, "-std=c++17", "-Wall", "-Werror", "-Wno-unused-variable", "-fsyntax-only",
         "-I", str(tmp_path), str(tmp_path / "page.cpp")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_the_ten_lines_get_the_position_that_was_latched_before(blocks):
    rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from sensor_msgs.msg import NavSatFix

    from aerial_gnss_ros.nodes import qos

    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("estimator", context=context)
    publisher = node.create_publisher(NavSatFix, "robots/aqua_1/fix", qos.latched())
    message = NavSatFix(latitude=13.5, longitude=-59.5)
    message.status.status = 0
    message.position_covariance[0] = 4.0
    publisher.publish(message)
    stop = threading.Event()
    done = subprocess.run(
        [sys.executable, "-c", blocks["python"][0]],
        env=os.environ, capture_output=True, text=True, timeout=300.0, check=False,
    )  # fmt: skip
    stop.set()
    node.destroy_node()
    rclpy.shutdown(context=context)
    assert done.stdout.split() == ["13.5", "-59.5", "2.0", "0"], done.stderr
