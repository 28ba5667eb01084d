# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Odds of another latency to the configured one, by all images so far.

Nearly all flights have the configured latency (images and telemetry of one clock); of the others,
any latency within 3 s is as likely as another. `LatencyEvidence` says what images tell of each.

Telemetry that was written down with images has their stamps, and is late by up to the time between
two of them: its latency is known no better than that, so another one is certain.

Around an even circle every latency shows the same scene, turned about its centre, however long it
is flown: then none is ever ruled out. After a while images are compared more seldom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.latency_cover import LatencyCover
from aerial_gnss_ros.core.estimation.time_in_motion import TimeInMotion
from aerial_gnss_ros.core.filter.latency_evidence import agreed
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.filter.restarts import TUNING as RESTARTS
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyOddsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    elsewhere: float = 0.1
    """Probability before any image that the latency is another one. Judged."""
    ruled_out_nats: float = -3.0
    """Log likelihood of the best other latency at which the configured one is right. Judged."""
    apart_s: float = 0.25
    """Latencies nearer to the configured one do not keep the question open, s: they take long to
    tell apart. Judged."""


TUNING = LatencyOddsTuning()

PRIOR_NATS = math.log(TUNING.elsewhere / (1.0 - TUNING.elsewhere))
"""Log odds of another latency before any image."""


class LatencyOdds:
    """Compares images with other latencies.

    Args:
        unknown: the configuration of a latency that is not known.
        inputs: telemetry buffers.

    Attributes:
        search: what has been learnt of other latencies.
        cover: what these make of positions.
        nats: log odds of another latency.
        ruled_out: whether images speak against every other latency.
        motion: how long the camera has moved.
    """

    def __init__(self, unknown: EstimatorConfig, inputs: TelemetryBuffers) -> None:
        self.search = LatencySearch(unknown, inputs, weighs=True)
        self.cover = LatencyCover(self.search.corrections, TUNING.elsewhere)
        self.nats, self.ruled_out = -math.inf, False
        self.motion = TimeInMotion()

    def interrupt(self) -> None:
        """Begin anew with other robots; what images told stays."""
        self.search.reset()
        self.motion.interrupt()

    def follow(self, former: LatencyOdds) -> None:
        """Continue with another calibration, or about another configured latency."""
        self.search.follow(former.search)
        self.nats, self.ruled_out = former.nats, former.ruled_out
        self.motion = former.motion

    def update(self, scene: PosedFrame, measured: dict[str, int], local: LocalMap) -> None:
        """Take in an image.

        Args:
            scene: its boxes and the camera's pose.
            measured: index of the box of each labelled robot.
            local: the frame `map`.
        """
        self.search.compare(scene, measured, local)
        self.motion.update(scene.detections.stamp_ns, scene.in_map)
        evidence = self.search.evidence
        assert evidence is not None  # noqa: S101 - the search weighs
        least, most = evidence.bounds()
        self.cover.weigh(agreed(least, most))
        far = most[np.abs(self.search.corrections) > TUNING.apart_s]
        self.ruled_out = float(far.max()) < TUNING.ruled_out_nats
        self.nats = (
            math.inf if self.stamped_seldom else _log_odds(np.delete(least, evidence.configured))
        )

    @property
    def stamped_seldom(self) -> bool:
        """Whether telemetry has the stamps of images, and no latency is known for that reason."""
        return self.search.stamp_sigma_s > RESTARTS.sure_s


def _log_odds(gains: Array) -> float:
    """Return the log odds of other latencies to the configured one, nats.

    Args:
        gains: (h - 1,) log likelihood of each over the configured one; all are as likely before.
    """
    best = float(gains.max())
    return PRIOR_NATS + best + math.log(float(np.exp(gains - best).mean()))
