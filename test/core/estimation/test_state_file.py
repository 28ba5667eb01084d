# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names outlive the program, and a damaged file says so."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.estimation import state_file
from aerial_gnss_ros.core.identity.saved_labels import SavedNames, SavedRobot
from aerial_gnss_ros.core.values.errors import ConfigError, OutputError

SAVED = SavedNames(
    (SavedRobot("aqua_1", "Aqua", math.radians(13.19), math.radians(-59.64), 17 * 10**17, 1.25),),
    {"aqua": 1},
)


def test_names_survive_the_file(tmp_path):
    path = tmp_path / "names.json"
    assert state_file.load(path) == SavedNames()
    state_file.save(path, SAVED)
    loaded = state_file.load(path)
    assert loaded.numbers == SAVED.numbers
    assert loaded.robots[0].last_seen_ns == SAVED.robots[0].last_seen_ns
    assert loaded.robots[0].latitude == pytest.approx(SAVED.robots[0].latitude, abs=1e-11)
    assert [item.name for item in tmp_path.iterdir()] == ["names.json"]


def test_a_folder_that_is_missing_is_reported_at_start(tmp_path):
    with pytest.raises(ConfigError, match="does not exist"):
        state_file.load(tmp_path / "nowhere" / "names.json")
    with pytest.raises(ConfigError, match="cannot be read"):
        state_file.load(tmp_path)
    (tmp_path / "huge.json").write_bytes(b" " * (state_file.MOST_BYTES + 1))
    with pytest.raises(ConfigError, match="larger than 10 MB"):
        state_file.load(tmp_path / "huge.json")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "names.json"
    state_file.save(path, SAVED)
    before = path.read_bytes()
    (tmp_path / ".names.json.partial").mkdir()  # the temporary file cannot be opened
    with pytest.raises(OutputError, match="cannot be written"):
        state_file.save(path, SavedNames())
    assert path.read_bytes() == before
