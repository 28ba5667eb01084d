# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Starts the fleet, a process that is started again if it dies, and its page.

    ros2 launch aerial_gnss_ros fleet.launch.py drones:=/drone1,/drone2 view:=0.0.0.0

Each drone starts its own detector and estimator, with sightings.drone: see docs/howto/drones.md. A
parameter's value comes from, in this order: the arguments drones and use_sim_time, the files in
params (the last one that has it), the default. Wrong input ends launch with status 1; with
respawn:=false so does every other end of the node.
"""

from __future__ import annotations

from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from aerial_gnss_ros.nodes.launching import (
    END_S,
    RESPAWN_DELAY_S,
    end_where_restarts_are_of_no_use,
    is_true,
    listed,
    whole_namespace,
)

ARGUMENTS = {
    "drones": ("", "namespaces of the drones, separated by commas; empty: as the parameters say"),
    "namespace": ("fleet", "of the node and, as all topics are relative, of its topics"),
    "params": ("", "parameter files, separated by commas"),
    "use_sim_time": ("false", "true: the time comes from /clock, as with a bag"),
    "enclave": ("", "of ROS' security, such as /aerial_gnss; the node's own is below it"),
    "respawn": ("true", "false: a node that ends is not started again, and ends launch"),
    "log_level": ("", "of the node: debug, info, warn, error or fatal"),
    "view": ("", "address of the live page: 127.0.0.1 for this computer, 0.0.0.0 for its networks"),
}


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: Any) -> list[Any]:
    """Return the actions once the arguments are known."""
    given = {name: str(LaunchConfiguration(name).perform(context)).strip() for name in ARGUMENTS}
    arguments = ["run", "--node", "fleet"]
    if files := listed(given["params"]):
        arguments += ["--params", *files]
    if given["enclave"]:
        arguments += ["--enclave", given["enclave"]]
    parameters: dict[str, Any] = {}
    if drones := listed(given["drones"]):
        parameters["drones"] = drones
    if is_true(given["use_sim_time"]):
        parameters["use_sim_time"] = True
    respawn = is_true(given["respawn"])
    node = Node(
        package="aerial_gnss_ros",
        executable="aerial-gnss",
        arguments=arguments,
        namespace=given["namespace"],
        parameters=[parameters] if parameters else [],
        ros_arguments=["--log-level", given["log_level"]] if given["log_level"] else [],
        output="screen",
        emulate_tty=True,
        respawn=respawn,
        respawn_delay=RESPAWN_DELAY_S,
        sigterm_timeout=END_S,
        on_exit=end_where_restarts_are_of_no_use("fleet", respawn),
    )
    if not given["view"]:
        return [node]
    return [node, _page(given["view"], whole_namespace(context, given["namespace"]))]


def _page(address: str, namespace: str) -> Node:
    """Return the server of the live page; without it the fleet goes on."""
    return Node(
        package="aerial_gnss_ros",
        executable="aerial-gnss",
        arguments=["view", "--bind", address, "--namespace", namespace],
        output="screen",
        emulate_tty=True,
    )
