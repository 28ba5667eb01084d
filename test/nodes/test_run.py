# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss run`: each node a process that is started again; real nodes on real DDS."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from sensor_msgs.msg import NavSatFix
from vision_msgs.msg import Detection2DArray

from aerial_gnss_ros.nodes import qos

CLI = "aerial_gnss_ros.cli"


def children(program):
    """Return the process of each node by its name."""
    found = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(path.read_text().rsplit(")", 1)[1].split()[1])
            words = (path.parent / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except (OSError, IndexError):
            continue
        if parent == program.process.pid and "--node" in words:
            found[words[words.index("--node") + 1]] = int(path.parent.name)
    return found


def until(true, seconds=90.0):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if found := true():
            return found
        time.sleep(0.05)
    return pytest.fail(f"not within {seconds} s")


def kept(folder, *names):
    """Whether what outlives a restart has these names: it is written once a second."""
    texts = [path.read_text() for path in folder.glob("aerial_gnss_*/names.json")]
    return any(all(name in text for name in names) for text in texts)


@pytest.mark.slow
def test_a_killed_estimator_is_back_with_its_names_and_the_detector_does_not_notice(
    ros, start, hovering, tmp_path, monkeypatch
):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    program = start(CLI, "run", "--ros-args", "-p", "robots.leader.class:=aqua", "-p",
                    "robots.leader.start:=[13.0, -59.0]")  # fmt: skip
    program.wait_for("method filter")
    drone, fixes = hovering(), []
    listener = ros.node("listener")
    for name in ("leader", "aqua_1"):
        topic = f"/robots/{name}/fix"
        listener.create_subscription(
            NavSatFix, topic, lambda fix, name=name: fixes.append((name, fix)), qos.latched()
        )

    def positions():
        """Fly until there are measured positions, of two robots so far apart that names differ."""
        fixes.clear()
        seen = set()
        for _ in range(300):
            header = drone.telemetry(drone.now_ns)
            drone.boxes(header, at=((320.0, 180.0), (450.0, 180.0)))
            ros.spin(0.05)
            seen = {name for name, fix in fixes if fix.status.status >= 0}
            if len(seen) == 2 and len(fixes) > 20:
                break
        return {name: fix.longitude for name, fix in fixes}

    before = positions()
    assert set(before) == {"leader", "aqua_1"}
    until(lambda: kept(tmp_path, "leader", "aqua_1"))
    was = until(lambda: children(program))
    os.kill(was["estimator"], signal.SIGKILL)
    program.wait_for("the estimator ended by SIGKILL after .*; it is restarted in 0.5 s")
    until(lambda: program.text.count("method filter") == 2)
    after = positions()
    assert {name: pytest.approx(place, abs=1e-5) for name, place in before.items()} == after
    assert children(program)["detector"] == was["detector"]
    assert program.end() == 0, program.text
    assert "Traceback" not in program.text


@pytest.mark.slow
def test_a_killed_detector_is_back_and_the_estimator_does_not_notice(ros, start):
    program = start(CLI, "run", "--namespace", "drone1")
    program.wait_for(r"model .* -> /drone1/detections")
    listener = ros.node("listener")
    arrays = []
    listener.create_subscription(
        Detection2DArray, "/drone1/detections", arrays.append, qos.detections()
    )
    was = until(lambda: children(program))
    os.kill(was["detector"], signal.SIGSEGV)
    program.wait_for("the detector ended by SIGSEGV")
    until(lambda: len(re.findall(r"model .* -> /drone1/detections", program.text)) == 2)
    ros.spin_until(lambda: listener.count_publishers("/drone1/detections") == 1)
    assert children(program)["estimator"] == was["estimator"]
    assert program.end(signal.SIGTERM) == 0, program.text


def test_what_restarts_keep_is_gone_with_the_session(start, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    program = start(CLI, "run")
    program.wait_for("method filter")
    assert list(tmp_path.glob("aerial_gnss_*"))
    assert program.end() == 0
    assert not list(tmp_path.glob("aerial_gnss_*"))


def test_one_process_is_still_there_for_who_wants_it(start):
    program = start(CLI, "run", "--one-process")
    program.wait_for("(?s)model .*method filter|method filter.*model ")
    assert children(program) == {}
    assert program.end() == 0, program.text


def test_each_node_has_an_enclave_of_its_own(start, ros):
    program = start(CLI, "run", "--enclave", "/boat")
    program.wait_for("method filter")
    node = ros.node()

    def enclaves():  # nodes of a test before may still be known
        return {enclave for _, _, enclave in node.get_node_names_and_namespaces_with_enclaves()}

    ros.spin_until(lambda: {"/boat/detector", "/boat/estimator"} <= enclaves())
    assert {"/boat/detector", "/boat/estimator"} <= enclaves()
    assert program.end() == 0, program.text


def test_security_that_this_ros_lacks_is_reported_in_one_sentence(start, tmp_path, monkeypatch):
    for name in ("detector", "estimator"):
        (tmp_path / "enclaves" / "boat" / name).mkdir(parents=True)
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(tmp_path))
    program = start(CLI, "run", "--enclave", "/boat")
    assert program.process.wait(timeout=90.0) == 2
    program.end()
    said = [line for line in program.lines if line.startswith("aerial-gnss: ")]
    assert len(said) == 1
    assert said[0].startswith("aerial-gnss: ROS cannot start: error creating node: ")
    assert "Traceback" not in program.text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--ros-args", "-p", "max_wiat:=1.0"], "max_wiat is not a parameter"),
        (["--ros-args", "-p", "model:=/absent.onnx"], "/absent.onnx"),
        (["--params", "/absent.yaml"], "/absent.yaml: cannot be read: No such file"),
        (["--namespace", "1 2"], "'1 2' is not a valid namespace"),
        (["--vehicle", "submarine"], "submarine is not a vehicle profile; choose from"),
    ],
)
def test_wrong_input_ends_both_nodes_with_one_sentence_and_status_2(start, arguments, sentence):
    program = start(CLI, "run", *arguments)
    assert program.process.wait(timeout=90.0) == 2
    program.end()
    said = [line for line in program.lines if line.startswith("aerial-gnss: ")]
    assert len(said) == 1, program.text
    assert sentence in said[0]
    assert "Traceback" not in program.text
