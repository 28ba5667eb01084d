# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drone that hovers over a robot, for tests of nodes."""

from __future__ import annotations

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.ros_messages import message, message_class

SENSORS = {
    "gimbal": "geometry_msgs/msg/QuaternionStamped",
    "height": "std_msgs/msg/Float64",
    "fix": "sensor_msgs/msg/NavSatFix",
    "camera/camera_info": "sensor_msgs/msg/CameraInfo",
}


class Drone:
    """Publishes a hovering drone's telemetry and boxes with the stamps that a test chooses.

    `clock_offset_ns`: of the camera's clock, by which all is stamped, to the node's.
    """

    def __init__(self, ros, namespace="", clock_offset_ns=0, unheard=()):
        self.clock_offset_ns = clock_offset_ns
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
        ros.connect(*(p for topic, p in self.publishers.items() if topic not in unheard))

    def send(self, topic, **fields):
        self.publishers[topic].publish(message(self.kinds[topic], fields))
        self.ros.spin(0.01)

    @property
    def now_ns(self):
        return self.node.get_clock().now().nanoseconds + self.clock_offset_ns

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

    def boxes(self, header, score=0.9, at=((320.0, 180.0),)):
        found = [
            {
                "results": [{"hypothesis": {"class_id": "aqua", "score": score}}],
                "bbox": {"center": {"position": {"x": u, "y": v}}, "size_x": 20.0, "size_y": 10.0},
            }
            for u, v in at
        ]
        self.send("detections", header=header, detections=found)

    def fly(self, images=6):
        """Send telemetry and as many images, stamped with the node's own time; return the last."""
        for _ in range(images):
            header = self.telemetry(self.now_ns)
            self.boxes(header)
            self.ros.spin(0.1)
        self.telemetry(self.now_ns)
        return nanoseconds(message("std_msgs/msg/Header", header).stamp)
