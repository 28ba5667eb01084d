# SPDX-License-Identifier: Apache-2.0
"""The launch file, as far as it can be tried without ROS' launch packages.

These are not on PyPI, so stand-ins record what the file asks for. What is not tried here: that
launch itself accepts it. `aerial-gnss run` with the resulting arguments is tried for real.
"""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType, SimpleNamespace

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.core.parameters import leaves
from aerial_gnss_ros.nodes.schemas import SCHEMAS


class Recorded(SimpleNamespace):
    """An action or substitution that remembers its arguments."""

    def __init__(self, *args, **fields):
        super().__init__(args=args, **fields)

    def perform(self, context):
        return context[self.args[0]]


@pytest.fixture
def launch_file(repository, monkeypatch):
    """Return the launch file as a module."""
    modules = {
        "launch": ["LaunchContext", "LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "ExecuteProcess", "OpaqueFunction"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
    }
    for name, classes in modules.items():
        module = ModuleType(name)
        for kind in classes:
            setattr(module, kind, type(kind, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    path = repository / "launch" / "aerial_gnss.launch.py"
    spec = importlib.util.spec_from_file_location("aerial_gnss_launch", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def started(launch_file, **given):
    """Return the actions for launch arguments, the others at their defaults."""
    *declared, opaque = launch_file.generate_launch_description().args[0]
    defaults = {one.args[0]: one.default_value for one in declared}
    assert set(given) <= set(defaults)
    return opaque.function(defaults | given)


def test_defaults_start_both_nodes_in_one_process(launch_file):
    (node,) = started(launch_file)
    assert (node.package, node.executable) == ("aerial_gnss_ros", "aerial-gnss")
    assert node.arguments == ["run", "--vehicle", "generic"]
    assert (node.namespace, node.parameters) == ("", [])


def test_every_argument_reaches_its_place(launch_file):
    node, player = started(
        launch_file, namespace="drone1", vehicle="/v.yaml", params="/a.yaml, /b.yaml",
        model="/m.onnx", bag="/flight",
    )  # fmt: skip
    assert node.arguments == ["run", "--vehicle", "/v.yaml", "--params", "/a.yaml", "/b.yaml"]
    assert node.namespace == "drone1"
    assert node.parameters == [{"model": "/m.onnx", "use_sim_time": True}]
    assert player.cmd == ["ros2", "bag", "play", "/flight", "--clock"]
    assert started(launch_file, use_sim_time="True")[0].parameters == [{"use_sim_time": True}]
    assert started(launch_file, autostart="false")[0].parameters == [{"autostart": False}]


def test_every_parameter_that_it_sets_is_one_of_a_node(launch_file):
    node, _ = started(launch_file, model="/m.onnx", autostart="false", bag="/flight")
    known = {leaf.name for schema in SCHEMAS.values() for leaf in leaves(schema)}
    assert {name for name in node.parameters[0] if name not in known} == {"use_sim_time"}


@pytest.mark.parametrize("vehicle", vehicle_names())
def test_every_profile_is_a_vehicle_that_it_can_start(launch_file, vehicle):
    (node,) = started(launch_file, vehicle=vehicle)
    assert node.arguments == ["run", "--vehicle", vehicle]
    assert vehicle_file(node.arguments[-1]).is_file()


def test_run_understands_what_launch_gives_it(launch_file, capfd, tmp_path):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    model = tmp_path / "absent.onnx"
    (node,) = started(launch_file, namespace="drone1", model=str(model))
    parameters = tmp_path / "launch_params.yaml"  # launch_ros writes the dict into such a file
    parameters.write_text(f"/**:\n  ros__parameters:\n    model: {model}\n")
    ros = ["--ros-args", "-r", f"__ns:=/{node.namespace}", "--params-file", str(parameters)]
    assert cli.main([*node.arguments, *ros]) == 2  # ends where the model is looked for
    said = capfd.readouterr().err
    assert "[drone1.estimator]: method filter" in said
    assert "/drone1/fix" in said
    assert f"aerial-gnss: the model {model}" in said or f"{model}" in said.splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--vehicle", "submarine"], "submarine is not a vehicle profile; there are"),
        (["--params", "/absent.yaml"], "/absent.yaml: cannot be read: No such file"),
        (["--namespace", "1 2"], "'1 2' cannot be a namespace"),
        (["--ros-args", "-p", "max_wiat:=1.0"], "max_wiat is not a parameter"),
    ],
)
def test_run_refuses_what_is_wrong_with_status_2(capfd, arguments, sentence):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    assert cli.main(["run", *arguments]) == 2
    said = capfd.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("aerial-gnss: ")
    assert sentence in said
