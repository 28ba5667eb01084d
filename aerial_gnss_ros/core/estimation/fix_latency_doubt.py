# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether the fix has another latency than configured: two hypotheses, weighed.

Most receivers and autopilots state positions for the time of their stamp. Others are late by 0.1 to
0.3 s, which at 5 m/s are 0.5 to 1.5 m, far beyond what their covariance states. `FixLatencySearch`
says what images tell of each latency.

Until that is decided, published covariances contain what the others make of positions. Once another
one is 20 times likelier, and known well enough, it is to be used, and the last images to be taken
in with it once more. Then its own correction is looked for. Where the drone flies straight on, or
circles evenly, images tell nothing: a late fix is then nothing but elsewhere, and the question
stays open until they tell.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.fix_latency_cover import FixLatencyCover
from aerial_gnss_ros.core.estimation.latency_doubt import ALWAYS_NS
from aerial_gnss_ros.core.estimation.latency_doubt import TUNING as LATENCY_DOUBT
from aerial_gnss_ros.core.estimation.latency_odds import PRIOR_NATS
from aerial_gnss_ros.core.estimation.latency_odds import TUNING as LATENCY_ODDS
from aerial_gnss_ros.core.estimation.recent_images import SeenImage
from aerial_gnss_ros.core.estimation.time_in_motion import TimeInMotion
from aerial_gnss_ros.core.filter.fix_latency_search import FixLatencySearch, NearLatencySearch
from aerial_gnss_ros.core.filter.latency_evidence import agreed
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.values.estimates import FrameResult


@dataclass(frozen=True)
class FixLatencyDoubtTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    usual_s: float = 0.15
    """Mean size of another latency, s: autopilots assume 0.1 to 0.2 s of receivers. Judged."""
    known_s: float = 0.05
    """Sigma of a latency with which it is used, s: half a step of the candidates. Judged."""
    most_images: int = 150
    """Number of images that are kept for a comparison with late ones: of one or two minutes."""


TUNING = FixLatencyDoubtTuning()

Array = NDArray[np.float64]


class FixLatencyDoubt:
    """Weighs "the fix is as late as configured" against "it has another latency".

    Args:
        config: of the estimator.
        inputs: telemetry buffers.

    Attributes:
        open: whether it is undecided.
        nats: log odds of another latency of the fix, rather than of the images.
    """

    def __init__(self, config: EstimatorConfig, inputs: TelemetryBuffers) -> None:
        self._inputs = inputs
        self._config = config
        self._begin()

    def _begin(self) -> None:
        """Look for another latency than the present one."""
        self.open, self.nats = True, -math.inf
        self._search = FixLatencySearch(self._config, self._inputs)
        self._of_images = NearLatencySearch(self._config, self._inputs)
        self._compared: deque[tuple[PosedFrame, dict[str, int]]] = deque(maxlen=TUNING.most_images)
        self._told = np.zeros(len(self._search.corrections))
        self._cover = FixLatencyCover(self._search.corrections, LATENCY_ODDS.elsewhere)
        self._prior = _log_prior(self._search.corrections)
        self._motion = TimeInMotion()
        self._due_ns = ALWAYS_NS

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Use another configuration; what images told of the latency stays."""
        self._config, former, of_images = config, self._search, self._of_images
        self._search = FixLatencySearch(config, self._inputs)
        self._search.follow(former)
        self._of_images = NearLatencySearch(config, self._inputs)
        self._of_images.follow(of_images)

    def reset(self) -> None:
        """Begin anew with other robots; what images told of the latency stays."""
        self._search.reset()
        self._of_images.reset()
        self._compared.clear()
        self._motion.interrupt()
        self._due_ns = ALWAYS_NS
        self.forget_images()

    def forget_images(self) -> None:
        """Begin with none of the images so far: telemetry or `map` are others now."""
        self._cover.forget()

    def close(self) -> None:
        """Decide no more."""
        self.open, self.nats = False, -math.inf

    def update(self, image: SeenImage, scene: PosedFrame, local: LocalMap) -> bool:
        """Take in an image; return whether another latency was found, and is used from now on.

        Images are wanted while it is `open`.

        Args:
            image: as the published tracker took it in.
            scene: its boxes and the camera's pose.
            local: the frame `map`.
        """
        stamp_ns = image.frame.stamp_ns
        if image.measured is None or stamp_ns < self._due_ns:
            return False
        self._search.compare(scene, image.measured, local)
        self._compared.append((scene, image.measured))
        self._motion.update(stamp_ns, scene.in_map)
        self._due_ns = stamp_ns + round(self._motion.pause_s * 1e9)
        bounds = self._search.evidence.bounds()
        gains, most = (self._told + one for one in bounds)
        self._cover.displacements = self._search.displacements()
        other = self._prior + (self._told + agreed(*bounds))
        self._cover.weigh(other + math.log(len(most) - 1))
        weighed = self._prior + gains
        likely = PRIOR_NATS + float(np.logaddexp.reduce(weighed))
        found = likely > LATENCY_DOUBT.doubted_nats and self._is_of_the_fix(gains, local)
        self.nats = likely if found else -math.inf
        if found:
            return self._use()
        others = np.delete(most, self._search.evidence.configured)
        self.open = bool(others.max() >= LATENCY_ODDS.ruled_out_nats)
        return False

    def _is_of_the_fix(self, gains: Array, local: LocalMap) -> bool:
        """Return whether the likeliest latency is within reach, and likelier than of the images.

        As late images move the camera to the same place, and turn it besides. They are compared
        only now, since that takes as long again.
        """
        best = int(np.argmax(gains))
        if not 0 < best < len(gains) - 1:
            return False
        while self._compared:
            self._of_images.compare(*self._compared.popleft(), local)
        of_images = float(self._of_images.evidence.gains()[best])
        return bool(gains[best] - of_images > LATENCY_DOUBT.doubted_nats)

    def _use(self) -> bool:
        """Use the latency that was found if it is known well enough; return whether it is."""
        correction_s, sigma_s = self._search.weighed()
        if sigma_s > TUNING.known_s:
            return False
        corrections = self._search.corrections
        gains = self._told + self._search.evidence.gains()
        self._inputs.fix_later_ns -= round(correction_s * 1e9)
        self._begin()
        # What images have told of each latency, over the one that is used now.
        told = np.interp(correction_s + self._search.corrections, corrections, gains)
        self._told = told - np.interp(correction_s, corrections, gains)
        return True

    def note(self, scene: PosedFrame, corrects: Mapping[str, str]) -> None:
        """Note the camera of an image, whose result is to be `mixed`.

        Args:
            scene: the image.
            corrects: label of the robot that each reference is which corrects its positions.
        """
        if self.open:
            self._cover.note(scene, corrects)

    def mixed(self, result: FrameResult) -> FrameResult:
        """Return a result whose robots are as uncertain as other latencies would displace them."""
        if not (self.open and result.estimates):
            return result
        return replace(result, estimates=tuple(self._cover.widened(result.estimates)))


def _log_prior(corrections: Array) -> Array:
    """Return log probabilities (h,) of corrections, s, where the latency is another one."""
    likely = np.where(np.abs(corrections) > TUNING.known_s, -np.abs(corrections), -np.inf)
    weights = likely / TUNING.usual_s
    return np.asarray(weights - np.logaddexp.reduce(weights))
