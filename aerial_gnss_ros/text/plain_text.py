# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Text that other programs read: no character that XML forbids, no formula in a spreadsheet.

Class names come from model files and messages, so they are not trusted.
"""

from __future__ import annotations

import re

# Characters that are not Char in XML 1.0 (2.2), and the other control characters, including line
# breaks and tabs: a name has none, and they end table cells and subtitles.
_FORBIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
# Spreadsheets take a cell that begins with these for a formula. With some regional settings a
# comma-separated table is split at semicolons, so this applies after separators, too.
_FORMULA = re.compile(r"(^|[,;|])(?=\s*[=+\-@＝＋－＠])")


def printable(text: str) -> str:
    """Return a text with U+FFFD in place of control characters and invalid code points."""
    return text if text.isascii() and text.isprintable() else _FORBIDDEN.sub("\ufffd", text)


def spreadsheet_cell(text: str) -> str:
    """Return a text that a spreadsheet shows instead of evaluating it.

    An apostrophe is put before `=`, `+`, `-` and `@` where a cell could begin with them.
    """
    return _FORMULA.sub(r"\1'", printable(text))
