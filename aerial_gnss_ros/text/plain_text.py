# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Text that other programs read: no character that XML forbids, no formula in a spreadsheet.

Class names come from model files and from messages, so from strangers.
"""

from __future__ import annotations

import re

# What is not Char in XML 1.0 (2.2), and the other control characters. Line breaks and tabs, too:
# a name has none, and tables and subtitles end at them.
_FORBIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
# Spreadsheets take a cell that begins so for a formula. A table with commas may be split at
# semicolons, as some countries' settings do, so it counts behind separators, too.
_FORMULA = re.compile(r"(^|[,;|])(?=\s*[=+\-@＝＋－＠])")


def printable(text: str) -> str:
    """Return a text with U+FFFD for control characters and for what is no Unicode character."""
    return text if text.isascii() and text.isprintable() else _FORBIDDEN.sub("\ufffd", text)


def spreadsheet_cell(text: str) -> str:
    """Return a text that a spreadsheet shows and does not compute.

    An apostrophe is put before `=`, `+`, `-` and `@` where a cell could begin with them.
    """
    return _FORMULA.sub(r"\1'", printable(text))
