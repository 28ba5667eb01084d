# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the nodes: nothing wrong is taken, nothing unknown is ignored."""

from __future__ import annotations

import cmath
import math

import pytest

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.rejection import Reason

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from rcl_interfaces.srv import SetParameters, SetParametersAtomically  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402

from aerial_gnss_ros.nodes import process  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.parameters import declare, own_values  # noqa: E402
from aerial_gnss_ros.nodes.ros_arguments import parameter_files  # noqa: E402
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
    assert (latency.floating_point_range[0].from_value, latency.read_only) == (-3.0, False)
    assert node.describe_parameter("gimbal.reference").additional_constraints.startswith("one of ")


def test_parameters_of_a_class_are_declared_with_their_meaning_and_kind(ros):
    values = own_values("estimator", {"classes.aqua.max_speed": 1, "classes.aqua.coast_s": 60.0})
    node = ros.add(Node("estimator"))
    declare(node, EstimatorConfig, values)
    assert node.get_parameter("classes.aqua.max_speed").type_ == Parameter.Type.DOUBLE
    described = node.describe_parameter("classes.aqua.coast_s")
    assert "longest dive" in described.description
    assert not described.read_only


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


class Remote:
    """Another program that sets parameters over DDS, as `ros2 param` does."""

    def __init__(self, ros):
        self.ros, node = ros, ros.node("remote")
        self.clients = [
            node.create_client(SetParameters, "/estimator/set_parameters"),
            node.create_client(SetParametersAtomically, "/estimator/set_parameters_atomically"),
        ]
        ros.spin_until(lambda: all(one.service_is_ready() for one in self.clients))

    def set_to(self, **values):
        """Set parameters, all or none; return why they are refused, empty: they are not."""
        named = {name.replace("__", "."): value for name, value in values.items()}
        wanted = [Parameter(k, value=v).to_parameter_msg() for k, v in named.items()]
        many = len(wanted) > 1
        kind = SetParametersAtomically if many else SetParameters
        answer = self.clients[many].call_async(kind.Request(parameters=wanted))
        self.ros.spin_until(answer.done)
        result = answer.result().result if many else answer.result().results[0]
        return "" if result.successful else result.reason


def test_another_calibration_moves_robots_that_keep_their_names(ros, hovering):
    node, drone, remote = ros.add(EstimatorNode()), hovering(), Remote(ros)

    def fly():
        count = node._images + 6
        for _ in range(6):
            drone.boxes(drone.telemetry(drone.now_ns), at=((420.0, 180.0), (320.0, 280.0)))
            ros.spin(0.1)
        drone.telemetry(drone.now_ns)
        ros.spin_until(lambda: node._images == count)
        return {one.robot_id: one.position for one in node._departures.present}

    before = fly()
    assert set(before) == {"aqua_1", "aqua_2"}
    for place in before.values():
        assert math.hypot(*place) == pytest.approx(2.0, abs=0.02)
    assert not remote.set_to(calibration__heading_deg=30.0, calibration__height_m=2.0)
    now = node._estimator.predicted(drone.now_ns).estimates  # before any further image
    for found in ({one.robot_id: one.position for one in now}, fly()):
        assert set(found) == set(before)
        for name, (east, north) in before.items():
            turned = complex(east, north) * 1.2 * cmath.exp(1j * math.radians(30.0))
            assert list(found[name]) == pytest.approx([turned.real, turned.imag], abs=0.05)
    assert not remote.set_to(calibration__focal_scale=1.2)
    for name, place in fly().items():
        assert math.dist(place, (0.0, 0.0)) == pytest.approx(2.0, abs=0.05), name
    assert not remote.set_to(camera__latency_s=0.05)
    assert set(fly()) == set(before)


