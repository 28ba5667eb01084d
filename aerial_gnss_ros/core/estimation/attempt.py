# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Isolates failures that must not end a flight."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

Result = TypeVar("Result")
Given = ParamSpec("Given")


def attempt(
    work: Callable[Given, Result], *given: Given.args, **named: Given.kwargs
) -> Result | Exception:
    """Return the result of a call, or the exception that it raised.

    Raises:
        MemoryError: without memory the process is unreliable and must be restarted.
    """
    try:
        return work(*given, **named)
    except MemoryError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever it is, the flight continues
        return error
