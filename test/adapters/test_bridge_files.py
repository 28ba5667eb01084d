# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The bridge's files let through what drones and fleet say to each other, and nothing else.

The bridge itself is not among the packages that pip has: that it accepts them is not tried here.
"""

from __future__ import annotations

import json
import re

import pytest

from aerial_gnss_ros.adapters.fleet_messages import PARAMETERS, REQUEST
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS

TOLD = {f"/drone1/{SIGHTINGS[0]}", f"/drone1/{PARAMETERS[0]}"}
ASKED = {f"/drone1/{REQUEST[0]}"}
OTHER = {"/drone1/fix", "/drone1/detections", "/rosout", "/clock", "/fleet/drones"}


@pytest.mark.parametrize(("name", "out"), [("drone", TOLD), ("shore", ASKED)])
def test_only_sightings_and_what_belongs_to_them_passes(repository, name, out):
    lines = (repository / "config" / "zenoh" / f"{name}.json5").read_text().splitlines()
    text = "\n".join(line for line in lines if not line.strip().startswith("//"))
    bridge = json.loads(text)["plugins"]["ros2dds"]
    for kind, topics in (("publishers", out), ("subscribers", (TOLD | ASKED) - out)):
        passing = {
            topic
            for topic in TOLD | ASKED | OTHER
            if any(re.fullmatch(one, topic) for one in bridge["allow"][kind])
        }
        assert passing == topics
    assert bridge["allow"].keys() == {"publishers", "subscribers"}  # no services
    assert bridge["reliable_routes_blocking"] is False
