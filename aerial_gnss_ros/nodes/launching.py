# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the launch files have in common; needs none of ROS' launch packages."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

RESPAWN_DELAY_S = 1.0
END_S = "15"  # longer than a busy machine takes to save labels and end
_WRONG_INPUT = 2  # the exit status of a node that refuses its parameters
_STEADY_S = 20.0  # what ran for so long had right parameters


def is_true(text: str) -> bool:
    """Return whether an argument means yes."""
    return text.lower() in ("true", "1", "yes", "on")


def listed(text: str) -> list[str]:
    """Return the parts of an argument that commas separate."""
    return [one.strip() for one in text.split(",") if one.strip()]


def whole_namespace(context: Any, own: str) -> str:
    """Return the whole namespace of the nodes, as launch_ros joins it."""
    outer = getattr(context, "launch_configurations", {}).get("ros_namespace", "")
    return own if own.startswith("/") else f"{outer.rstrip('/')}/{own}".strip("/")


def end_where_restarts_are_of_no_use(
    name: str, respawn: bool, clock: Callable[[], float] = time.monotonic
) -> Callable[[Any, Any], None]:
    """Return what launch calls when a node has ended; it raises where no restart follows, or helps.

    Args:
        name: of the node.
        respawn: whether launch starts it again.
        clock: monotonic seconds.
    """
    began_s, was_well = clock(), False

    def ended(event: Any, context: Any) -> None:
        nonlocal began_s, was_well
        now_s = clock()
        was_well |= now_s - began_s >= _STEADY_S
        began_s = now_s
        if context.is_shutdown:  # launch ends its nodes itself
            return
        if event.returncode == _WRONG_INPUT and not was_well:
            raise RuntimeError(f"the {name} refuses its parameters, as it says above")
        if not respawn:
            raise RuntimeError(f"the {name} ended with status {event.returncode}")

    return ended
