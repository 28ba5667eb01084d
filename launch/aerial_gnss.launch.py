# SPDX-License-Identifier: Apache-2.0
"""Starts detector and estimator for one vehicle: `aerial-gnss run` with launch arguments.

    ros2 launch aerial_gnss_ros aerial_gnss.launch.py vehicle:=generic namespace:=drone1

A parameter's value comes from, in this order: the arguments model, autostart and use_sim_time, the
files in params (the last one that has it), the vehicle profile, the default. Nothing is downloaded.

Both nodes run in one process. To free the network's memory in flight, and to take it up again:

    ros2 lifecycle set /drone1/detector deactivate; ros2 lifecycle set /drone1/detector cleanup
    ros2 lifecycle set /drone1/detector configure; ros2 lifecycle set /drone1/detector activate
"""

from __future__ import annotations

from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "namespace": ("", "of both nodes and, as all topics are relative, of their topics"),
    "vehicle": ("generic", "name of a profile in config/vehicles, or the path of a YAML file"),
    "params": ("", "parameter files, separated by commas"),
    "model": ("", "path of the detection model; empty: as the parameters say"),
    "use_sim_time": ("false", "true: the time comes from /clock, as with a bag"),
    "autostart": ("true", "false: the detector waits for its lifecycle transitions"),
    "bag": ("", "rosbag2 to play with /clock; use_sim_time is then true"),
}


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def _is_true(text: str) -> bool:
    return text.lower() in ("true", "1", "yes", "on")


def start(context: LaunchContext) -> list[Any]:
    """Return the actions once the arguments are known."""
    given = {name: str(LaunchConfiguration(name).perform(context)).strip() for name in ARGUMENTS}
    arguments = ["run", "--vehicle", given["vehicle"]]
    files = [name.strip() for name in given["params"].split(",") if name.strip()]
    if files:
        arguments += ["--params", *files]
    parameters: dict[str, Any] = {}
    if given["model"]:
        parameters["model"] = given["model"]
    if given["bag"] or _is_true(given["use_sim_time"]):
        parameters["use_sim_time"] = True
    if not _is_true(given["autostart"]):
        parameters["autostart"] = False
    nodes = Node(
        package="aerial_gnss_ros",
        executable="aerial-gnss",
        arguments=arguments,
        namespace=given["namespace"],
        parameters=[parameters] if parameters else [],
        output="screen",
        emulate_tty=True,
    )
    if not given["bag"]:
        return [nodes]
    return [nodes, ExecuteProcess(cmd=["ros2", "bag", "play", given["bag"], "--clock"])]
