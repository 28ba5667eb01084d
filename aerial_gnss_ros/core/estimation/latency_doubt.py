# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether images come as late as configured, or by another latency: two hypotheses, weighed.

Nearly all flights have the configured latency (images and telemetry of one clock); of the others,
any latency within 3 s is as likely as another. Two things tell them apart:

- how well each latency fits the boxes of robots (`latency_bank`);
- how many boxes come to nothing while the camera moves. With a wrong latency robots seem to move
  with the camera; where that is faster than robots can, boxes lie outside the gates, and nothing is
  left that could be fitted. Their share has a beta distribution under either hypothesis.

The question is closed once it is decided, or after `decided_s` in motion: a latency does not begin
in mid-flight, unlike a fault, and what comes to nothing later says nothing of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_vector
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers


@dataclass(frozen=True)
class LatencyDoubtTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    elsewhere: float = 0.1
    """Probability before any image that the latency is another one. Judged."""
    lost_right: tuple[float, float] = (1.0, 19.0)
    """Beta distribution of the share of boxes that come to nothing if it is as configured: 5 % on
    average. Judged."""
    lost_wrong: tuple[float, float] = (0.5, 0.5)
    """The same if it is another one: nearly all, or, as of a drone on a straight line, none."""
    event_s: float = 0.5
    """Boxes that come to nothing within this time do so for one cause, s. Judged."""
    caution: float = 1.7
    """Divisor of the fits' log likelihoods: neither robots nor errors follow the model exactly. As
    in a calibration, 1.3 on sigmas."""
    doubted_nats: float = 0.25
    """Log odds of another latency at which it is looked for: one event alone does not decide.
    Judged."""
    settled_nats: float = -4.0
    """Log odds, of the fits and the prior, at which the configured latency is right. Judged."""
    interval_s: float = 0.4
    """Least time between images that are taken, s: some ten decide, and each costs as much as one
    in the filter. Judged."""
    decided_s: float = 30.0
    """Time in motion after which the configured latency is taken for right, s. Judged."""
    moving_mps: float = 0.5
    """A camera that moves more slowly, and turns more slowly than `turning_radps`, says nothing of
    the latency, m/s. Judged."""
    turning_radps: float = math.radians(1.0)
    """The same of its rotation, rad/s. Judged."""


TUNING = LatencyDoubtTuning()

UNKNOWN_S = 1.0
"""Prior sigma of a latency that is looked for, s: up to 3 s either way."""

ALWAYS_NS, NEVER_NS = -(2**63), 2**63


class LatencyDoubt:
    """Weighs "as configured" against "another latency".

    Args:
        config: of the estimator.
        inputs: telemetry buffers.

    Attributes:
        open: whether it is undecided.
        doubted: whether another latency was found likelier.
        due_ns: stamp of the next image that is wanted, ns.
        unknown: the configuration of a latency that is not known.
        search: what has been learnt of other latencies.
    """

    def __init__(self, config: EstimatorConfig, inputs: TelemetryBuffers) -> None:
        self.open, self.doubted = True, False
        self._inputs = inputs
        self.unknown = _unknown(config)
        self.search = LatencySearch(self.unknown, inputs)
        self._counts, self._boxes = (0.0, 0.0), (0, 0)
        self.reset()

    def reconfigure(self, config: EstimatorConfig) -> EstimatorConfig:
        """Use another configuration; return the one that the filter is to use."""
        self.unknown = _unknown(config)
        if self.open:
            former, self.search = self.search, LatencySearch(self.unknown, self._inputs)
            self.search.follow(former)
        return self.unknown if self.doubted else config

    def reset(self) -> None:
        """Forget the images, but not what they told of the boxes."""
        self.search.reset()
        self._last: tuple[int, MapPose] | None = None
        self.due_ns = ALWAYS_NS if self.open else NEVER_NS

    def update(
        self,
        scene: PosedFrame,
        measured: dict[str, int],
        local: LocalMap,
        used: int,
        lost: int,
    ) -> bool:
        """Take in an image that is due; return True, once, if another latency is likelier.

        Args:
            scene: its boxes and the camera's pose.
            measured: index of the box of each labelled robot.
            local: the frame `map`.
            used: number of boxes so far that updated robots.
            lost: number so far that came to nothing as those of a wrong latency do.
        """
        if not self.open:
            return False
        stamp_ns = scene.detections.stamp_ns
        self.search.compare(scene, measured, local)
        passed_s = self._moved_s(stamp_ns, scene.in_map)
        if passed_s:
            self._count(passed_s, used - self._boxes[0], lost - self._boxes[1])
        self._last, self._boxes = (stamp_ns, scene.in_map), (used, lost)
        fits = self.search.other_latency_nats / TUNING.caution
        prior = math.log(TUNING.elsewhere / (1.0 - TUNING.elsewhere))
        # Only boxes that were used are fitted: these cannot clear a latency that loses the others.
        self.doubted = prior + max(fits, 0.0) + self._lost_nats() > TUNING.doubted_nats
        in_motion_s = sum(self._counts) * TUNING.event_s
        settled = prior + fits < TUNING.settled_nats or in_motion_s > TUNING.decided_s
        self.open = not (self.doubted or settled)
        self.due_ns = stamp_ns + round(TUNING.interval_s * 1e9) if self.open else NEVER_NS
        return self.doubted

    def _moved_s(self, stamp_ns: int, pose: MapPose) -> float:
        """Return the time since the last image, s; 0 if the camera has hardly moved or turned."""
        if self._last is None or stamp_ns <= self._last[0]:
            return 0.0
        last_ns, last = self._last
        passed_s = (stamp_ns - last_ns) * 1e-9
        way = float(np.linalg.norm(pose.position - last.position))
        turn = float(np.linalg.norm(rotation_vector(pose.rotation @ last.rotation.T)))
        moves = way > TUNING.moving_mps * passed_s or turn > TUNING.turning_radps * passed_s
        return passed_s if moves else 0.0

    def _count(self, passed_s: float, used: int, lost: int) -> None:
        """Count boxes that came to nothing since the last image, and those that did not."""
        if not used + lost:
            return
        share = min(passed_s / TUNING.event_s, 1.0)
        lost_share = share * lost / (used + lost)
        self._counts = self._counts[0] + lost_share, self._counts[1] + share - lost_share

    def _lost_nats(self) -> float:
        """Return how much likelier another latency loses so many boxes, nats."""
        wrong = _log_probability(TUNING.lost_wrong, self._counts)
        return wrong - _log_probability(TUNING.lost_right, self._counts)


def _unknown(config: EstimatorConfig) -> EstimatorConfig:
    return replace(config, noise=replace(config.noise, latency_s=UNKNOWN_S))


def _log_probability(prior: tuple[float, float], counts: tuple[float, float]) -> float:
    """Return the log probability of counts whose shares have a beta distribution."""

    def log_beta(one: float, other: float) -> float:
        return math.lgamma(one) + math.lgamma(other) - math.lgamma(one + other)

    return log_beta(prior[0] + counts[0], prior[1] + counts[1]) - log_beta(*prior)
