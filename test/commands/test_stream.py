# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: which robot goes to which output, and what is said of it."""

from __future__ import annotations

import ast

import pytest

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.commands.stream import Stream, _announce
from aerial_gnss_ros.commands.udp_outputs import CursorOnTarget


class Kept:
    """An output that keeps the names of what it is given."""

    def __init__(self):
        self.robots = []

    def send(self, seen):
        self.robots.append(seen.robot_id)

    def close(self):
        pass


def sent(cot, mavlink, only, robots=("a", "b", "a", "b")):
    stream = Stream(cot, mavlink, only)
    for robot in robots:
        stream.send(Sighting(robot, 1, 0.1, 0.2, 0.0, 1.0, measured=True))
    return dict(stream.sent)


@pytest.mark.parametrize(
    ("only", "cot", "mavlink"),
    [(None, ["a", "b", "a", "b"], ["a", "a"]), ("b", ["b", "b"], ["b", "b"])],
)
def test_cot_takes_all_robots_and_mavlink_one(only, cot, mavlink):
    one, other = Kept(), Kept()
    sent(one, other, only)
    assert (one.robots, other.robots) == (cot, mavlink)


def test_what_goes_nowhere_is_not_counted_as_sent_and_said_once(capsys):
    assert sent(None, Kept(), None) == {"a": 2, "b": 0}
    said = capsys.readouterr().err
    assert "sending b" not in said
    assert said.count("b is not sent there; choose it with --robot b") == 1


@pytest.mark.parametrize(
    ("host", "leaves", "said"),
    [("127.0.0.1", False, ""), ("localhost", False, ""), ("192.0.2.7", True, "go to 192.0.2.7")],
)
def test_a_socket_for_this_computer_takes_nothing_from_the_network(host, leaves, said, capsys):
    output = CursorOnTarget(host, 4242, "a-f-S", 30.0)
    try:
        bound = output._udp._socket.getsockname()[0]
        assert output.leaves is leaves
        assert bound == ("0.0.0.0" if leaves else "127.0.0.1")  # noqa: S104 - stated, and asked for
        _announce(output, host, "CoT")
        assert said in capsys.readouterr().err
    finally:
        output.close()


def test_nothing_is_said_of_positions_that_stay_here(capsys):
    output = CursorOnTarget("127.0.0.1", 4242, "a-f-S", 30.0)
    _announce(output, "127.0.0.1", "CoT")
    output.close()
    assert capsys.readouterr().err == ""


def test_no_other_place_of_the_package_opens_a_socket(repository):
    """What listens, or sends by itself, belongs into docs/howto/security.md."""
    watched = {"socket", "socketserver", "http.server", "asyncio", "multiprocessing.managers"}
    found = set()
    for path in (repository / "aerial_gnss_ros").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = set()
            if isinstance(node, ast.Import):
                names = {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names = {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
            if names & watched:
                found.add(path.name)
    assert found == {"udp_outputs.py"}
