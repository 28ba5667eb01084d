# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selects positions far enough apart in time for another filter to take them as independent.

A robot's own filter takes the errors of its measurements as white. Those of published positions are
not: they are mostly the drone's GNSS offset, a Gauss-Markov process whose correlation time is
minutes. Taken every image, the offset would be averaged as if it were noise, and the filter would
become overconfident.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.config.processing import UpdatesConfig
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State


@dataclass(frozen=True)
class PositionUpdatesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    correlation_times: float = 3.0
    """Interval over correlation time: errors of consecutive samples are then correlated by 5 %,
    which increases sigmas by 5 %."""
    shortest_s: float = 30.0
    """Interval where errors are stated as white; the tracker's own settle within some seconds."""


TUNING = PositionUpdatesTuning()
SECOND_NS = 1_000_000_000


@dataclass
class _Robot:
    """State of a robot.

    Attributes:
        since_ns: start of its measurements without a gap longer than the settling time, ns.
        seen_ns: stamp of its last measurement, ns.
        given_ns: stamp of its last sample, ns, or None.
    """

    since_ns: int
    seen_ns: int
    given_ns: int | None = None


class PositionUpdates:
    """Samples each robot's position, and inflates the covariance for their correlation.

    The mean of many samples of a process with correlation ρ from one to the next has the variance
    of as many independent ones times (1 + ρ) / (1 − ρ) (Priestley, Spectral Analysis and Time
    Series, 1981, chapter 5): by this factor each sample's covariance is multiplied, so that a
    filter that averages them is consistent.

    Args:
        config: interval and settling time.
        correlation_time_s: of the platform's slow errors.

    Attributes:
        interval_s: least time between two samples of a robot.
        factor: on covariances.
    """

    def __init__(self, config: UpdatesConfig, correlation_time_s: float) -> None:
        given = config.interval_s
        decided = max(TUNING.shortest_s, TUNING.correlation_times * correlation_time_s)
        self.interval_s = decided if math.isnan(given) else given
        shared = math.exp(-self.interval_s / correlation_time_s) if correlation_time_s else 0.0
        self.factor = (1.0 + shared) / (1.0 - shared)
        self._settle_ns = round(config.settle_s * SECOND_NS)
        self._interval_ns = round(self.interval_s * SECOND_NS)
        self._robots: dict[str, _Robot] = {}

    def due(self, result: FrameResult) -> tuple[RobotEstimate, ...]:
        """Return the samples due with an image's result, with inflated covariances."""
        measured = [one for one in result.estimates if one.state is State.CONFIRMED]
        return tuple(
            replace(one, covariance=self.factor * one.covariance)
            for one in measured
            if self._is_due(one)
        )

    def _is_due(self, estimate: RobotEstimate) -> bool:
        """Record a robot's measurement; return whether it is a sample."""
        stamp_ns = estimate.stamp_ns
        robot = self._robots.get(estimate.robot_id)
        if robot is None or stamp_ns < robot.seen_ns:  # a recording that restarts
            robot = self._robots[estimate.robot_id] = _Robot(stamp_ns, stamp_ns)
        if stamp_ns - robot.seen_ns > max(self._settle_ns, SECOND_NS):
            robot.since_ns = stamp_ns
        robot.seen_ns = stamp_ns
        if stamp_ns - robot.since_ns < self._settle_ns:
            return False
        if robot.given_ns is not None and stamp_ns - robot.given_ns < self._interval_ns:
            return False
        robot.given_ns = stamp_ns
        return True
