# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Entry of both executables; imports little, so that a signal ends them cleanly at any time."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.nodes.leaving import leave_on_signals

WRONG_INPUT = 2


def execute(name: str, node_class: Callable[[], Callable[[], Any]]) -> int:
    """Run a node until a signal and return the exit status.

    Args:
        name: of the executable, for messages.
        node_class: imports and returns the node's class.
    """
    leave_on_signals()
    try:
        require_ros()
    except RosError as error:
        sys.stderr.write(f"{name}: {error}\n")
        return WRONG_INPUT
    from aerial_gnss_ros.nodes import process
    from aerial_gnss_ros.nodes.transport import use_prompt_profile

    use_prompt_profile()
    return process.main(name, node_class())
