# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The policies for ROS' security name all that the nodes open, and the files are up to date."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from fnmatch import fnmatchcase

import pytest

from aerial_gnss_ros.adapters.vehicles import vehicle_names
from aerial_gnss_ros.nodes import security_policy
from aerial_gnss_ros.nodes.security_policy import fleet_policy, policy, texts


@pytest.mark.parametrize("name", sorted(texts()))
def test_generated_files_are_up_to_date(repository, name):
    command = "python3 -m aerial_gnss_ros.nodes.security_policy --all config/security"
    shipped = (repository / "config" / "security" / name).read_text(encoding="utf-8")
    assert shipped == texts()[name], f"run {command}"


def test_only_a_profile_that_needs_a_place_first_has_none(repository):
    missing = {f"{name}.policy.xml" for name in vehicle_names()} - set(texts())
    assert missing == {"fixed_camera.policy.xml"}
    shipped = {path.name for path in (repository / "config" / "security").iterdir()}
    assert shipped == set(texts())
    assert "fleet.policy.xml" in shipped


def allowed(text, node):
    """Return the full names that a policy allows a node, by verb, as SROS2 reads them."""
    root = ET.fromstring(text)  # noqa: S314 - our own
    assert (root.tag, root.attrib) == ("policy", {"version": "0.2.0"})
    found = {"publish": [], "subscribe": [], "reply": [], "request": []}
    for profile in root.findall("enclaves/enclave/profiles/profile"):
        if profile.get("node") != node:
            continue
        ns = profile.get("ns").rstrip("/")
        for rule in profile:
            ((verb, qualifier),) = rule.attrib.items()
            assert qualifier == "ALLOW"
            for name in (entry.text for entry in rule):
                full = name.replace("~", f"{ns}/{node}") if name.startswith("~") else name
                found[verb].append(full if full.startswith("/") else f"{ns}/{full}")
    return found


def left_out(names, patterns):
    return [name for name in names if not any(fnmatchcase(name, one) for one in patterns)]


def test_all_that_the_live_nodes_open_is_allowed(ros, hovering, tmp_path):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from aerial_gnss_ros.nodes.detector_node import DetectorNode
    from aerial_gnss_ros.nodes.estimator_node import EstimatorNode
    from aerial_gnss_ros.nodes.supervised import Given

    path = tmp_path / "p.yaml"
    path.write_text("use_sim_time: false\ndepth: {topics: [depth]}\n")
    given = Given([path], "drone1")
    nodes = {"estimator": ros.add(EstimatorNode(given)), "detector": ros.add(DetectorNode(given))}
    hovering("drone1").fly()
    ros.spin_until(lambda: "aqua_1" in str(nodes["estimator"].get_topic_names_and_types()))
    text = policy([path], "drone1")
    for name, node in nodes.items():
        rules = allowed(text, name)
        opened = {
            "publish": node.get_publisher_names_and_types_by_node,
            "subscribe": node.get_subscriber_names_and_types_by_node,
            "reply": node.get_service_names_and_types_by_node,
            "request": node.get_client_names_and_types_by_node,
        }
        for verb, names_of in opened.items():
            names = [one for one, _ in names_of(name, "/drone1")]
            assert left_out(names, rules[verb]) == [], (name, verb)
            assert bool(names) == (verb != "request")
    assert left_out(["/drone1/fix", "/drone2/detections"], allowed(text, "detector")["publish"])


def test_all_that_the_live_fleet_opens_is_allowed_and_nothing_of_another_drone(ros, tmp_path):
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from aerial_gnss_ros.nodes.fleet_node import FleetNode
    from aerial_gnss_ros.nodes.supervised import Given

    path = tmp_path / "p.yaml"
    path.write_text("/**/fleet: {ros__parameters: {drones: [/drone1, drone2]}}")
    node = ros.add(FleetNode(Given([path], "shore")))
    rules = allowed(fleet_policy([path], "shore"), "fleet")
    opened = {
        "publish": node.get_publisher_names_and_types_by_node,
        "subscribe": node.get_subscriber_names_and_types_by_node,
        "reply": node.get_service_names_and_types_by_node,
    }
    for verb, names_of in opened.items():
        names = [one for one, _ in names_of("fleet", "/shore")]
        assert names
        assert left_out(names, rules[verb]) == [], verb
    assert left_out(["/shore/robots/aqua_1/fix", "/shore/drones"], rules["publish"]) == []
    assert "/drone1/sightings" in rules["subscribe"]
    assert left_out(["/drone3/sightings"], rules["subscribe"])
    shipped = allowed(texts()["fleet.policy.xml"], "fleet")
    assert (
        left_out(["/drone3/sightings", "/drone3/sightings/parameters"], shipped["subscribe"]) == []
    )
    assert left_out(["/drone3/sightings/request"], shipped["publish"]) == []
    assert left_out(["/drone3/fix"], shipped["publish"])


def test_a_topic_whose_message_has_versions_is_allowed_in_each(repository):
    text = (repository / "config" / "security" / "px4_uxrce.policy.xml").read_text()
    heard = allowed(text, "estimator")["subscribe"]
    versions = [name.removesuffix("_v*") for name in heard if name.endswith("_v*")]
    assert versions
    assert set(versions) <= set(heard)


def test_the_program_writes_the_policy_of_given_parameters(capsys, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("fix: {topic: /autopilot/fix}\n")
    arguments = ["--params", str(path), "--namespace", "drone1", "--enclave", "/boat"]
    assert security_policy.main(arguments) == 0
    out = capsys.readouterr().out
    assert "<topic>/autopilot/fix</topic>" in out
    assert '<enclave path="/boat/estimator">' in out
    assert 'ns="/drone1"' in out
    path.write_text("fleet: {ros__parameters: {drones: [/drone1]}}")
    assert security_policy.main(["--fleet", *arguments[:2]]) == 0
    out = capsys.readouterr().out
    assert "<topic>/drone1/sightings</topic>" in out
    assert '<enclave path="/aerial_gnss/fleet">' in out
    assert security_policy.main(["--vehicle", "submarine"]) == 2
    assert "security_policy: submarine is not a vehicle profile" in capsys.readouterr().err
