# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The executable `fleet`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from aerial_gnss_ros.nodes.executable import execute


def main() -> int:
    """Run the fleet node until a signal."""
    return execute("fleet", _node_class)


def _node_class() -> Callable[[], Any]:
    from aerial_gnss_ros.nodes.fleet_node import FleetNode

    return FleetNode


if __name__ == "__main__":
    sys.exit(main())
