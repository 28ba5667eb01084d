# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests that run side by side do not hear one another's nodes, and files stay together."""

from __future__ import annotations

import os
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest

CONFTEST = Path(__file__).with_name("conftest.py")


def loaded(monkeypatch, worker, domain="90"):
    monkeypatch.setenv("PYTEST_XDIST_WORKER", worker)
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    return runpy.run_path(str(CONFTEST))


@pytest.mark.parametrize("domain", ["0", "38", "101"])
def test_every_process_has_a_domain_of_its_own(monkeypatch, domain):
    domains = set()
    for worker in ("", "gw0", "gw1", "gw2", "gw3"):
        loaded(monkeypatch, worker, domain)
        domains.add(int(os.environ["ROS_DOMAIN_ID"]))
    assert len(domains) == 4  # the first process runs no tests beside the others
    assert int(domain) in domains
    assert domains <= set(range(102))


class Item:
    def __init__(self, path):
        self.path, self.groups = CONFTEST.parent / path, []

    def add_marker(self, mark):
        self.groups += mark.args


def test_files_stay_together_and_nodes_begin(monkeypatch):
    sort = loaded(monkeypatch, "gw0")["pytest_collection_modifyitems"]
    names = ["core/test_a.py", "core/test_a.py", "test_install.py", "nodes/test_b.py",
             "nodes/test_live.py", "nodes/test_player.py", "interfaces/test_c.py"]  # fmt: skip
    items = [Item(name) for name in names]
    sort(SimpleNamespace(pluginmanager=SimpleNamespace(hasplugin=lambda _: True)), items)
    groups = [(item.path.name, item.groups) for item in items]
    assert groups == [
        ("test_b.py", []),
        ("test_live.py", ["in turn"]),
        ("test_player.py", ["in turn"]),
        ("test_c.py", ["test/interfaces/test_c.py"]),
        ("test_install.py", ["test/test_install.py"]),
        ("test_a.py", ["test/core/test_a.py"]),
        ("test_a.py", ["test/core/test_a.py"]),
    ]


def test_without_side_by_side_nothing_changes(monkeypatch):
    sort = loaded(monkeypatch, "")["pytest_collection_modifyitems"]
    items = [Item("core/test_a.py"), Item("nodes/test_b.py")]
    sort(SimpleNamespace(pluginmanager=SimpleNamespace(hasplugin=lambda _: True)), items)
    assert [item.groups for item in items] == [[], []]
    assert items[0].path.name == "test_a.py"
