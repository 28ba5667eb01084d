# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The bag player and the transport profile that lets its images arrive."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

import pytest

from aerial_gnss_ros.nodes.transport import (
    PROFILE,
    PROMPT,
    VARIABLE,
    use_large_data_profile,
    use_prompt_profile,
)
from aerial_gnss_ros.resources import config_path


def test_the_profile_holds_several_images():
    root = ET.parse(config_path("fastdds_large_data.xml")).getroot()  # noqa: S314 (our own)
    (size,) = root.findall(".//{*}segment_size")
    assert int(size.text) >= 5 * 1920 * 1080 * 3
    assert [one.text for one in root.findall(".//{*}useBuiltinTransports")] == ["false"]


@pytest.mark.parametrize("name", [PROFILE, PROMPT])
def test_profiles_announce_often(name):
    root = ET.parse(config_path(name)).getroot()  # noqa: S314 (our own)
    path = (
        "./{*}profiles/{*}participant/{*}rtps/{*}builtin/{*}discovery_config/{*}leaseAnnouncement"
    )
    (period,) = root.findall(path)  # where Fast DDS looks for it; elsewhere it is ignored
    seconds, nanoseconds = (int(part.text) for part in period)
    assert [part.tag.rpartition("}")[2] for part in period] == ["sec", "nanosec"]
    assert 0.1 <= seconds + nanoseconds * 1e-9 <= 1.0


def test_a_users_own_transports_are_left_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    environment = {}
    assert use_large_data_profile(environment)
    assert environment == {VARIABLE: str(config_path("fastdds_large_data.xml"))}
    environment = {}
    assert use_prompt_profile(environment)
    assert environment == {VARIABLE: str(config_path("fastdds_prompt.xml"))}
    for own in (VARIABLE, "FASTDDS_BUILTIN_TRANSPORTS", "FASTDDS_DEFAULT_PROFILES_FILE"):
        environment = {own: "mine"}
        assert not use_large_data_profile(environment)
        assert not use_prompt_profile(environment)
        assert environment == {own: "mine"}
    (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").write_text("<dds/>")
    assert not use_large_data_profile({})


@pytest.mark.slow
def test_images_larger_than_the_default_segment_arrive_with_the_bags_time(ros, in_step, flight):
    from aerial_gnss_ros.adapters.stamps import nanoseconds
    from aerial_gnss_ros.nodes import qos
    from aerial_gnss_ros.nodes.ros_messages import message_class

    node, images, clock = ros.node(), [], []
    image, time = message_class("sensor_msgs/msg/Image"), message_class("rosgraph_msgs/msg/Clock")
    node.create_subscription(image, "/camera/image_raw", images.append, qos.sensor(5))
    node.create_subscription(time, "/clock", clock.append, qos.sensor(50))
    bag = flight("images")
    topic = "/camera/image_raw"
    player = in_step(topic, bag, "--rate", "3", "--wait-for", topic)
    player.play(ros, lambda: len(images))
    assert len(images) == 26  # 691 kB each: more than the default segment holds
    stamps = [nanoseconds(one.clock) for one in clock]
    assert stamps == sorted(stamps)
    assert nanoseconds(images[-1].header.stamp) <= stamps[-1]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["/absent"], "player: /absent does not exist"),
        (
            ["BAG", "--topics", "/nothing"],
            "nothing to play: .* has /camera/camera_info, /detections",
        ),
        (["BAG", "--rate", "0"], "player: --rate 0.0 is not a speed"),
    ],
)
def test_what_cannot_be_played_ends_with_status_2(flight, capfd, monkeypatch, arguments, sentence):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from aerial_gnss_ros.nodes import player

    monkeypatch.setenv(VARIABLE, "")  # the player sets it: restored afterwards
    bag = str(flight("boxes"))
    given = [bag if argument == "BAG" else argument for argument in arguments]
    assert player.main(["player", *given]) == 2
    assert re.search(sentence, capfd.readouterr().err)
