# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Weighs other latencies of the fix than the configured one, as `LatencySearch` does of images.

Receivers state where they were some time ago, by 0.1 to 0.3 s where stamps are those of arrival. So
a candidate takes the camera's place from another time than its orientation and its height, which
other sensors measure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.latency_band import LatencyBand
from aerial_gnss_ros.core.filter.latency_evidence import LatencyEvidence
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FixLatencySearchTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    reach_s: float = 0.5
    """Greatest correction of `fix.latency_s`, s: autopilots assume 0.1 to 0.2 s. Judged."""


TUNING = FixLatencySearchTuning()


class NearLatencySearch(LatencySearch):
    """Weighs corrections of `camera.latency_s` as small as a fix's.

    Args:
        config: noise, motion, latency of the images.
        inputs: telemetry buffers.

    Attributes:
        evidence: what images say of each correction.
    """

    evidence: LatencyEvidence

    def __init__(self, config: EstimatorConfig, inputs: TelemetryBuffers) -> None:
        noise = replace(config.noise, latency_s=TUNING.reach_s / SURE_SIGMAS)
        # All corrections are tried, whatever the images' latency is.
        most_s = abs(config.camera.latency_s) + 2.0 * TUNING.reach_s
        super().__init__(replace(config, noise=noise), inputs, weighs=True, most_s=most_s)


class FixLatencySearch(NearLatencySearch):
    """Weighs corrections of `fix.latency_s`, whose negatives are its candidates."""

    def _cameras(
        self, band: LatencyBand, positions: Array, rotations: Array
    ) -> tuple[Array, Array]:
        """Return places of the candidates' times, heights and orientations of the image's."""
        now = self.evidence.configured - band.part.start
        places = positions.copy()
        places[:, 2] = positions[now, 2]
        return places, np.broadcast_to(rotations[now], rotations.shape).copy()

    def displacements(self) -> dict[str, Array]:
        """Return how far (h, 2) from the configured latency's place each candidate has a robot, m.

        By label, of the robots that the filters track.
        """
        now = self.evidence.configured
        return {name: places - places[now] for name, places in self._bands[0].bank.places().items()}
