# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of namespaces, topics and nodes."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy")

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.names import absolute_namespace, check_topic, full_name
from aerial_gnss_ros.nodes.rivals import UNKNOWN


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("d1", "/d1"),
        ("/d1/", "/d1"),
        ("a/b", "/a/b"),
        ("/", "/"),
        (None, None),
        ("", ""),
        ("//a/", "/a"),
    ],
)
def test_a_namespace_begins_with_a_slash_and_ends_with_none(given, found):
    assert absolute_namespace(given) == found


@pytest.mark.parametrize("name", ["1st", "a b", "a-b"])
def test_names_that_ros_does_not_take_are_refused_in_one_line(name):
    for check, word in ((absolute_namespace, "namespace"), (check_topic, "topic")):
        with pytest.raises(ConfigError, match=f"'{name}' is not a valid {word}: ") as refused:
            check(name)
        assert "\n" not in str(refused.value)


def test_a_topic_may_be_relative_or_absolute():
    check_topic("image")
    check_topic("/camera/image")


@pytest.mark.parametrize(
    ("name", "namespace", "found"),
    [
        ("estimator", "/", "/estimator"),
        ("estimator", "/d1", "/d1/estimator"),
        ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_", UNKNOWN),
    ],
)
def test_a_node_has_its_namespace_before_its_name(name, namespace, found):
    assert full_name(name, namespace) == found
