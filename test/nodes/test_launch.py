# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The launch files, as far as it can be tried without ROS' launch packages.

These are not on PyPI, so stand-ins record what the files ask for. What is not tried here: that
launch itself accepts it. `aerial-gnss run` with the resulting arguments is tried for real.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.nodes.schemas import SCHEMAS


class Recorded(SimpleNamespace):
    """An action or substitution that remembers its arguments."""

    def __init__(self, *args, **fields):
        super().__init__(args=args, **fields)

    def perform(self, context):
        return context[self.args[0]]


@pytest.fixture
def launch_file(loaded):
    """Return the launch file of a drone as a module."""
    return loaded("aerial_gnss.launch.py")


@pytest.fixture
def loaded(repository, monkeypatch):
    """Return a function that returns a launch file as a module."""
    modules = {
        "launch": ["LaunchContext", "LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "LogInfo", "OpaqueFunction", "Shutdown"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
    }
    for name, classes in modules.items():
        module = ModuleType(name)
        for kind in classes:
            setattr(module, kind, type(kind, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)

    def load(name):
        path = repository / "launch" / name
        spec = importlib.util.spec_from_file_location(path.stem.replace(".", "_"), path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


def started(launch_file, **given):
    """Return the actions for launch arguments, the others at their defaults."""
    *declared, opaque = launch_file.generate_launch_description().args[0]
    defaults = {one.args[0]: one.default_value for one in declared}
    assert set(given) <= set(defaults)
    return opaque.function(defaults | given)


def split(node):
    """Return a node's arguments without the session's file, and that file."""
    words = list(node.arguments)
    at = words.index("--session")
    session = Path(words[at + 1])
    del words[at : at + 2]
    return words, session


def test_defaults_start_two_processes_that_are_started_again(launch_file):
    nodes = started(launch_file)
    for name, node in zip(("detector", "estimator"), nodes, strict=True):
        assert (node.package, node.executable) == ("aerial_gnss_ros", "aerial-gnss")
        assert split(node)[0] == ["run", "--node", name, "--vehicle", "generic"]
        assert (node.namespace, node.parameters) == ("", [])
        assert (node.respawn, node.respawn_delay, node.ros_arguments) == (True, 1.0, [])
    session = split(nodes[0])[1]
    assert session == split(nodes[1])[1]
    assert session.parent.is_dir()
    assert session.parent.stat().st_mode & 0o077 == 0


def test_the_end_of_a_node_is_judged(launch_file):
    assert all(callable(node.on_exit) for node in started(launch_file))


def test_every_argument_reaches_its_place(launch_file):
    _, node, player = started(
        launch_file, namespace="drone1", vehicle="/v.yaml", params="/a.yaml, /b.yaml",
        model="/m.onnx", bag="/flight", enclave="/aerial_gnss", respawn="false", log_level="debug",
    )  # fmt: skip
    expected = ["run", "--node", "estimator", "--vehicle", "/v.yaml"]
    expected += ["--params", "/a.yaml", "/b.yaml", "--enclave", "/aerial_gnss"]
    assert split(node)[0] == expected
    assert node.namespace == "drone1"
    assert node.parameters == [{"model": "/m.onnx", "use_sim_time": True}]
    assert (node.respawn, node.ros_arguments) == (False, ["--log-level", "debug"])
    assert player.arguments == ["play", "/flight", "--wait-for", "detector", "estimator"]
    assert player.namespace == "drone1"
    assert started(launch_file, use_sim_time="True")[0].parameters == [{"use_sim_time": True}]
    assert started(launch_file, autostart="false")[0].parameters == [{"autostart": False}]


def test_the_page_is_served_where_it_is_asked_for(launch_file):
    assert len(started(launch_file)) == 2
    *_, page = started(
        launch_file, view="192.0.2.1", namespace="drone1", vehicle="mavros_px4", params="/a.yaml"
    )
    expected = ["view", "--bind", "192.0.2.1", "--namespace", "drone1"]
    assert page.arguments == [*expected, "--vehicle", "mavros_px4", "--params", "/a.yaml"]


def test_the_end_of_the_bag_ends_launch_and_one_that_cannot_be_played_does_so_with_an_error(
    launch_file,
):
    player = started(launch_file, bag="/flight")[-1]
    assert player.on_exit(SimpleNamespace(returncode=0), None).reason == "the bag has ended"
    with pytest.raises(RuntimeError, match="the bag could not be played"):
        player.on_exit(SimpleNamespace(returncode=2), None)


def test_every_parameter_that_it_sets_is_one_of_a_node(launch_file):
    node, *_ = started(launch_file, model="/m.onnx", autostart="false", bag="/flight")
    known = {leaf.name for schema in SCHEMAS.values() for leaf in leaves(schema)}
    assert {name for name in node.parameters[0] if name not in known} == {"use_sim_time"}


def test_rviz_shows_the_topics_of_the_namespace_where_it_is_installed(launch_file, monkeypatch):
    monkeypatch.setattr(launch_file.shutil, "which", lambda name: f"/ros/bin/{name}")
    assert len(started(launch_file)) == 2
    rviz = started(launch_file, rviz="true", namespace="drone1", use_sim_time="true")[2]
    assert (rviz.package, rviz.executable) == ("rviz2", "rviz2")
    assert rviz.parameters == [{"use_sim_time": True}]
    option, path = rviz.arguments
    text = Path(path).read_text(encoding="utf-8")
    assert option == "-d"
    assert "Value: /drone1/robots/markers\n" in text
    assert "Fixed Frame: drone1/map\n" in text
    player = started(launch_file, rviz="true", bag="/flight")[3]
    assert player.arguments[0] == "play"


def test_without_rviz_a_sentence_says_so_and_the_nodes_run(launch_file, monkeypatch):
    monkeypatch.setattr(launch_file.shutil, "which", lambda _name: None)
    monkeypatch.setenv("ROS_DISTRO", "humble")
    *nodes, said = started(launch_file, rviz="true")
    assert [node.executable for node in nodes] == ["aerial-gnss"] * 2
    assert said.msg.startswith("rviz:=true, but rviz2 is not installed: the nodes run without it.")
    assert "apt install ros-humble-rviz2" in said.msg


@pytest.mark.parametrize("vehicle", vehicle_names())
def test_every_profile_is_a_vehicle_that_it_can_start(launch_file, vehicle):
    for node in started(launch_file, vehicle=vehicle):
        words, _ = split(node)
        assert words[3:] == ["--vehicle", vehicle]
        assert vehicle_file(words[-1]).is_file()


def test_run_understands_what_launch_gives_it(launch_file, start, tmp_path):
    model = tmp_path / "absent.onnx"
    detector, estimator = started(launch_file, namespace="drone1", model=str(model))
    parameters = tmp_path / "launch_params.yaml"  # launch_ros writes the dict into such a file
    parameters.write_text(f"/**:\n  ros__parameters:\n    model: {model}\n")
    ros = ["--ros-args", "-r", f"__ns:=/{detector.namespace}", "--params-file", str(parameters)]
    programs = [start("aerial_gnss_ros.cli", *one.arguments, *ros) for one in (detector, estimator)]
    assert programs[0].process.wait(timeout=90.0) == 2  # ends where the model is looked for
    programs[0].wait_for(f"aerial-gnss: .*{model}")
    programs[1].wait_for(r"\[drone1.estimator\]: method filter; .* fix /drone1/fix")
    assert programs[1].end() == 0


def test_the_fleet_is_a_process_that_is_started_again(loaded):
    file = loaded("fleet.launch.py")
    (node,) = started(file)
    assert (node.arguments, node.namespace, node.parameters) == (
        ["run", "--node", "fleet"], "fleet", []
    )  # fmt: skip
    assert (node.respawn, node.respawn_delay, node.ros_arguments) == (True, 1.0, [])
    context = SimpleNamespace(is_shutdown=False)
    node.on_exit(SimpleNamespace(returncode=1), context)
    with pytest.raises(RuntimeError, match="the fleet refuses its parameters"):
        node.on_exit(SimpleNamespace(returncode=2), context)


def test_every_argument_of_the_fleet_reaches_its_place(loaded):
    node, page = started(
        loaded("fleet.launch.py"), drones="/drone1, /drone2", namespace="shore", params="/a.yaml",
        use_sim_time="true", enclave="/boat", respawn="false", log_level="debug", view="192.0.2.1",
    )  # fmt: skip
    assert node.arguments == [
        "run", "--node", "fleet", "--params", "/a.yaml", "--enclave", "/boat"
    ]  # fmt: skip
    assert node.parameters == [{"drones": ["/drone1", "/drone2"], "use_sim_time": True}]
    assert (node.namespace, node.respawn) == ("shore", False)
    assert node.ros_arguments == ["--log-level", "debug"]
    assert page.arguments == ["view", "--bind", "192.0.2.1", "--namespace", "shore"]
    assert "drones" in {leaf.name for leaf in leaves(SCHEMAS["fleet"])}
