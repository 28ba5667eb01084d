# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: which robot goes to which output, and what is said of it."""

from __future__ import annotations

import ast
import socket

import pytest

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.commands import udp_outputs
from aerial_gnss_ros.commands.stream import Stream, _announce
from aerial_gnss_ros.commands.udp_outputs import CursorOnTarget, Udp


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
def test_destinations_outside_this_computer_are_said(host, leaves, said, capsys):
    output = CursorOnTarget(host, 4242, "a-f-S", 30.0)
    assert output.leaves is leaves
    _announce(output, host, "CoT")
    assert said in capsys.readouterr().err


@pytest.fixture
def receiver():
    """Return a UDP socket that waits on this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(90.0)
        yield made


def test_a_socket_takes_nothing_but_from_its_receiver(receiver):
    output = Udp(*receiver.getsockname())
    output.write(b"position")
    data, sender = receiver.recvfrom(100)
    assert data == b"position"
    assert sender[0] == "127.0.0.1"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"from elsewhere", sender)
    receiver.sendto(b"answer", sender)
    assert output._socket.recv(100) == b"answer"
    output.close()


def test_a_receiver_that_is_off_is_said_once_and_gets_every_position_when_it_is_on(
    receiver, capsys, monkeypatch
):
    now = [0.0]
    monkeypatch.setattr(udp_outputs.time, "monotonic", lambda: now[0])
    host, port = receiver.getsockname()
    receiver.close()
    output = Udp(host, port)
    for number in range(6):
        output.write(b"%d" % number)
    assert capsys.readouterr().err == (
        f"{host}:{port}: nobody listens there (connection refused); positions are still sent "
        "there\n"
    )
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as on:
        on.bind((host, port))
        on.settimeout(90.0)
        for number in range(6):
            output.write(b"%d" % number)
            assert on.recv(100) == b"%d" % number
        assert capsys.readouterr().err == ""
        now[0] = 5.0
        output.write(b"6")
        assert capsys.readouterr().err == f"{host}:{port}: reached again\n"
    assert output.lost == 0
    output.close()


@pytest.mark.parametrize("failing", ["connect", "send"])
def test_a_network_that_is_down_is_said_once_and_tried_again(
    failing, receiver, capsys, monkeypatch
):
    down = [True]

    class Socket(socket.socket):
        def connect(self, address):
            if down[0] and failing == "connect":
                raise OSError(101, "Network is unreachable")
            super().connect(address)

        def send(self, data):
            if down[0] and failing == "send":
                raise OSError(101, "Network is unreachable")
            return super().send(data)

    monkeypatch.setattr(udp_outputs.socket, "socket", Socket)
    output = Udp(*receiver.getsockname())
    for _ in range(3):
        output.write(b"lost")
    assert capsys.readouterr().err.count("Network is unreachable; positions are still sent") == 1
    assert output.lost == 3
    down[0] = False
    output.write(b"position")
    assert receiver.recv(100) == b"position"
    output.close()


def test_nothing_is_said_of_positions_that_stay_here(capsys):
    output = CursorOnTarget("127.0.0.1", 4242, "a-f-S", 30.0)
    _announce(output, "127.0.0.1", "CoT")
    output.close()
    assert capsys.readouterr().err == ""


def test_no_other_place_of_the_package_opens_a_socket(repository):
    """What listens, or sends by itself, belongs into docs/howto/security.md."""
    watched = {"socket", "socketserver", "http.server", "asyncio", "multiprocessing.managers"}
    watched |= {"tornado", "tornado.httpserver", "tornado.netutil", "tornado.tcpserver"}
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
    assert found == {"udp_outputs.py", "server.py"}
