# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names as text: what was written is read, and what is damaged is refused."""

from __future__ import annotations

import json
import math

import pytest

from aerial_gnss_ros.core.identity.saved_labels import SavedNames, SavedRobot, from_text, to_text
from aerial_gnss_ros.core.values.errors import ConfigError

SAVED = SavedNames(
    (SavedRobot("aqua_1", "Aqua", math.radians(13.19), math.radians(-59.64), 17 * 10**17, 1.25),),
    {"aqua": 1},
)


@pytest.mark.parametrize(
    "text",
    [
        "",
        to_text(SAVED)[:-40],
        "[]",
        "{}",
        '{"version": 1, "numbers": {}, "robots": {"a": {}}}',
        to_text(SAVED).replace("1.25", "NaN"),
        to_text(SAVED).replace("13.19", '"north"'),
        to_text(SAVED).replace("13.19", "93.19"),
        to_text(SAVED).replace("59.64", "1e999"),
        to_text(SAVED).replace("1700000000000000000", "1e999"),
        to_text(SAVED).replace("1700000000000000000", "9223372036854775808"),
        to_text(SAVED).replace("aqua_1", "../aqua"),
        to_text(SAVED).replace('"sigma_m"', '"class": "aqua", "sigma_m"'),
        "[" * 100_000,
    ],
)
def test_a_damaged_file_is_named(text):
    with pytest.raises(ConfigError, match=r"state_file names\.json is damaged .*delete it"):
        from_text(text, "names.json")


def test_a_file_of_another_version_is_refused():
    with pytest.raises(ConfigError, match="version 7"):
        from_text(to_text(SAVED).replace('"version": 1', '"version": 7'), "names.json")


def test_the_text_is_in_degrees_and_metres_and_in_order():
    other = SavedRobot("aqua_10", "Aqua", math.pi / 2, -math.pi, -5, 0.00004)
    names = SavedNames((other, *SAVED.robots), {"aqua": 10})
    document = json.loads(to_text(names))
    assert list(document["robots"]) == ["aqua_1", "aqua_10"]
    assert document["robots"]["aqua_1"] == {
        "class": "Aqua", "latitude_deg": 13.19, "longitude_deg": -59.64,
        "last_seen_ns": 17 * 10**17, "sigma_m": 1.25,
    }  # fmt: skip
    assert document["robots"]["aqua_10"]["longitude_deg"] == -180.0
    kept = SavedNames(SAVED.robots, {"aqua": 1})
    back = from_text(to_text(kept), "names.json")
    assert back.numbers == {"aqua": 1}
    assert back.robots[0].latitude == pytest.approx(SAVED.robots[0].latitude, abs=1e-12)
    assert back.robots[0].longitude == pytest.approx(SAVED.robots[0].longitude, abs=1e-12)


@pytest.mark.parametrize(
    ("key", "value", "good"),
    [
        ("latitude_deg", 90.0, True), ("latitude_deg", -90.0, True), ("latitude_deg", -90.1, False),
        ("longitude_deg", 180.0, True), ("longitude_deg", -180.1, False),
        ("sigma_m", 1e-9, True), ("sigma_m", 0.0, False), ("sigma_m", -1.0, False),
        ("last_seen_ns", -(2**63) + 1, True), ("last_seen_ns", -(2**63), False),
    ],
)  # fmt: skip
def test_what_just_can_be_is_read(key, value, good):
    document = json.loads(to_text(SAVED))
    document["robots"]["aqua_1"][key] = value
    text = json.dumps(document)
    if good:
        assert from_text(text, "x").robots[0].name == "aqua_1"
    else:
        with pytest.raises(ConfigError, match="x is damaged"):
            from_text(text, "x")
