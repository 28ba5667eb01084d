# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Text for other programs: what XML forbids is replaced, what a spreadsheet computes quoted."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.text.plain_text import printable, spreadsheet_cell


@pytest.mark.parametrize("text", ["aqua", "Roboter Größe 2", "机器人", "a <b> & c", "🤖", "a-b"])
def test_a_name_stays_as_it_is(text):
    assert printable(text) == text
    assert spreadsheet_cell(text) == text


@pytest.mark.parametrize("code", [0, 1, 9, 10, 13, 0x1B, 0x7F, 0x85, 0x2028, 0xD800, 0xFFFE])
def test_what_no_name_has_is_replaced(code):
    assert printable(f"a{chr(code)}b") == "a\ufffdb"


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("=cmd|' /C calc'!A0", "'=cmd|' /C calc'!A0"),
        ("+1", "'+1"),
        ("-1", "'-1"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("  =1", "'  =1"),
        ("＝1", "'＝1"),
        ("a;=1", "a;'=1"),
        ("a,-1", "a,'-1"),
        ("\t=1", "\ufffd=1"),
        ("a=1", "a=1"),
    ],
)
def test_a_cell_is_no_formula(text, cell):
    assert spreadsheet_cell(text) == cell
