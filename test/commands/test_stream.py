# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: which robot goes to which output, and what is said of it."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.commands.stream import Stream


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
    assert said.count("b is not sent there; choose with --robot b") == 1
