# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The package's nodes and the dataclasses of their parameters."""

from __future__ import annotations

from typing import Any

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.fleet import FleetConfig
from aerial_gnss_ros.detection.config import DetectorConfig

DETECTOR = "detector"
ESTIMATOR = "estimator"
FLEET = "fleet"
SCHEMAS: dict[str, type[Any]] = {
    DETECTOR: DetectorConfig,
    ESTIMATOR: EstimatorConfig,
    FLEET: FleetConfig,
}
