# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Configurations for RViz and Foxglove: they show topics that exist, also in a namespace."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
from typing import Any

import pytest
import yaml

from aerial_gnss_ros.adapters.map_frame import frames
from aerial_gnss_ros.adapters.viewers import rviz_in_namespace
from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.resources import rviz_path

KINDS = {
    "rviz_default_plugins/MarkerArray": "MarkerArray",
    "rviz_default_plugins/Odometry": "Odometry",
    "rviz_default_plugins/Image": "CompressedImage",
}
LATCHED = re.compile(r"/robots/.*")


@pytest.fixture(scope="module")
def listed(repository) -> dict[str, str]:
    """Return the documented topics with their rows."""
    script = repository / "tools" / "reference_pages.py"
    spec = importlib.util.spec_from_file_location("reference_pages", script)
    reference_pages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reference_pages)
    page = reference_pages.topics().splitlines()
    rows = [line for line in page if line.startswith(("| in ", "| out "))]
    found = {}
    for row in rows:
        name = re.search(r"`([a-z/_<>]+)`", row)
        if name:
            found["/" + name[1].lstrip("/")] = row
    assert len(found) > 15
    return found | {"/diagnostics": "DiagnosticArray"}


def _documented(topic: str) -> str:
    return re.sub(r"/robots/[a-z]+_\d+/", "/robots/<id>/", topic)


def _displays(text: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = yaml.safe_load(text)["Visualization Manager"]["Displays"]
    return found


def test_each_display_of_rviz_has_a_documented_topic_of_its_type_and_durability(listed):
    text = rviz_path("aerial_gnss.rviz").read_text(encoding="utf-8")
    shown = [one for one in _displays(text) if "Topic" in one]
    assert {one["Class"] for one in shown} == set(KINDS)
    for one in shown:
        topic = one["Topic"]
        assert KINDS[one["Class"]] in listed[_documented(topic["Value"])], topic
        latched = LATCHED.fullmatch(topic["Value"]) is not None
        assert (topic["Durability Policy"] == "Transient Local") is latched, topic
        assert topic["Reliability Policy"] == "Reliable"
    assert {"rviz_default_plugins/TF", "rviz_default_plugins/Grid"} < {
        one["Class"] for one in _displays(text)
    }


@pytest.mark.parametrize("namespace", ["", "/", "drone1", "/fleet/drone1"])
def test_in_a_namespace_it_shows_that_drone(namespace):
    text = rviz_path("aerial_gnss.rviz").read_text(encoding="utf-8")
    moved = rviz_in_namespace(text, namespace)
    prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    topics = [
        [one["Topic"]["Value"] for one in _displays(each) if "Topic" in one]
        for each in (text, moved)
    ]
    assert topics[1] == [f"{prefix}{topic}" for topic in topics[0]]
    fixed = yaml.safe_load(moved)["Visualization Manager"]["Global Options"]["Fixed Frame"]
    assert fixed == frames(MapConfig(), f"/{namespace.strip('/')}").map


def _strings(value: Any) -> list[str]:
    if isinstance(value, dict):
        return [*value, *(one for item in value.values() for one in _strings(item))]
    if isinstance(value, list):
        return [one for item in value for one in _strings(item)]
    return [value] if isinstance(value, str) else []


def test_foxglove_s_layout_is_json_with_documented_topics(listed):
    layout = json.loads(rviz_path("foxglove.json").read_text(encoding="utf-8"))
    topics = {one for one in _strings(layout) if one.startswith("/")}
    assert {"/robots/markers", "/annotated/compressed", "/robots/aqua_1/fix"} <= topics
    for topic in topics:
        assert _documented(topic) in listed, topic
    panels = set(layout["configById"])
    assert {one for one in _strings(layout["layout"]) if "!" in one} == panels
    assert layout["configById"]["3D!robots"]["followTf"] == frames(MapConfig()).map


def test_the_printed_command_puts_foxglove_s_layout_into_a_namespace(repository, tmp_path):
    page = (repository / "docs/howto/outputs.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    (sed .*)$", page, re.MULTILINE)
    text = rviz_path("foxglove.json").read_text(encoding="utf-8")
    (tmp_path / "foxglove.json").write_text(text, encoding="utf-8")
    subprocess.run(["bash", "-c", command], cwd=tmp_path, check=True)
    before, after = json.loads(text), json.loads((tmp_path / "drone1.json").read_text())
    moved = {one for one in _strings(after) if one.startswith("/")}
    assert moved == {
        one if one == "/diagnostics" else f"/drone1{one}"
        for one in _strings(before)
        if one.startswith("/")
    }
    assert after["configById"]["3D!robots"]["followTf"] == "drone1/map"
    assert after["configById"]["map!earth"]["layer"] == "map"
