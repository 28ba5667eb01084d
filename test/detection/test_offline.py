# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ultralytics asks no network, and its settings are not the user's."""

from __future__ import annotations

import os
from pathlib import Path

from aerial_gnss_ros.detection.offline import OFFLINE, QUIET, SETTINGS, forbid_network


def test_what_the_user_has_set_stays(monkeypatch, tmp_path):
    for name in (*OFFLINE, *QUIET):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(SETTINGS, str(tmp_path))
    monkeypatch.setenv("YOLO_VERBOSE", "true")
    forbid_network()
    assert {name: os.environ[name] for name in OFFLINE} == OFFLINE
    assert (os.environ["YOLO_VERBOSE"], os.environ[SETTINGS]) == ("true", str(tmp_path))


def test_else_settings_are_in_a_folder_that_goes_with_the_process(monkeypatch):
    removed = []
    monkeypatch.setattr("atexit.register", lambda _, folder, **__: removed.append(folder))
    for name in (*OFFLINE, *QUIET, SETTINGS):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    forbid_network()
    folder = os.environ[SETTINGS]
    assert removed == [folder]
    forbid_network()
    assert os.environ[SETTINGS] == folder
    Path(folder).rmdir()
