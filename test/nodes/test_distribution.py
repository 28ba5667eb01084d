# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The nodes on an rclpy that lacks what Humble's lacks.

A stub: Jazzy's rclpy without the names and the behaviour that Humble has not, in a process of its
own. Humble itself was not at hand; its sources were read.
"""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

HUMBLE = """
import sys, types
import rclpy, rclpy.executors, rclpy.node, rclpy.subscription
import rclpy.event_handler as events
old = types.ModuleType("rclpy.qos_event")
old.PublisherEventCallbacks = events.PublisherEventCallbacks
old.SubscriptionEventCallbacks = events.SubscriptionEventCallbacks
sys.modules["rclpy.qos_event"], sys.modules["rclpy.event_handler"] = old, None
del rclpy.node.Node.add_post_set_parameters_callback

made = rclpy.subscription.Subscription.__init__
def plain(self, impl, kind, topic, callback, *args, **more):  # never the message's info
    made(self, impl, kind, topic, lambda msg: callback(msg), *args, **more)
rclpy.subscription.Subscription.__init__ = plain
"""
CHANGE = """
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo
rclpy.init()
from aerial_gnss_ros.nodes import distribution, qos
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode
assert not distribution.TELLS_INFO
executor, node, camera = SingleThreadedExecutor(), EstimatorNode(), rclpy.create_node("camera")
executor.add_node(node)
executor.add_node(camera)
def turn(number, until):
    for _ in range(number):
        executor.spin_once(timeout_sec=0.05)
        if until():
            return True
def score(value):
    return node.set_parameters([Parameter("detections.min_score", value=value)])[0].successful
camera.create_publisher(CameraInfo, "camera/camera_info", qos.latched()).publish(
    CameraInfo(height=10, width=10, k=[9.0, 0.0, 5.0, 0.0, 9.0, 5.0, 0.0, 0.0, 1.0])
)
[heard] = [one for one in node.inputs if one.name == "camera_info"]
assert turn(200, lambda: heard.arrivals.count), "a latched CameraInfo is not received"
assert score(0.5)
assert node._estimator.min_score == 0.25, "changed before all callbacks agreed"
assert turn(100, lambda: node._estimator.min_score == 0.5), "a parameter is not taken"
assert not score("high")
def change(name, *value):
    one = Parameter(name, *([Parameter.Type.STRING, *value] if value else [Parameter.Type.NOT_SET]))
    assert node.set_parameters([one])[0].successful, name
def classes():
    return {name: one.value for name, one in node.get_parameters_by_prefix("classes").items()}
own = ("aqua.max_speed", "aqua.length_m", "aqua.coast_s")
change("classes.aqua", "{max_speed: 0.4, length_m: [0.4, 0.9], coast_s: .nan}")
assert turn(100, lambda: set(classes()) == set(own)), "an entry given as text is not declared"
timers = len(list(node.timers))
assert not turn(20, lambda: len(list(node.timers)) > timers), "declaring it causes changes for ever"
change("classes.aqua.length_m")
assert turn(100, lambda: not node._config.classes[0][1].length_m), "a deleted key is kept"
change("classes.aqua")
assert turn(100, lambda: not classes() and not node._config.classes), "a deleted entry is kept"
def refuse(parameters):
    from rcl_interfaces.msg import SetParametersResult
    return SetParametersResult(successful=False, reason="another callback")
node._on_set_parameters_callbacks.append(refuse)
assert not score(0.7)
assert not turn(20, lambda: node._estimator.min_score != 0.5), "taken though it was refused"
print("all held")
"""


def test_nodes_hear_latched_messages_and_take_parameters_without_what_humble_lacks(start):
    start("-c", HUMBLE + CHANGE).wait_for("all held")
