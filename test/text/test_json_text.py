# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whatever a JSON text holds: its content, or a ValueError of one line."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.text.json_text import parse_json


def test_json_is_read():
    assert parse_json('{"a": [1, 2.5, null], "b": {"a": "x"}}') == {
        "a": [1, 2.5, None],
        "b": {"a": "x"},
    }
    assert parse_json("1" * 40) == int("1" * 40)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[" * 100_000, "1" * 41, '{"a": 1, "b": {"c": 1, "c": 2}}', "\0", '"\ud800'],
    ids=["empty", "cut", "deep", "digits", "twice", "NUL", "surrogate"],
)
def test_everything_else_is_a_short_value_error(text):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - any message will do
        parse_json(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200
