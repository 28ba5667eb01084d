# SPDX-License-Identifier: Apache-2.0
"""The executable `detector`; imports little, so that a signal ends it properly from the start."""

from __future__ import annotations

import sys

from aerial_gnss_ros.nodes.leaving import leave_on_signals


def main() -> int:
    """Run the detector node until a signal."""
    leave_on_signals()
    from aerial_gnss_ros.nodes import process
    from aerial_gnss_ros.nodes.detector_node import DetectorNode

    return process.main("detector", DetectorNode)


if __name__ == "__main__":
    sys.exit(main())
