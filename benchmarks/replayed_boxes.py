# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replays of bags that hold boxes, so that no network is loaded."""

from __future__ import annotations

from typing import Any

from aerial_gnss_ros.detection.config import DetectorConfig


def no_detector(_config: DetectorConfig) -> Any:
    """Take the place of the function that loads a network.

    Raises:
        AssertionError: always; the bag lacks boxes.
    """
    raise AssertionError("the bag lacks boxes")
