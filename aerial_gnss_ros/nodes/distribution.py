# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences between the rclpy of ROS 2 Humble and of Jazzy; no other module depends on them.

Written from rclpy's sources (branches humble and jazzy). Humble itself was not available.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

try:
    from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
except ImportError:  # Humble
    from rclpy.qos_event import PublisherEventCallbacks, SubscriptionEventCallbacks

    TELLS_INFO = False
else:
    TELLS_INFO = True
"""Whether callbacks of subscriptions may ask for a message's info, such as when it was sent."""

__all__ = ["PublisherEventCallbacks", "SubscriptionEventCallbacks", "after_changes", "with_info"]


def with_info(callback: Callable[[Any, dict[str, Any]], None]) -> Callable[..., None]:
    """Return a callback for a subscription that takes a message and its info.

    On Humble the info is empty.
    """
    if TELLS_INFO:
        return callback

    def alone(msg: Any) -> None:
        callback(msg, {})

    return alone


def after_changes(node: Node, changed: Callable[[list[Parameter]], None]) -> None:
    """Call a function when parameters have new values, once all callbacks have agreed.

    Humble has no such callback. There it is called in the executor's next cycle, with the
    parameters that have the requested values: another callback may have refused.
    """
    if hasattr(node, "add_post_set_parameters_callback"):
        node.add_post_set_parameters_callback(changed)
        return
    steady = Clock(clock_type=ClockType.STEADY_TIME)

    def agreed(parameters: list[Parameter]) -> SetParametersResult:
        def later() -> None:
            node.destroy_timer(timer)
            taken = [one for one in parameters if _is_set(node, one)]
            if taken:
                changed(taken)

        timer = node.create_timer(0.0, later, clock=steady)
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(agreed)


def _is_set(node: Node, parameter: Parameter) -> bool:
    name = parameter.name
    if parameter.type_ == Parameter.Type.NOT_SET:  # it was deleted
        return not node.has_parameter(name)
    return bool(node.has_parameter(name) and node.get_parameter(name).value == parameter.value)
