# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests that run side by side do not hear one another's nodes, and files stay together."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from pathlib import Path

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
        self.path, self.nodeid = CONFTEST.parent / path, f"test/{path}::test_one"


def ordered(monkeypatch, worker, names):
    items = [Item(name) for name in names]
    loaded(monkeypatch, worker)["pytest_collection_modifyitems"](items)
    return [item.path.name for item in items]


def test_what_takes_longest_begins(monkeypatch):
    names = ["core/test_a.py", "test_install.py", "nodes/test_live.py", "interfaces/test_c.py"]
    assert ordered(monkeypatch, "gw0", names) == [
        "test_live.py", "test_c.py", "test_install.py", "test_a.py",
    ]  # fmt: skip
    assert ordered(monkeypatch, "", names) == [Path(name).name for name in names]


def test_tests_of_nodes_wait_beside_what_computes(monkeypatch):
    nodes = [f"nodes/test_{name}.py" for name in "abc"]
    found = ordered(monkeypatch, "gw0", [*nodes, "core/test_d.py", "commands/test_e.py"])
    assert found == ["test_e.py", "test_a.py", "test_b.py", "test_d.py", "test_c.py"]
    assert ordered(monkeypatch, "gw0", nodes) == ["test_a.py", "test_b.py", "test_c.py"]


ONE = """
import os
from pathlib import Path

import pytest

@pytest.mark.parametrize("number", range(6))
def test_one(number):
    said = Path(os.environ["SAID"]) / f"{Path(__file__).stem}_{number}"
    said.write_text(os.environ.get("PYTEST_XDIST_WORKER", ""))
"""
FILES = ("core/test_a.py", "core/test_b.py", "nodes/test_live.py", "nodes/test_player.py")


@pytest.fixture
def run_in_copy(tmp_path):
    """Return a function that runs `FILES` beside a copy of conftest.py, and where they report."""
    said = tmp_path / "said"
    said.mkdir()
    for name in FILES:
        file = tmp_path / "test" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(ONE)
    (tmp_path / "test" / "conftest.py").write_text(CONFTEST.read_text())
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n")

    def run(*arguments):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", *arguments, "test"],
            cwd=tmp_path, env=os.environ | {"SAID": str(said)}, capture_output=True, text=True,
            timeout=120, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        assert len(list(said.iterdir())) == 6 * len(FILES)
        return said

    return run


def test_tests_of_a_group_run_in_one_process(run_in_copy):
    """With pytest-xdist itself, which has ignored marks without a word."""
    pytest.importorskip("xdist")
    said = run_in_copy("-n", "3", "--dist", "loadscope")
    processes = {
        name: {one.read_text() for one in said.glob(f"{Path(name).stem}_*")} for name in FILES
    }
    assert all(len(some) == 1 for some in processes.values())
    assert processes["nodes/test_live.py"] == processes["nodes/test_player.py"]


def test_tests_run_without_pytest_xdist(run_in_copy):
    run_in_copy("-p", "no:xdist")
