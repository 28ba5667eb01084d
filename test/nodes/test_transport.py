# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transports of Fast DDS, unless the user has chosen some."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerial_gnss_ros.nodes.transport import (
    PROFILE,
    PROMPT,
    VARIABLE,
    use_large_data_profile,
    use_prompt_profile,
)


@pytest.mark.parametrize(
    ("use", "name"), [(use_large_data_profile, PROFILE), (use_prompt_profile, PROMPT)]
)
def test_a_profile_is_chosen_where_the_user_has_chosen_none(monkeypatch, tmp_path, use, name):
    monkeypatch.chdir(tmp_path)
    environment = {"FASTDDS_BUILTIN_TRANSPORTS": ""}
    assert use(environment)
    assert Path(environment[VARIABLE]).name == name
    assert Path(environment[VARIABLE]).is_file()


@pytest.mark.parametrize(
    "name", [VARIABLE, "FASTDDS_DEFAULT_PROFILES_FILE", "FASTDDS_BUILTIN_TRANSPORTS"]
)
def test_what_the_user_has_chosen_stays(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    environment = {name: "mine"}
    assert not use_large_data_profile(environment)
    assert environment == {name: "mine"}


@pytest.mark.parametrize("name", ["DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml"])
def test_a_file_of_the_users_in_this_folder_takes_precedence(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("<xml/>")
    environment = {}
    assert not use_prompt_profile(environment)
    assert environment == {}
