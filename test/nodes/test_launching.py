# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the launch files have in common."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.nodes.launching import (
    end_where_restarts_are_of_no_use,
    is_true,
    listed,
    whole_namespace,
)


def test_wrong_input_ends_launch_and_a_death_does_not():
    now = [0.0]

    def ended(after_s, status, handler, is_shutdown=False):
        now[0] += after_s
        context = SimpleNamespace(is_shutdown=is_shutdown)
        handler(SimpleNamespace(returncode=status), context)

    def watch(respawn=True):
        return end_where_restarts_are_of_no_use("detector", respawn, lambda: now[0])

    handler = watch()
    for status in (0, 1, -11, 130):
        ended(1.0, status, handler)
    with pytest.raises(RuntimeError, match="detector refuses its parameters"):
        ended(1.0, 2, handler)
    handler = watch()
    ended(30.0, -9, handler)
    ended(1.0, 2, handler)  # its parameters were right: the model's file may come again
    handler = watch(respawn=False)
    ended(30.0, 0, handler, is_shutdown=True)
    with pytest.raises(RuntimeError, match="detector ended with status -11"):
        ended(1.0, -11, handler)


def test_arguments_are_read_as_ros_writes_them():
    assert [is_true(text) for text in ("True", "1", "", "false")] == [True, True, False, False]
    assert listed("/a.yaml, /b.yaml,") == ["/a.yaml", "/b.yaml"]


def test_a_namespace_is_below_that_of_the_file_that_includes_this_one():
    outer = SimpleNamespace(launch_configurations={"ros_namespace": "/fleet"})
    assert whole_namespace(outer, "drone1") == "fleet/drone1"
    assert whole_namespace(outer, "/drone1") == "/drone1"
    assert whole_namespace(outer, "") == "fleet"
    assert whole_namespace(None, "drone1") == "drone1"
