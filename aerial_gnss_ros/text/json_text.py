# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Strict JSON for files and messages: a text gives its content or a ValueError."""

from __future__ import annotations

import json
from typing import Any

_MOST_DIGITS = 40


def parse_json(text: str) -> Any:
    """Return the content of a JSON text.

    Raises:
        ValueError: not JSON, a key twice, a number of more than 40 digits, or nested too deeply;
            the message is one line.
    """
    try:
        return json.loads(text, object_pairs_hook=_object, parse_int=_whole)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice[:60]!r} is given twice")
    return made


def _whole(digits: str) -> int:
    if len(digits) > _MOST_DIGITS:
        raise ValueError(f"{digits[:_MOST_DIGITS]}… has too many digits")
    return int(digits)
