# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Summaries of robots and consistency for diagnostics."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.faults.consistency import InnovationStatistics
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate, State


@dataclass(frozen=True)
class RobotSummary:
    """One robot for diagnostics.

    Attributes:
        robot_id: its name.
        class_id: class name as the detector gave it.
        state: confirmed or coasting.
        last_seen_ns: stamp of the image that measured it last, ns.
        sigma_m: one sigma of the position along the larger axis, m.
    """

    robot_id: str
    class_id: str
    state: State
    last_seen_ns: int
    sigma_m: float


@dataclass(frozen=True)
class Health:
    """Consistency of stated noise with measurements, for diagnostics.

    Attributes:
        fit: innovation statistics of the boxes.
        complaints: present inconsistencies, in sentences.
        platform: the platform's last estimated errors; empty without any.
    """

    fit: InnovationStatistics
    complaints: tuple[str, ...]
    platform: tuple[PlatformError, ...]


def summary(estimate: RobotEstimate) -> RobotSummary:
    """Return a robot for diagnostics."""
    return RobotSummary(
        estimate.robot_id,
        estimate.class_id,
        estimate.state,
        estimate.last_seen_ns,
        estimate.sigma,
    )
