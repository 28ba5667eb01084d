# SPDX-License-Identifier: Apache-2.0
"""Numbers in sentences for people."""

from __future__ import annotations

_HISSING = ("s", "x", "tch")


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: `1 robot`, `3 robots`, `0 boxes`."""
    if number == 1:
        return f"1 {noun}"
    return f"{number} {noun}{'es' if noun.endswith(_HISSING) else 's'}"
