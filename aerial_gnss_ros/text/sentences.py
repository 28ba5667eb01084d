# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Numbers and values in sentences for people."""

from __future__ import annotations

import reprlib
from datetime import datetime, timezone

_HISSING = ("s", "x", "tch")
_LONGEST = 200


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: `1 robot`, `3 robots`, `0 boxes`."""
    if number == 1:
        return f"1 {noun}"
    return f"{number} {noun}{'es' if noun.endswith(_HISSING) else 's'}"


def utc(stamp_ns: int) -> str:
    """Return a time, ns since 1970, to the second: `2026-11-22 23:15:00 UTC`."""
    date = datetime.fromtimestamp(stamp_ns // 1_000_000_000, tz=timezone.utc)
    return f"{date:%Y-%m-%d %H:%M:%S} UTC"


def shown(value: object) -> str:
    """Return a value's `repr`, shortened to fit into a sentence; of None, "nothing"."""
    if value is None:
        return "nothing"
    text = _SHORT.repr(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def cut(text: str) -> str:
    """Return a text without quotes, shortened like `shown`; unprintable characters are escaped."""
    return shown(text)[1:-1]


class _Short(reprlib.Repr):
    """Truncates while formatting: a value's full text may have gigabytes."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = 80
        self.maxlist = self.maxtuple = self.maxdict = 10
        self.maxlevel = 3

    def repr_int(self, value: int, level: int) -> str:
        """Return a whole number; Python itself refuses to format very long ones."""
        return super().repr_int(value, level) if value.bit_length() < 4096 else "a huge number"


_SHORT = _Short()
