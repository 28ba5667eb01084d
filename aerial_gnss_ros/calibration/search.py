# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Global search for the most likely delays: a grid of latencies, then refinement."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.evidence import Evidence, State
from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.problem import LIMIT_S, Problem
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.unknowns import FIX_DELAY, FOCAL, LATENCY
from aerial_gnss_ros.core.values.errors import InputError

Array = NDArray[np.float64]

GRID_S = 0.25
GRID = round(2.0 * LIMIT_S / GRID_S) + 1
COARSE_S, COARSE_IMAGES, MOST_IMAGES = 1.2, (50, 150), 240
COARSE_STEPS, STEPS, LAST_STEPS = 6, 8, 12
SPEEDS_MPS = (0.2, 0.003)
"""Initial speeds of robots, m/s: a descent is slow from a swimming to a resting robot."""
DISTINCT_S = 0.15
LEAST_IMAGES = 20
LEAST_COMMON = 0.6
"""Least share of images with telemetry at all latencies for comparing latencies on these."""
LACKING = (
    "Too few images have telemetry around them, at any latency within 3 s. Record telemetry from "
    "3 s before the images to 3 s after them; if samples are rare, raise max_gap of the input."
)
LEAST_SHARE = 0.4
"""Least share of boxes with telemetry for delays to be tried."""
HALF_STEPS, LEAST_HALF = 10, 8
RIVAL_NATS = 60.0
"""Log-likelihood deficit up to which coarse or short fits are refined: they have not converged, and
with few images a wrong latency fits nearly as well as the right one."""
FIX_DELAYS_S = (-0.8, -0.4, 0.4, 0.8)
SEPARATE_NATS = 5.0
"""Least gain of log likelihood for a separate delay of fixes."""


@dataclass(frozen=True)
class Candidate:
    """A fit at one local maximum of the likelihood of the delays.

    Attributes:
        evidence: the boxes associated there.
        state: the fit.
        score: log likelihood of the boxes, with unassociated ones uniform over the image.
    """

    evidence: Evidence
    state: State
    score: float

    @property
    def latency_s(self) -> float:
        """Latency of the images, s."""
        return float(self.state.unknowns[LATENCY])

    @property
    def fix_delay_s(self) -> float:
        """Delay of fixes and heights against orientations, s."""
        return float(self.state.unknowns[FIX_DELAY])


