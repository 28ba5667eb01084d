# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The executable `detector`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from aerial_gnss_ros.nodes.executable import execute


def main() -> int:
    """Run the detector node until a signal."""
    return execute("detector", _node_class)


def _node_class() -> Callable[[], Any]:
    from aerial_gnss_ros.nodes.detector_node import DetectorNode

    return DetectorNode


if __name__ == "__main__":
    sys.exit(main())
