# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator node: positions latched for every robot, and words about what is missing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import SECOND_NS, nanoseconds

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402

from aerial_gnss_ros.adapters.results import (  # noqa: E402
    FIX,
    NO_FIX,
    UNKNOWN_LENGTH_M2,
    markers,
)
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State  # noqa: E402
from aerial_gnss_ros.nodes import positions  # noqa: E402
from aerial_gnss_ros.nodes.diagnostics import ERROR, OK, STALE, WARN  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def latched():
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def listen(ros, msgtype, topic, profile):
    got = []
    ros.node("late").create_subscription(message_class(msgtype), topic, got.append, profile)
    return got


def test_a_late_subscriber_gets_the_last_position_at_once(ros, hovering):
    node = ros.add(EstimatorNode())
    stand_still(node)
    last_ns = hovering().fly()
    ros.spin_until(lambda: node._images == 6)
    fixes = listen(ros, "sensor_msgs/msg/NavSatFix", "/robots/aqua_1/fix", latched())
    pose = "geographic_msgs/msg/GeoPoseWithCovarianceStamped"
    poses = listen(ros, pose, "/robots/aqua_1/geo_pose", latched())
    odometry = listen(ros, "nav_msgs/msg/Odometry", "/robots/aqua_1/odom", latched())
    datum = listen(ros, "geographic_msgs/msg/GeoPoseStamped", "/map_datum", latched())
    markers = listen(ros, "visualization_msgs/msg/MarkerArray", "/robots/markers", latched())
    default = listen(ros, "sensor_msgs/msg/NavSatFix", "/robots/aqua_1/fix", 10)
    ros.spin_until(lambda: all((fixes, poses, odometry, datum, markers)))
    assert nanoseconds(fixes[0].header.stamp) == last_ns  # the image's, not the time of sending
    assert fixes[0].latitude == pytest.approx(13.0, abs=1e-7)
    assert fixes[0].longitude == pytest.approx(-59.0, abs=1e-7)
    assert fixes[0].position_covariance[0] > 1.2**2  # the GNSS offset is in it
    assert poses[0].pose.pose.position.latitude == fixes[0].latitude
    assert odometry[0].header.frame_id == "map"
    assert datum[0].pose.position.latitude == pytest.approx(13.0)
    assert [marker.ns for marker in markers[0].markers][1] == "aqua_1"
    assert not default  # who does not ask for it does not get it


def test_the_picture_is_made_for_whoever_listens_and_for_nobody_else(ros, hovering, monkeypatch):
    made = []
    monkeypatch.setattr(
        positions,
        "markers",
        lambda result, _frames: made.append(result.stamp_ns) or markers(result),
    )
    node = ros.add(EstimatorNode())
    stand_still(node)
    drone = hovering()
    drone.fly()
    ros.spin_until(lambda: node._images == 6)
    assert not made
    viewer = "visualization_msgs/msg/MarkerArray"
    first = listen(ros, viewer, "/robots/markers", 10)  # RViz asks for a volatile one
    ros.spin_until(lambda: first)
    assert len(made) == 1
    drone.fly(3)
    ros.spin_until(lambda: node._images == 9 and len(first) == 4)
    second = listen(ros, viewer, "/robots/markers", latched())
    ros.spin_until(lambda: second)
    assert nanoseconds(second[0].markers[0].header.stamp) == made[-1]


