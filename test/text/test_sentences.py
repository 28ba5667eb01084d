# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Numbers in sentences."""

import pytest

from aerial_gnss_ros.text.sentences import counted, cut, shown, utc


@pytest.mark.parametrize(
    ("number", "noun", "words"),
    [
        (1, "robot", "1 robot"),
        (3, "robot", "3 robots"),
        (0, "false box", "0 false boxes"),
        (2, "class", "2 classes"),
        (2, "epoch", "2 epochs"),
        (2, "switch", "2 switches"),
    ],
)
def test_a_number_takes_the_noun_with_it(number, noun, words):
    assert counted(number, noun) == words


def test_values_are_shown_in_part_where_they_are_long():
    for value in (1, -2.5, "a b", True, [1, "x"], {"a": (1, 2)}):
        assert shown(value) == repr(value)
    assert shown(None) == "nothing"
    nested = ["x"] * 50
    for _ in range(50):
        nested = [nested] * 50
    for value in ("x" * 10**6, list(range(10**6)), nested, 10**5000, 1 << 10**6):
        assert len(shown(value)) < 1000


def test_names_stand_as_they_are_and_long_or_unprintable_ones_do_no_harm():
    assert cut("aqua_1 (red)") == "aqua_1 (red)"
    assert "\x1b" not in cut("\x1b[31m")
    assert len(cut("x" * 10**6)) < 100


def test_a_time_is_in_utc_and_cut_to_the_second():
    assert utc(1_700_000_000_999_999_999) == "2023-11-14 22:13:20 UTC"
