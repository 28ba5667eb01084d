# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Starts detector and estimator for one vehicle, each a process that is started again if it dies.

    ros2 launch aerial_gnss_ros aerial_gnss.launch.py vehicle:=generic namespace:=drone1

A parameter's value comes from, in this order: the arguments model, autostart and use_sim_time, the
files in params (the last one that has it), the vehicle profile, the default. Nothing is downloaded.

Wrong input ends all, and launch with status 1: a restart would not mend it; with respawn:=false so
does every other end of a node. A bag begins when both nodes listen, and ends launch.

To free the network's memory in flight, and to take it up again:

    ros2 lifecycle set /drone1/detector deactivate; ros2 lifecycle set /drone1/detector cleanup
    ros2 lifecycle set /drone1/detector configure; ros2 lifecycle set /drone1/detector activate
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from pathlib import Path
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from aerial_gnss_ros.adapters.viewers import rviz_in_namespace
from aerial_gnss_ros.nodes.launching import (
    END_S,
    RESPAWN_DELAY_S,
    end_where_restarts_are_of_no_use,
    is_true,
    listed,
    whole_namespace,
)
from aerial_gnss_ros.resources import ros_distribution, rviz_path

ARGUMENTS = {
    "namespace": ("", "of both nodes and, as all topics are relative, of their topics"),
    "vehicle": ("generic", "name of a profile in config/vehicles, or the path of a YAML file"),
    "params": ("", "parameter files, separated by commas"),
    "model": ("", "path of the detection model; empty: as the parameters say"),
    "use_sim_time": ("false", "true: the time comes from /clock, as with a bag"),
    "autostart": ("true", "false: the detector waits for its lifecycle transitions"),
    "enclave": ("", "of ROS' security, such as /aerial_gnss: each node's own is below it"),
    "respawn": ("true", "false: a node that ends is not started again, and ends launch"),
    "log_level": ("", "of both nodes: debug, info, warn, error or fatal"),
    "rviz": (
        "false",
        "true: shows robots, frames and images with boxes in RViz, if it is installed",
    ),
    "view": ("", "address of the live page: 127.0.0.1 for this computer, 0.0.0.0 for its networks"),
    "bag": ("", "rosbag2 to play into the nodes; use_sim_time is then true, and its end ends all"),
}

NODES = ("detector", "estimator")


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[Any]:
    """Return the actions once the arguments are known."""
    given = {name: str(LaunchConfiguration(name).perform(context)).strip() for name in ARGUMENTS}
    arguments = ["--vehicle", given["vehicle"], "--session", _session_file()]
    files = listed(given["params"])
    if files:
        arguments += ["--params", *files]
    if given["enclave"]:
        arguments += ["--enclave", given["enclave"]]
    parameters: dict[str, Any] = {}
    if given["model"]:
        parameters["model"] = given["model"]
    if given["bag"] or is_true(given["use_sim_time"]):
        parameters["use_sim_time"] = True
    if not is_true(given["autostart"]):
        parameters["autostart"] = False
    respawn = is_true(given["respawn"])
    nodes = [
        Node(
            package="aerial_gnss_ros",
            executable="aerial-gnss",
            arguments=["run", "--node", name, *arguments],
            namespace=given["namespace"],
            parameters=[parameters] if parameters else [],
            ros_arguments=["--log-level", given["log_level"]] if given["log_level"] else [],
            output="screen",
            emulate_tty=True,
            respawn=respawn,
            respawn_delay=RESPAWN_DELAY_S,
            sigterm_timeout=END_S,
            on_exit=end_where_restarts_are_of_no_use(name, respawn),
        )
        for name in NODES
    ]
    more: list[Any] = []
    if is_true(given["rviz"]):
        more.append(
            _rviz(whole_namespace(context, given["namespace"]), "use_sim_time" in parameters)
        )
    if given["view"]:
        more.append(_page(given, whole_namespace(context, given["namespace"]), files))
    if given["bag"]:
        more.append(_player(given))
    return [*nodes, *more]


def _rviz(namespace: str, sim_time: bool) -> Any:
    """Return RViz with the topics of a namespace, or the sentence that it is not installed.

    Args:
        namespace: of the nodes.
        sim_time: whether the time comes from /clock.
    """
    if shutil.which("rviz2") is None:
        return LogInfo(
            msg="rviz:=true, but rviz2 is not installed: the nodes run without it. "
            f"`apt install ros-{ros_distribution()}-rviz2 "
            f"ros-{ros_distribution()}-compressed-image-transport` installs it."
        )
    text = rviz_path("aerial_gnss.rviz").read_text(encoding="utf-8")
    config = Path(_own_folder()) / "aerial_gnss.rviz"
    config.write_text(rviz_in_namespace(text, namespace), encoding="utf-8")
    return Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(config)],
        parameters=[{"use_sim_time": True}] if sim_time else [],
        output="screen",
    )


def _page(given: dict[str, str], namespace: str, files: list[str]) -> Node:
    """Return the server of the live page; without it the flight goes on."""
    arguments = ["view", "--bind", given["view"], "--namespace", namespace]
    arguments += ["--vehicle", given["vehicle"]]
    for file in files:
        arguments += ["--params", file]
    return Node(
        package="aerial_gnss_ros",
        executable="aerial-gnss",
        arguments=arguments,
        output="screen",
        emulate_tty=True,
    )


def _player(given: dict[str, str]) -> Node:
    """Return what plays a bag into the nodes' namespace, from when both listen."""
    return Node(
        package="aerial_gnss_ros",
        executable="aerial-gnss",
        arguments=["play", given["bag"], "--wait-for", *NODES],
        namespace=given["namespace"],
        output="screen",
        emulate_tty=True,
        on_exit=end_with_the_bag,
    )


def end_with_the_bag(event: Any, _context: Any) -> Shutdown:
    """Return the end of launch once the bag is played; raise where it could not be.

    What is raised there ends all of launch, and lets it return 1.
    """
    if event.returncode:
        raise RuntimeError("the bag could not be played, as it says above")
    return Shutdown(reason="the bag has ended")


def _session_file() -> str:
    """Return where the estimator keeps names for its restart."""
    return f"{_own_folder()}/names.json"


def _own_folder() -> str:
    """Return a new folder that goes when launch ends."""
    folder = tempfile.mkdtemp(prefix="aerial_gnss_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
