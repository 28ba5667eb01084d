# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names are valid topics, unique, and in order."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.identity.label_format import LabelRegistry, class_token


@pytest.mark.parametrize(
    ("class_id", "token"),
    [
        ("aqua", "aqua"),
        ("Aqua 2", "aqua_2"),
        ("Água-viva!", "agua_viva"),
        ("2nd", "robot_2nd"),
        ("__x__y", "x_y"),
        ("海", "robot"),
        ("", "robot"),
    ],
)
def test_class_names_become_tokens(class_id, token):
    assert class_token(class_id) == token


@given(st.text(max_size=30))
def test_every_name_is_a_valid_topic(class_id):
    name = LabelRegistry().next(class_id)
    assert re.fullmatch(r"[a-z][a-z0-9_]*_1", name)
    assert "__" not in name  # ROS 2 refuses it


def test_numbers_count_up_and_skip_what_is_taken_or_bound():
    names = LabelRegistry(frozenset({"aqua_2"}), {}, {"aqua_3"})
    assert [names.next("aqua") for _ in range(3)] == ["aqua_1", "aqua_4", "aqua_5"]
    assert names.next("buoy") == "buoy_1"


@given(st.lists(st.sampled_from(["aqua", "Aqua", "aqua 1", "aqua_1", "b"]), max_size=40))
def test_no_name_is_given_twice(classes):
    names = LabelRegistry()
    given_names = [names.next(class_id) for class_id in classes]
    assert len(set(given_names)) == len(given_names)


def test_bound_names_are_given_once_until_released():
    names = LabelRegistry(frozenset({"leader"}))
    assert list(names.free_bound()) == ["leader"]
    names.reserve("leader")
    assert list(names.free_bound()) == []
    names.release_bound()
    assert list(names.free_bound()) == ["leader"]
