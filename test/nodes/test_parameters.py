# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the nodes: nothing wrong is taken, nothing unknown is ignored."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.errors import ConfigError

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rclpy.node import Node  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402

from aerial_gnss_ros.nodes import process  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.parameters import declare, own_values  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def test_every_parameter_is_declared_with_its_meaning(ros):
    node = ros.add(EstimatorNode())
    for leaf in leaves(EstimatorConfig):
        value, described = node.get_parameter(leaf.name).value, node.describe_parameter(leaf.name)
        default = list(leaf.default) if isinstance(leaf.default, tuple) else leaf.default
        value = value if isinstance(value, int | float | str) else list(value)
        assert value == default or (math.isnan(value) and math.isnan(default)), leaf.name
        assert leaf.key.doc in described.description
        assert described.read_only != leaf.key.dynamic
    latency = node.describe_parameter("camera.latency_s")
    assert "unit s; -3 to 3; default 0.0" in latency.description
    assert (latency.floating_point_range[0].from_value, latency.read_only) == (-3.0, True)
    assert node.describe_parameter("gimbal.reference").additional_constraints.startswith("one of ")


def test_parameters_of_a_class_are_declared_with_their_meaning_and_kind(ros):
    values = own_values("estimator", {"classes.aqua.max_speed": 1, "classes.aqua.coast_s": 60.0})
    node = ros.add(Node("estimator"))
    declare(node, EstimatorConfig, values)
    assert node.get_parameter("classes.aqua.max_speed").type_ == Parameter.Type.DOUBLE
    described = node.describe_parameter("classes.aqua.coast_s")
    assert "longest dive" in described.description
    assert described.read_only


def test_a_running_node_takes_what_is_dynamic_and_says_why_not(ros):
    node = ros.add(EstimatorNode())

    def set_to(name, value):
        return node.set_parameters([Parameter(name, value=value)])[0]

    assert set_to("detections.min_score", 0.5).successful
    assert node._estimator.min_score == 0.5
    assert set_to("detections.min_score", 1).successful  # a whole number where a float is meant
    assert node._estimator.min_score == 1.0
    refused = set_to("detections.min_score", "high")
    assert not refused.successful
    assert refused.reason == "detections.min_score must be a number, not 'high'."
    refused = set_to("detections.min_score", 1.5)
    assert not refused.successful
    assert "out of range" in refused.reason  # rclpy looks at the descriptor's range first
    assert not set_to("max_wait", 1.0).successful
    assert node._estimator.min_score == 1.0


def test_each_node_takes_its_own_share_of_what_ros_was_given():
    given = {
        "use_sim_time": True,
        "detections.min_score": 0.5,
        "score_threshold": 0.3,
        "detections.classes": None,  # how ROS hands over an empty list
        "robots.leader.class": "aqua",
    }
    assert own_values("estimator", given) == {
        "detections.min_score": 0.5, "detections.classes": (), "robots.leader.class": "aqua",
    }  # fmt: skip
    assert own_values("detector", given) == {"score_threshold": 0.3}
    with pytest.raises(ConfigError, match="score_treshold is not a parameter; did you mean score_"):
        own_values("detector", {"score_treshold": 0.3})


WHOLE = "/**:\n  ros__parameters: {%s}\n"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "/**/estimator:\n  ros__parameters: {max_wiat: 1.0}\n",
            "max_wiat is not a parameter; did you mean max_wait?",
        ),
        (WHOLE % "max_wait: soon", "max_wait must be a number (s), not 'soon'."),
        (WHOLE % "max_wait: 99.0", "max_wait must lie within 0 to 30 (s), not 99."),
        (WHOLE % "tracks: {confirm_hits: 2.5}", "tracks.confirm_hits must be a whole number"),
        (WHOLE % "gimbal: {reference: nose}", "gimbal.reference must be one of earth, heading"),
        (WHOLE % "gimbal: {rpy_deg: [0.0, 90.0]}", "gimbal.rpy_deg must have 3 elements, not 2"),
        (WHOLE % "camera: {offset_m: [0, 0.0, 0.0]}", "write all numbers with a decimal point"),
        (WHOLE % "fix: {source: constant}", "fix.latitude_deg and fix.longitude_deg must be given"),
        (WHOLE % "classes: {aqua: {max_sped: 1.0}}", "did you mean classes.aqua.max_speed?"),
        (WHOLE % "robots: {Leader: {class: aqua}}", "robots.Leader cannot be a topic name"),
        (WHOLE % 'fix: {topic: "a b"}', "'a b' is not a valid topic: "),
        ("/**:\n  ros__parameters: [1", "is not YAML"),
    ],
)
def test_a_bad_parameter_file_ends_with_status_2_and_a_sentence(tmp_path, capfd, text, sentence):
    path = tmp_path / "p.yaml"
    path.write_text(text)
    arguments = ["estimator", "--ros-args", "--params-file", str(path)]
    assert process.main("estimator", EstimatorNode, arguments) == 2
    out, err = capfd.readouterr()
    said = err.strip().splitlines()
    assert sentence in said[-1], err
    assert said[-1].startswith("estimator: ")
    assert "Traceback" not in out + err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--ros-args", "-p", "max_wiat:=1.0"], "max_wiat is not a parameter"),
        (["--ros-args", "--params-file", "/absent.yaml"], "/absent.yaml: cannot be read: No such"),
        (["--ros-args", "--nonsense"], "--nonsense"),
        (["nonsense"], "unknown argument 'nonsense'"),
        (["--ros-args", "-r", "__ns:=/1 2"], "ROS cannot start"),
    ],
)
def test_bad_arguments_end_with_status_2_and_a_sentence(capfd, arguments, sentence):
    assert process.main("estimator", EstimatorNode, ["estimator", *arguments]) == 2
    assert sentence in capfd.readouterr().err.strip().splitlines()[-1]


def test_files_of_the_program_lie_below_ros_arguments(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: true\nmax_wait: 2\ndetections: {min_score: 0.4}\n")
    rclpy.init(args=["x", "--ros-args", "-p", "detections.min_score:=0.6", "-r", "__ns:=/drone1"])
    try:
        node = EstimatorNode(Given([path]))
        assert node.get_parameter("use_sim_time").value is True
        assert node.get_parameter("max_wait").value == 2.0
        assert node.get_parameter("detections.min_score").value == 0.6
        assert {source.topic for source in node.inputs} >= {"/drone1/fix", "/drone1/detections"}
        node.destroy_node()
    finally:
        rclpy.try_shutdown()


@pytest.mark.usefixtures("ros")
def test_a_bad_namespace_is_refused():
    with pytest.raises(ConfigError, match=r"'1 2' is not a valid namespace: namespace must not"):
        EstimatorNode(Given(namespace="1 2"))
