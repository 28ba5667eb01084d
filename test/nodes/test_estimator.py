# SPDX-License-Identifier: Apache-2.0
"""The estimator node: positions latched for every robot, and words about what is missing."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.stamps import nanoseconds

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402

from aerial_gnss_ros.adapters.results import markers  # noqa: E402
from aerial_gnss_ros.nodes import on_demand, qos  # noqa: E402
from aerial_gnss_ros.nodes.diagnostics import ERROR, OK, STALE  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.ros_messages import message, message_class  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402

SENSORS = {
    "gimbal": "geometry_msgs/msg/QuaternionStamped",
    "height": "std_msgs/msg/Float64",
    "fix": "sensor_msgs/msg/NavSatFix",
    "camera/camera_info": "sensor_msgs/msg/CameraInfo",
}


class Drone:
    """Publishes a hovering drone's telemetry and boxes with the stamps that a test chooses."""

    def __init__(self, ros, namespace=""):
        prefix = f"/{namespace}/" if namespace else "/"
        self.ros, self.node = ros, ros.node("drone")
        self.publishers = {
            topic: self.node.create_publisher(message_class(kind), prefix + topic, qos.sensor(20))
            for topic, kind in SENSORS.items()
        }
        self.array = message_class("vision_msgs/msg/Detection2DArray")
        self.publishers["detections"] = self.node.create_publisher(
            self.array, prefix + "detections", qos.detections()
        )
        self.kinds = SENSORS | {"detections": "vision_msgs/msg/Detection2DArray"}
        ros.spin_until(lambda: all(p.get_subscription_count() for p in self.publishers.values()))
        ros.spin(0.3)

    def send(self, topic, **fields):
        self.publishers[topic].publish(message(self.kinds[topic], fields))
        self.ros.spin(0.01)

    def telemetry(self, ns):
        header = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": "camera"}
        half = 0.5**0.5
        self.send("gimbal", header=header, quaternion={"y": half, "w": half})  # straight down
        self.send("height", data=10.0)
        self.send("fix", header=header, latitude=13.0, longitude=-59.0, status={"status": 0})
        k = [500.0, 0.0, 320.0, 0.0, 500.0, 180.0, 0.0, 0.0, 1.0]
        self.send(
            "camera/camera_info", header=header, width=640, height=360, k=k, d=[0.0] * 5,
            distortion_model="plumb_bob",
        )  # fmt: skip
        return header

    def boxes(self, header, score=0.9, v=180.0):
        box = {
            "results": [{"hypothesis": {"class_id": "aqua", "score": score}}],
            "bbox": {"center": {"position": {"x": 320.0, "y": v}}, "size_x": 20.0, "size_y": 10.0},
        }
        self.send("detections", header=header, detections=[box])

    def fly(self, images=6):
        """Send telemetry and as many images, stamped with the node's own time; return the last."""
        for _ in range(images):
            header = self.telemetry(self.node.get_clock().now().nanoseconds)
            self.boxes(header)
            self.ros.spin(0.1)
        self.telemetry(self.node.get_clock().now().nanoseconds)
        return nanoseconds(message("std_msgs/msg/Header", header).stamp)


def latched():
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def listen(ros, msgtype, topic, profile):
    got = []
    ros.node("late").create_subscription(message_class(msgtype), topic, got.append, profile)
    return got


def test_a_late_subscriber_gets_the_last_position_at_once(ros):
    node = ros.add(EstimatorNode())
    last_ns = Drone(ros).fly()
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


def test_the_picture_is_made_for_whoever_listens_and_for_nobody_else(ros, monkeypatch):
    made = []
    monkeypatch.setattr(
        on_demand, "markers", lambda result: made.append(result.stamp_ns) or markers(result)
    )
    node = ros.add(EstimatorNode())
    drone = Drone(ros)
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


def test_in_a_namespace_everything_is_in_it(ros):
    node = ros.add(EstimatorNode(Given(namespace="drone1")))
    Drone(ros, "drone1").fly()
    fixes = listen(ros, "sensor_msgs/msg/NavSatFix", "/drone1/robots/aqua_1/fix", latched())
    ros.spin_until(lambda: fixes and node._images == 6)
    ours = [name for name, _ in node.get_publisher_names_and_types_by_node("estimator", "/drone1")]
    shared = {"/diagnostics", "/parameter_events", "/rosout"}
    assert {"/drone1/map_datum", "/drone1/robots/markers"} <= set(ours)
    assert all(name.startswith("/drone1/") for name in set(ours) - shared)


def test_diagnostics_tell_inputs_robots_and_refusals(ros):
    node = ros.add(EstimatorNode())
    arrays = []
    ros.node("panel").create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    drone = Drone(ros)
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
    assert float(values["fix"]["rate_hz"]) > 2.0
    assert float(values["fix"]["age_s"]) < 5.0
    assert values["fix"]["state"] == "ok"
    assert lines["height"].level == ERROR
    assert lines["attitude"].level == OK  # not needed with a gimbal that refers to the earth
    assert values["robot aqua_1"]["state"] == "coasting"
    assert float(values["robot aqua_1"]["sigma_m"]) > 1.2
    assert float(values["robot aqua_1"]["last_seen_s"]) < 10.0
    assert values["positions"]["rejected_low_score"] == "1"
    assert values["positions"]["images"] == "7"
    assert any(key.startswith("ms_") for key in values["positions"])
    assert lines["stated noise"].message == "not judged yet"  # six boxes tell too little
    assert float(values["stated noise"]["heading_sigma_deg"]) == pytest.approx(1.5, abs=0.01)


def test_before_simulated_time_begins_nothing_is_taken(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: true\n")
    node = ros.add(EstimatorNode(Given([path])))
    Drone(ros).telemetry(5)
    assert any("/clock silent" in sentence for sentence in node._said)
    status = {line.name: line for line in node.statuses()}["positions"]
    assert (status.level, status.message) == (STALE, "no image yet")


def test_the_state_file_is_written_at_the_end(ros, tmp_path):
    state = tmp_path / "names.json"
    path = tmp_path / "p.yaml"
    path.write_text(f"state_file: {state}\n")
    node = EstimatorNode(Given([path]))
    ros.executor.add_node(node)
    Drone(ros).fly()
    ros.spin_until(lambda: node._images == 6)
    node.destroy_node()
    assert "aqua_1" in state.read_text()