def test_namespace_remapping_and_own_topics(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("height: {topic: altimeter}\ndetections: {classes: [aqua], min_score: 0.8}\n")
    node = ros.add(EstimatorNode(Given([path], "drone1")))
    topics = {source.name: source.topic for source in node.inputs}
    assert topics["fix"] == "/drone1/fix"
    assert topics["height"] == "/drone1/altimeter"
    assert node.get_fully_qualified_name() == "/drone1/estimator"


def test_in_a_namespace_everything_is_in_it(ros, hovering):
    node = ros.add(EstimatorNode(Given(namespace="drone1")))
    hovering("drone1").fly()
    fixes = listen(ros, "sensor_msgs/msg/NavSatFix", "/drone1/robots/aqua_1/fix", latched())
    ros.spin_until(lambda: fixes and node._images == 6)
    ours = [name for name, _ in node.get_publisher_names_and_types_by_node("estimator", "/drone1")]
    shared = {"/diagnostics", "/parameter_events", "/rosout", "/tf", "/tf_static"}
    assert {"/drone1/map_datum", "/drone1/robots/markers"} <= set(ours)
    assert all(name.startswith("/drone1/") for name in set(ours) - shared)


def test_diagnostics_tell_inputs_robots_and_refusals(ros, hovering):
    node = ros.add(EstimatorNode())
    arrays = []
    ros.node("panel").create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    drone = hovering()
    drone.fly()
    now_ns = drone.node.get_clock().now().nanoseconds
    header = drone.telemetry(now_ns)
    drone.boxes(header, score=0.1)
    drone.telemetry(now_ns + 1)
    drone.send("height", data=float("nan"))
    ros.spin_until(lambda: node._images == 7)
    arrays.clear()
    ros.spin_until(lambda: arrays)
    lines = {status.name.removeprefix("estimator: "): status for status in arrays[-1].status}
    values = {name: {v.key: v.value for v in line.values} for name, line in lines.items()}
    assert lines["fix"].level == OK
    assert values["fix"]["topic"] == "/fix"
    assert float(values["fix"]["rate_hz"]) > 0.0
    assert float(values["fix"]["age_s"]) < 5.0
    assert values["fix"]["state"] == "ok"
    assert lines["height"].level == ERROR
    assert lines["attitude"].level == OK  # not needed with a gimbal that refers to the earth
    assert values["robot aqua_1"]["state"] == "coasting"
    assert float(values["robot aqua_1"]["sigma_m"]) > 1.2
    assert float(values["robot aqua_1"]["last_seen_s"]) < 10.0
    assert values["positions"]["rejected_low_score"] == "1"
    assert values["positions"]["images"] == "7"
    counts = {key: int(n) for key, n in values["positions"].items() if n.isdigit()}
    refused = sum(n for key, n in counts.items() if key.startswith("rejected_"))
    assert counts["boxes"] == counts["boxes_used"] + refused
    assert counts["boxes_used"] > 1
    assert any(key.startswith("ms_") for key in values["positions"])
    assert lines["stated noise"].message == "not judged yet"  # six boxes are too few
    assert float(values["stated noise"]["heading_sigma_deg"]) == pytest.approx(2.0, abs=0.01)


def test_images_without_a_stamp_are_an_error_that_names_them(ros, hovering):
    node = ros.add(EstimatorNode())
    arrays, logged = [], []
    panel = ros.node("panel")
    panel.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    panel.create_subscription(message_class("rcl_interfaces/msg/Log"), "/rosout", logged.append, 10)
    drone = hovering()
    drone.telemetry(drone.now_ns)
    for _ in range(3):
        drone.boxes({"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"})
    ros.spin_until(lambda: node._estimator.dropped == {"no_stamp": 3})
    arrays.clear()
    ros.spin_until(lambda: arrays)
    lines = {status.name: status for status in arrays[-1].status}
    assert lines["estimator: detections"].level == ERROR
    assert "(3 of 3): its stamp is 0" in lines["estimator: detections"].message
    told = [one.msg for one in logged if "stamp" in one.msg]
    assert [one.split(":")[0] for one in told] == ["Messages on detections are refused"]


def test_before_simulated_time_begins_nothing_is_taken(ros, hovering, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: true\n")
    node = ros.add(EstimatorNode(Given([path])))
    hovering().telemetry(5)
    assert any("/clock is silent" in sentence for sentence in node._said)
    status = {line.name: line for line in node.statuses()}["positions"]
    assert (status.level, status.message) == (STALE, "no image yet")


def test_the_state_file_is_written_at_the_end(ros, hovering, tmp_path):
    state = tmp_path / "names.json"
    path = tmp_path / "p.yaml"
    path.write_text(f"state_file: {state}\n")
    node = EstimatorNode(Given([path]))
    ros.executor.add_node(node)
    hovering().fly()
    ros.spin_until(lambda: node._images == 6)
    node.destroy_node()
    assert "aqua_1" in state.read_text()


def stand_still(node):
    """Keep a node from predicting: it begins 2 s after the last image, however busy we are."""
    node._overdue.due = lambda _now_ns: None


def robot_fixes(ros):
    """Listen to a robot; return its positions as (stamp in ns, status, variance east)."""
    got = []

    def take(fix):
        variance = fix.position_covariance[0]
        got.append((nanoseconds(fix.header.stamp), fix.status.status, variance))

    profile = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    kind = message_class("sensor_msgs/msg/NavSatFix")
    ros.node("robot").create_subscription(kind, "/robots/aqua_1/fix", take, profile)
    return got


@pytest.mark.parametrize("offset_s", [0.0, -1e6])
def test_when_detections_end_positions_go_on_once_a_second_and_grow_uncertain(
    ros, hovering, tmp_path, offset_s
):
    """With the stamps of another clock, too: predicted are times of the images' clock."""
    path = tmp_path / "p.yaml"
    path.write_text("height: {source: constant, value_m: 10.0}\n")  # a topic has this clock
    node = ros.add(EstimatorNode(Given([path])))
    fixes = robot_fixes(ros)
    last_ns = hovering(clock_offset_ns=round(offset_s * 1e9), unheard=["height"]).fly()
    ros.spin_until(lambda: fixes and fixes[-1][0] > last_ns + 4 * SECOND_NS)
    assert node._images == 6
    measured = [fix for fix in fixes if fix[0] <= last_ns]
    assert measured[-1][:2] == (last_ns, FIX)
    predicted = fixes[len(measured) :]
    assert {status for _, status, _ in predicted} == {NO_FIX}
    after_s = [(stamp_ns - last_ns) / SECOND_NS for stamp_ns, *_ in predicted]
    assert after_s[0] >= 2.0
    # Once in each second by the image's clock: on a busy machine late, so that one may be left out.
    assert [int(a) < int(b) for a, b in pairwise(after_s)] == [True] * (len(after_s) - 1)
    variances = [measured[-1][2]] + [variance for *_, variance in predicted]
    assert variances == sorted(variances)
    assert variances[-1] > variances[0] + 0.05
    late = listen(ros, "sensor_msgs/msg/NavSatFix", "/robots/aqua_1/fix", latched())
    ros.spin_until(lambda: late)
    assert late[0].status.status == NO_FIX
    lines = {line.name: line for line in node.statuses()}
    assert lines["positions"].level == WARN
    assert lines["positions"].message.endswith(" s: 1 robot predicted")
    assert lines["robot aqua_1"].message == "coasting"


def test_what_stays_latched_of_a_lost_robot_claims_nothing(ros, hovering, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("tracks: {coast_s: 1.5}\n")
    node = ros.add(EstimatorNode(Given([path])))
    drone = hovering()
    drone.fly()
    fixes = robot_fixes(ros)
    ros.spin_until(lambda: fixes and fixes[-1][2] == UNKNOWN_LENGTH_M2)
    assert fixes[-1][1] == NO_FIX
    count = len(fixes)
    ros.spin(2.0)
    assert len(fixes) == count  # the last word
    assert node._departures.present == ()


def test_the_filter_goes_on_where_it_was_when_images_come_again(ros, hovering):
    node = ros.add(EstimatorNode())
    drone = hovering()
    drone.fly()
    fixes = robot_fixes(ros)
    ros.spin_until(lambda: fixes and fixes[-1][1] == NO_FIX)
    predicted = fixes[-1]
    drone.fly()
    ros.spin_until(lambda: any(fix[1] == FIX and fix[0] > predicted[0] for fix in fixes))
    assert [robot.robot_id for robot in node._departures.present] == ["aqua_1"]


def test_while_simulated_time_stands_still_nothing_is_predicted(ros, hovering, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: true\n")
    node = ros.add(EstimatorNode(Given([path])))
    kind = message_class("rosgraph_msgs/msg/Clock")
    clock = ros.node("clock").create_publisher(kind, "/clock", 1)
    ros.spin_until(clock.get_subscription_count)
    drone = hovering()

    def at(seconds):
        def is_heard():
            clock.publish(message("rosgraph_msgs/msg/Clock", {"clock": {"sec": seconds}}))
            return node.now_ns() == seconds * SECOND_NS

        ros.spin_until(is_heard)

    for second in range(100, 106):
        at(second)
        drone.boxes(drone.telemetry(second * SECOND_NS))
    at(106)
    drone.telemetry(106 * SECOND_NS)
    ros.spin_until(lambda: node._images == 6)
    fixes = robot_fixes(ros)
    ros.spin(3.0)
    assert [fix[:2] for fix in fixes] == [(105 * SECOND_NS, FIX)]
    at(108)
    ros.spin_until(lambda: len(fixes) > 1)
    assert fixes[-1][:2] == (108 * SECOND_NS, NO_FIX)


def test_an_error_in_a_callback_is_survived_reported_once_and_counted(start, ros, hovering):
    program = start("-c", FAILING)
    program.wait_for("method filter")
    assert ros
    drone = hovering()
    drone.fly()
    program.wait_for("(?s)please report it:.*ZeroDivisionError: division by zero")
    got = listen(ros, "diagnostic_msgs/msg/DiagnosticArray", "/diagnostics", 10)

    def line():
        found = [one for array in got for one in array.status if one.name == "estimator: node"]
        return found[-1] if found else None

    ros.spin_until(lambda: line() and line().level == WARN)
    assert int(line().values[0].value) > 1
    assert "ZeroDivisionError" in line().message
    assert program.text.count("please report it") == 1
    assert program.end() == 0, program.text


FAILING = """
import sys
from aerial_gnss_ros.nodes import estimator, estimator_node
estimator_node.nanoseconds = lambda *_: 1 / 0
sys.exit(estimator.main())
"""


def test_topics_of_robots_lost_long_ago_end_where_there_are_very_many(ros, monkeypatch):
    monkeypatch.setattr(positions, "MOST_LATCHED", 3)
    node = ros.add(EstimatorNode())

    def sent(*names):
        estimates = tuple(
            RobotEstimate(
                1, name, "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, np.zeros(2), np.zeros(2),
                np.eye(4), 1,
            )
            for name in names
        )  # fmt: skip
        node._send(FrameResult(1, "camera", estimates, (), None))
        return sorted({topic.split("/")[1] for topic in node._positions.publishers})

    assert sent("b", "a") == ["a", "b"]
    assert sent("b", "c") == ["a", "b", "c"]
    assert sent("c") == ["a", "b", "c"]
    assert sent("c", "d") == ["b", "c", "d"]  # a was lost before b
    assert sent("c", "d", "e", "f", "g") == ["c", "d", "e", "f", "g"]
    assert len(node._positions.publishers) == 15
    listed = {name for name, _ in node.get_publisher_names_and_types_by_node("estimator", "/")}
    assert "/robots/g/fix" in listed
    assert "/robots/a/fix" not in listed
