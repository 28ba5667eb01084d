# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Work whose failure must not end a flight."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

Result = TypeVar("Result")
Given = ParamSpec("Given")


def attempt(
    work: Callable[Given, Result], *given: Given.args, **named: Given.kwargs
) -> Result | Exception:
    """Return what some work makes of its arguments, or the exception that it raised.

    Raises:
        MemoryError: nothing in the process can be relied on without memory; it is to be restarted.
    """
    try:
        return work(*given, **named)
    except MemoryError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever it is, the flight goes on
        return error
