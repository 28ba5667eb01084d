# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A bag's telemetry reaches what watches it, and topics that cannot are named."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.watching import message_count, watch_bag
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.values.errors import InputError

FLOAT, SECOND = "std_msgs/msg/Float64", 1_000_000_000


class Monitor:
    """Records its calls."""

    def __init__(self):
        self.arrived, self.advanced = [], []

    def arriving(self, name, log_ns):
        """Take in that a message comes."""
        self.arrived.append((name, log_ns // SECOND))

    def advance(self, final=False):
        """Take in that time goes on."""
        self.advanced.append(final)


@pytest.fixture
def recorded(tmp_path):
    """Return a bag with a message of each topic a second, four seconds long."""
    with BagWriter(tmp_path / "bag") as writer:
        for i in range(1, 5):
            for topic in ("d1/a", "d1/b"):
                writer.write(topic, FLOAT, i * SECOND, {"data": float(i)})
    with open_bag([tmp_path / "bag"]) as bag:
        yield bag


def inputs(got, *described):
    return [
        Subscription(
            name, topic, msgtype, 1, lambda m, ns, name=name: got.append((name, m.data, ns))
        )
        for name, topic, msgtype in described
    ]


def test_a_topic_serves_every_input_that_reads_it(recorded):
    got, monitor, done = [], Monitor(), []
    wanted = inputs(got, ("one", "a", FLOAT), ("other", "a", FLOAT))
    end_ns, problems = watch_bag(recorded, wanted, monitor, namespace="d1", on_message=done.append)
    assert (end_ns, problems) == (4 * SECOND, {})
    assert got[:2] == [("one", 1.0, SECOND), ("other", 1.0, SECOND)]
    assert len(got) == 8
    assert monitor.arrived[:2] == [("one", 1), ("other", 1)]
    assert monitor.advanced == [False] * 4 + [True]
    assert done == [1, 2, 3, 4]
    assert message_count(recorded, wanted, "d1") == 4


def test_it_ends_at_the_stated_time(recorded):
    got = []
    end_ns, _ = watch_bag(
        recorded, inputs(got, ("one", "a", FLOAT)), Monitor(), namespace="d1", until_s=2.0
    )
    assert end_ns == 3 * SECOND  # the bag begins at 1 s
    assert [value for _, value, _ in got] == [1.0, 2.0, 3.0]


def test_topics_that_are_absent_or_of_another_type_are_named(recorded):
    got = []
    wanted = inputs(
        got, ("one", "a", FLOAT), ("two", "b", "std_msgs/msg/Float32"), ("three", "c", FLOAT)
    )
    _, problems = watch_bag(recorded, wanted, Monitor(), namespace="d1")
    assert problems == {
        "two": "/d1/b carries std_msgs/msg/Float64, not std_msgs/msg/Float32",
        "three": "no messages on /d1/c",
    }
    assert {name for name, _, _ in got} == {"one"}


def test_a_bag_of_another_namespace_is_refused(recorded):
    with pytest.raises(InputError, match=r"the bag has none of /a, /b: .* `aerial-gnss doctor`"):
        watch_bag(recorded, inputs([], ("one", "a", FLOAT), ("two", "b", FLOAT)), Monitor())