class Search:
    """Search over the delays of a recording.

    Args:
        recording: after the replay.
        focal: whether to estimate the focal length.

    Raises:
        InputError: too few images have telemetry.
    """

    def __init__(self, recording: Recording, focal: bool) -> None:
        self.motion = Motion(recording)
        self.fine = Problem(recording, self.motion, MOST_IMAGES)
        if len(self.fine.stamps_ns) < LEAST_IMAGES:
            raise InputError(LACKING)
        common = Problem(recording, self.motion, MOST_IMAGES, throughout=True)
        enough = len(common.stamps_ns) >= max(LEAST_IMAGES, LEAST_COMMON * len(self.fine.stamps_ns))
        # Likelihoods of fits to different numbers of boxes cannot be compared.
        if np.array_equal(common.stamps_ns, self.fine.stamps_ns):
            common = self.fine
        self.compared = common if enough else self.fine
        span_s = float(np.ptp(self.compared.stamps_ns)) * 1e-9
        images = int(np.clip(span_s / COARSE_S, *COARSE_IMAGES))
        self.coarse = Problem(recording, self.motion, images, throughout=enough)
        self._recording = recording
        self._base = frozenset() if focal else frozenset([FOCAL])

    @property
    def common(self) -> frozenset[int]:
        """Constants that are held while fixes have the delay of orientations."""
        return self._base | {FIX_DELAY}

    @property
    def separate(self) -> frozenset[int]:
        """Constants that are held while fixes have a delay of their own."""
        return self._base

    def grid(self, report: Callable[[int], None]) -> list[Candidate]:
        """Return the local maxima reached from a grid of latencies, the most likely first."""
        found = []
        for done, latency in enumerate(np.arange(-LIMIT_S, LIMIT_S + 1e-9, GRID_S), start=1):
            one = self.fit(self.coarse, float(latency), 0.0, COARSE_STEPS, self.common)
            found += [] if one is None else [one]
            report(done)
        return _distinct(found)

    def fit(
        self,
        problem: Problem,
        latency_s: float,
        fix_delay_s: float,
        steps: int,
        held: frozenset[int],
        speed_mps: float = SPEEDS_MPS[0],
    ) -> Candidate | None:
        """Return the fit started at some delays; None if no robot is seen."""
        linked = problem.evidence(latency_s, fix_delay_s, speed_mps)
        if linked is None or linked.share < LEAST_SHARE:
            return None
        state = linked.evidence.descend(linked.state, steps, held)
        # Boxes without telemetry count as the others do on average.
        score = (state.log_likelihood - linked.clutter) / linked.share
        return Candidate(linked.evidence, state, score)

    def best(self, modes: list[Candidate]) -> list[Candidate]:
        """Return refined fits of all maxima that may be the global one, the best first.

        Those within `RIVAL_NATS` of a refined one are refined, too.
        """
        top = modes[0].score
        tried = [one for one in modes if one.score > top - RIVAL_NATS]
        fits = [self.fit(self.compared, one.latency_s, 0.0, STEPS, self.common) for one in tried]
        rough = _distinct([one for one in fits if one is not None])
        done: list[Candidate] = []
        for one in rough:
            least = max((other.score for other in done), default=-math.inf) - RIVAL_NATS
            done.append(self.refined(one, self.common) if one.score > least else one)
        return _distinct(done)

    def refined(self, one: Candidate, held: frozenset[int]) -> Candidate:
        """Return a fit to the same images with the association repeated at its delays."""
        again = self._again(self.compared, one, held)
        return max([one, *again], key=lambda fit: fit.score)

    def to_all(self, one: Candidate, held: frozenset[int]) -> Candidate:
        """Return a fit to all images at its delays."""
        if self.compared is self.fine:
            return one
        return max(self._again(self.fine, one, held), key=lambda fit: fit.score, default=one)

    def _again(self, problem: Problem, one: Candidate, held: frozenset[int]) -> list[Candidate]:
        """Return fits started at its delays and each of `SPEEDS_MPS`."""
        at = one.latency_s, one.fix_delay_s
        fits = [self.fit(problem, *at, LAST_STEPS, held, speed) for speed in SPEEDS_MPS]
        return [fit for fit in fits if fit is not None]

    def half(self, best: Candidate, held: frozenset[int], late: bool) -> Candidate | None:
        """Return the fit of the first or the second half of the images; None if it sees too few."""
        stamps = self.fine.stamps_ns
        middle = int(stamps[len(stamps) // 2])
        within = (middle, int(stamps[-1])) if late else (int(stamps[0]), middle - 1)
        problem = Problem(self._recording, self.motion, MOST_IMAGES // 2, within)
        if len(problem.stamps_ns) < LEAST_HALF:
            return None
        return self.fit(problem, best.latency_s, best.fix_delay_s, HALF_STEPS, held)

    def separate_fit(self, best: Candidate) -> Candidate | None:
        """Return a fit with a separate delay of fixes, if that is more likely."""
        plain = self.fit(self.coarse, best.latency_s, 0.0, COARSE_STEPS, self.common)
        tries = [(best.latency_s, 0.0)]
        for delay in FIX_DELAYS_S:
            tries += [(best.latency_s, delay), (best.latency_s + delay, delay)]
        fits = [self.fit(self.coarse, a, b, COARSE_STEPS, self.separate) for a, b in tries]
        good = sorted([one for one in fits if one is not None], key=lambda one: -one.score)
        if plain is None or not good:
            return None
        at = good[0].latency_s, good[0].fix_delay_s
        fine = self.fit(self.compared, *at, STEPS, self.separate)
        return fine if fine is not None and fine.score > best.score + SEPARATE_NATS else None


def _distinct(found: list[Candidate]) -> list[Candidate]:
    """Return fits that are not close to a better one, the most likely first."""
    kept: list[Candidate] = []
    for one in sorted(found, key=lambda one: -one.score):
        if abs(one.latency_s) <= LIMIT_S + 0.3 and all(
            abs(one.latency_s - other.latency_s) > DISTINCT_S for other in kept
        ):
            kept.append(one)
    return kept