def test_what_cannot_be_used_is_refused_with_a_sentence_and_changes_nothing(ros):
    node, remote = ros.add(EstimatorNode()), Remote(ros)
    before = dict(node.values)
    for name, value, sentence in [
        ("detections.area", "/absent.json", "detections.area is /absent.json, which cannot be r"),
        ("detections.area", "{}", "GeoJSON"),
        ("detections.classes", "aqua", "must be a list of text"),
        ("references.pier", "{class: beacon}", "references.pier must have a position or a topic"),
        ("references.pier", "pier", "references.pier must be text with its keys"),
        ("references.pier.class", "beacon", "references.pier must have a position or a topic"),
        ("references.boat", '{class: boat, topic: "a b"}', "'a b' is not a valid topic"),
        ("classes.aqua.max_sped", 1.0, "did you mean classes.aqua.max_speed?"),
        ("classes.aqua.max_speed", 99.0, "must lie within 0.01 to 50 (m/s), not 99."),
        ("calibration.heading", 3.0, "did you mean calibration.heading_deg?"),
        ("robots.leader.class", "aqua", "Restart it with the new robots."),
        ("qos_overrides.x", 1, "is not declared"),
        ("max_wait", 1.0, "read-only"),
    ]:
        said = remote.set_to(**{name: value})
        assert sentence in said, name
        assert "Traceback" not in said
    assert "not 99" in remote.set_to(
        **{"calibration.height_m": 1.0, "classes.aqua.max_speed": 99.0}
    )
    assert node.values == before
    assert node._estimator._config.calibration.height_m == 0.0


def test_classes_area_and_references_are_changed_in_flight(ros, hovering):
    node, drone, remote = ros.add(EstimatorNode()), hovering(), Remote(ros)

    def declared(prefix):
        return {k: p.value for k, p in node.get_parameters_by_prefix(prefix).items()}

    def rejected(reason):
        count = node._images + 3
        before = node._estimator.counts[reason]
        for _ in range(3):
            drone.boxes(drone.telemetry(drone.now_ns))
            ros.spin(0.1)
        drone.telemetry(drone.now_ns)
        ros.spin_until(lambda: node._images == count)
        return node._estimator.counts[reason] - before

    drone.fly()
    ros.spin_until(lambda: node._departures.present)
    ring = "[[[1.0, 1.0], [1.1, 1.0], [1.1, 1.1], [1.0, 1.0]]]"
    assert not remote.set_to(detections__area=f'{{"type": "Polygon", "coordinates": {ring}}}')
    assert rejected(Reason.OUTSIDE_AREA) == 3
    assert not remote.set_to(detections__area="")
    assert rejected(Reason.OUTSIDE_AREA) == 0
    assert not remote.set_to(detections__classes=["boat"])
    assert rejected(Reason.WRONG_CLASS) == 3
    assert [one.robot_id for one in node._departures.present] == ["aqua_1"]  # predicted
    assert not remote.set_to(detections__classes=[])
    assert rejected(Reason.WRONG_CLASS) == 0

    assert not remote.set_to(**{"classes.aqua.max_speed": 0.2})
    assert not remote.set_to(**{"classes.aqua": "{max_speed: 0.4, coast_s: 30.0}"})
    assert declared("classes") == {"aqua.max_speed": 0.4, "aqua.coast_s": 30.0}
    joint = node._estimator._tracks.pipeline.tracking.table.filter
    assert joint.motions.of(["aqua"])[1] == pytest.approx([0.2])
    assert joint.groups[0].own[1] == pytest.approx([0.2])
    assert not remote.set_to(**{"classes.aqua.coast_s": None})  # as `ros2 param delete`
    assert declared("classes") == {"aqua.max_speed": 0.4}
    assert not remote.set_to(**{"classes.aqua": None})
    assert declared("classes") == {}
    assert joint.motions.alike

    assert not remote.set_to(**{"references.boat": "{class: boat, topic: boat/fix}"})
    assert "/boat/fix" in {source.topic for source in node.inputs}
    assert declared("references") == {"boat.class": "boat", "boat.topic": "boat/fix"}
    assert not remote.set_to(**{"references.boat.topic": "other/fix"})
    assert [s.topic for s in node.inputs if s.name == "reference_boat"] == ["/other/fix"]
    assert "reference_boat" in node._estimator.inputs
    assert not remote.set_to(**{"references.boat": ""})
    assert "reference_boat" not in {source.name for source in node.inputs}
    assert "reference_boat" not in node._estimator.inputs
    assert rejected(Reason.WRONG_CLASS) == 0
    assert [one.robot_id for one in node._departures.present] == ["aqua_1"]


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
        (["--ros-args", "-r", "fix:=1bad"], "a remapping rule is invalid (fix:=1bad); it has"),
        (["--ros-args", "-r", "__ns:=//a/"], "is not of the form from:=to, such as __ns:=/d1."),
    ],
)
def test_bad_arguments_end_with_status_2_and_a_sentence(capfd, arguments, sentence):
    assert process.main("estimator", EstimatorNode, ["estimator", *arguments]) == 2
    assert sentence in capfd.readouterr().err.strip().splitlines()[-1]
    assert not parameter_files()  # another node of this process has arguments of its own


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
