# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss play`: a recording in live nodes, at its own time, paused and under a namespace."""

from __future__ import annotations

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from sensor_msgs.msg import NavSatFix  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from aerial_gnss_ros import cli  # noqa: E402
from aerial_gnss_ros.nodes import qos  # noqa: E402
from aerial_gnss_ros.nodes.estimator_node import EstimatorNode  # noqa: E402
from aerial_gnss_ros.nodes.supervised import Given  # noqa: E402


def test_a_recording_waits_for_the_node_pauses_and_reaches_its_namespace(
    ros, start, flight, tmp_path
):
    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: true\n")
    arguments = ["--rate", "2", "--namespace", "drone1", "--wait-for", "estimator", "--pause"]
    player = start("aerial_gnss_ros.cli", "play", flight("boxes"), *arguments)
    ros.spin(1.0)
    node = ros.add(EstimatorNode(Given([path], "drone1")))
    resume = ros.node("pilot").create_client(Trigger, "/drone1/player/resume")
    ros.spin_until(resume.service_is_ready)
    ros.spin(0.5)
    assert node._images == 0
    clock_ns = node.now_ns()
    answer = resume.call_async(Trigger.Request())
    ros.spin_until(answer.done)
    ros.spin_until(lambda: player.process.poll() is not None)
    assert player.end() == 0, player.text
    assert "playing" in player.text
    ros.spin_until(lambda: node._images > 10)  # of 26: the machine may be busy
    assert node.now_ns() > clock_ns
    assert {one.robot_id for one in node._departures.present} == {"aqua_1", "aqua_2"}


def test_a_recording_without_its_clock_is_said_to_be_one(ros, start, flight):
    node = ros.add(EstimatorNode())
    said = []
    node.warn_seldom = said.append
    start("aerial_gnss_ros.cli", "play", flight("boxes"), "--wait-for", "estimator")
    ros.spin_until(lambda: any("use_sim_time" in sentence for sentence in said))
    sentence = next(one for one in said if "use_sim_time" in one)
    assert sentence.startswith("images are stamped 2023-11-14 22:13 UTC, but this node's clock ")
    ros.spin_until(lambda: len(said) > 5)
    assert set(said) == {sentence}, "the log has it once"


def test_whom_a_recording_has_waited_for_in_vain_is_said_with_the_namespace(start, flight):
    given = ["--namespace", "d1", "--wait-for", "d1/estimator", "--wait", "0.2", "--rate", "9"]
    program = start("aerial_gnss_ros.cli", "play", flight("boxes"), *given)
    program.wait_for("d1/estimator in the namespace /d1 has not subscribed after 0.2 s")


def test_recordings_of_several_drones_are_played_below_their_names(ros, start, flight):
    listener, came = ros.node("listener"), {"a": [], "b": []}
    for name, stamps in came.items():
        listener.create_subscription(
            NavSatFix, f"/{name}/fix", lambda m, to=stamps: to.append(m.header.stamp),
            qos.sensor(50),
        )  # fmt: skip
    bag = flight("boxes")
    given = [part for name in came for part in ("--drone", f"{name}={bag}")]
    program = start("aerial_gnss_ros.cli", "play", *given, "--rate", "4", "--wait-for", "listener")
    ros.spin_until(lambda: len(came["a"]) > 20 and len(came["b"]) > 20)
    assert came["a"][-1].sec == pytest.approx(came["b"][-1].sec, abs=1)
    program.wait_for("played")


@pytest.mark.parametrize("arguments", [[], ["x", "--drone", "a=x"]])
def test_a_recording_or_several_drones_are_played_not_both(capsys, arguments):
    assert cli.main(["play", *arguments]) == 2
    assert "give BAG, or --drone NAME=BAG" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--rate", "nan"], "--rate must be above 0, not nan."),
        (["--start", "60"], "--start 60 s is after the end: the recording lasts 5.0 s."),
        (["--topics", "/nothing"], "nothing to play: "),
        (["--namespace", "a b"], "'a b' is not a valid namespace: "),
    ],
)
def test_what_cannot_be_played_is_one_sentence(capsys, flight, monkeypatch, arguments, sentence):
    monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", "")
    assert cli.main(["play", str(flight("boxes")), *arguments]) == 2
    assert sentence in capsys.readouterr().err
