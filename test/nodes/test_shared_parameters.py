# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameter files that other programs share, and what may be changed in which state."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rclpy.parameter import Parameter  # noqa: E402

from aerial_gnss_ros import cli  # noqa: E402
from aerial_gnss_ros.adapters.parameter_files import foreign, read  # noqa: E402
from aerial_gnss_ros.core.values.errors import ConfigError, ModelError  # noqa: E402
from aerial_gnss_ros.nodes import ros_arguments  # noqa: E402
from aerial_gnss_ros.nodes.detector_node import DetectorNode  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.schemas import SCHEMAS  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402

SHARED = "/**:\n  ros__parameters: {robot_name: x, max_wait: 2.0}\n"
OWN = "/d1/estimator:\n  ros__parameters: {robot_name: x}\n"


@pytest.mark.parametrize("section", ["/**", "/*", "/d1/*", "/d1/**"])
def test_a_key_of_other_programs_is_reported_and_left_out(tmp_path, section):
    path, reported = tmp_path / "p.yaml", []
    path.write_text(SHARED.replace("/**", section))
    read([path], SCHEMAS, "/" if section == "/*" else "/d1", reported.append)
    assert reported[0].startswith(
        f"{path}: robot_name is not a parameter of this package and is ignored"
    )
    node, namespace = "estimator", "/" if section == "/*" else "/d1"
    assert foreign([path], SCHEMAS, node, namespace) == {"robot_name": str(path)}


@pytest.mark.parametrize("text", [OWN, SHARED + OWN, "robot_name: x\n"], ids=len)
def test_in_an_own_section_it_is_refused(tmp_path, text):
    path = tmp_path / "p.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError, match="robot_name is not a parameter"):
        read([path], SCHEMAS, "/d1", [].append)
    if "ros__parameters" in text:
        assert foreign([path], SCHEMAS, "estimator", "/d1") == {}


def test_both_nodes_start_with_a_file_that_ros_was_given(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(SHARED)
    arguments = ["x", "--ros-args", "--params-file", str(path)]
    rclpy.init(args=arguments)
    ros_arguments.remember(arguments)
    try:
        estimator = EstimatorNode()
        assert estimator.get_parameter("max_wait").value == 2.0
        detector = DetectorNode(load=lambda _config: SimpleNamespace(name="x", class_names=()))
        for node in (estimator, detector):
            assert not node.has_parameter("robot_name")
            node.destroy_node()
    finally:
        ros_arguments.remember([])
        rclpy.try_shutdown()


def test_an_unconfigured_detector_takes_another_model(ros, tmp_path):
    path, loaded = tmp_path / "p.yaml", []
    path.write_text("autostart: false\n")

    def load(config):
        loaded.append(config.model)
        if config.model == "absent":
            raise ModelError("absent")
        return SimpleNamespace(name="x", class_names=("aqua",))

    node = ros.add(DetectorNode(Given([path]), load=load))

    def set_to(name, value):
        return node.set_parameters([Parameter(name, value=value)])[0]

    assert set_to("model", "mine.onnx").successful
    assert set_to("image.topic", "other/image").successful
    refused = set_to("detections.topic", "elsewhere")
    assert refused.reason == "detections.topic can only be set at the start"
    node.trigger_configure()
    node.trigger_activate()
    assert loaded == ["mine.onnx"]
    assert node._images.topic == "/other/image"
    refused = set_to("model", "absent")
    assert not refused.successful
    assert refused.reason.startswith("model can be changed while the detector is unconfigured, not")
    node.trigger_deactivate()
    node.trigger_cleanup()
    assert set_to("model", "second.onnx").successful
    node.trigger_configure()
    assert loaded == ["mine.onnx", "second.onnx"]


def test_the_water_level_can_be_changed_in_flight(ros, hovering):
    node = ros.add(EstimatorNode())
    drone = hovering()
    assert node.set_parameters([Parameter("water_level.value_m", value=-2.0)])[0].successful
    for _ in range(6):
        drone.boxes(drone.telemetry(drone.now_ns), at=((420.0, 180.0),))
        ros.spin(0.1)
    drone.telemetry(drone.now_ns)
    ros.spin_until(lambda: node._images == 6)
    (robot,) = node._departures.present
    # 10 m above the reference, 12 m above the water: 100 px are 2.4 m, not 2.0 m.
    assert sum(robot.position**2) ** 0.5 == pytest.approx(2.4, abs=0.05)


@pytest.mark.parametrize("more", [[], ["--one-process"]])
def test_one_name_for_both_nodes_is_refused(capsys, more):
    assert cli.main(["run", *more, "--ros-args", "-r", "__node:=both"]) == 2
    said = capsys.readouterr().err.strip()
    assert said == (
        "aerial-gnss: -r __node:=both gives detector and estimator the same name; rename "
        "one of them: -r detector:__node:=both, or run it alone with --node."
    )
