# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Consistency checks: agreement of both halves of a recording, and fit of the boxes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.evidence import HUBER
from aerial_gnss_ros.calibration.search import STEPS, Candidate, Search
from aerial_gnss_ros.calibration.unknowns import FIRST_ROBOT, LATENCY
from aerial_gnss_ros.core.config.estimator import EstimatorConfig

Array = NDArray[np.float64]

LEAST_INTERVAL_S = 0.03
"""Sample intervals below this need no check: the latency is known well enough, s."""
IN_STEP = 0.5
"""Length of the mean phasor (one turn per interval) above which images count as in step."""
DEEPER_NATS = 10.0
"""Least log-likelihood advantage of a fit one interval away over one half an interval away."""
AGREE = 2.0
OUTLIERS = 0.08
FASTER = 1.25
"""Factor on `tracks.max_speed` that noise alone can cause in a path."""
COARSE_BOXES = 0.006
"""Greatest plausible white noise of a detector's boxes, as a share of the image width."""


def disagreement(search: Search, best: Candidate, held: frozenset[int], delays: list[int]) -> Array:
    """Return the factors (k,) on the delays' sigmas with which the halves agree."""
    fits = [search.half(best, held, late) for late in (False, True)]
    factors = np.ones(len(delays))
    if fits[0] is None or fits[1] is None:
        return factors
    picks = [np.eye(one.evidence.model.layout.size)[delays] for one in fits if one is not None]
    values, spreads = [], []
    for one, pick in zip(fits, picks, strict=True):
        assert one is not None  # noqa: S101
        values.append(pick @ one.state.unknowns)
        spreads.append(np.diag(one.evidence.covariance(one.state, pick)))
    off = np.abs(values[0] - values[1]) / np.sqrt(spreads[0] + spreads[1])
    return np.asarray(np.maximum(1.0, off / AGREE))


def between_samples(search: Search, best: Candidate, held: frozenset[int]) -> str | None:
    """Return why the latency may be an artefact of sampling; None if it is not.

    Interpolation reduces the samples' errors, most of all halfway between two. If images are at a
    constant phase of the sampling interval, a latency that puts them halfway fits better whether it
    is true or not: the likelihood has a maximum in each interval. The test is whether the fit a
    whole interval from the best latency is better than half an interval from it.
    """
    motion, interval_s = search.motion, search.motion.sample_s
    since_ns = (search.fine.stamps_ns - motion.start_ns).astype(np.float64)
    scenes = since_ns * 1e-9 - best.latency_s
    if interval_s < LEAST_INTERVAL_S or not _in_step(scenes, motion.samples_s):
        return None
    known = 0
    for side in (-1.0, 1.0):
        at = [best.latency_s + side * share * interval_s for share in (0.5, 1.0)]
        fits = [
            search.fit(search.compared, one, best.fix_delay_s, STEPS, held | {LATENCY})
            for one in at
        ]
        if fits[0] is None or fits[1] is None:
            continue
        if fits[1].score < fits[0].score + DEEPER_NATS:
            return None
        known += 1
    if not known:
        return None
    return (
        "images are in step with telemetry, and fit well halfway between any two samples "
        f"{interval_s:.2f} s apart"
    )


def _in_step(t: Array, samples: Array) -> bool:
    """Whether times (n,) are all at nearly the same phase between two samples (m,)."""
    phases = np.interp(t, samples, np.arange(len(samples)))[(t > samples[0]) & (t < samples[-1])]
    return len(phases) > 0 and bool(np.abs(np.exp(2.0j * math.pi * phases).mean()) > IN_STEP)


def misfit(best: Candidate, config: EstimatorConfig) -> tuple[str, ...]:
    """Return sentences on why the boxes do not fit; empty if they do."""
    state, found = best.state, []
    share = float(np.mean(state.distances > HUBER * 1.4))
    width = max(camera.width for camera, _ in best.evidence.model.boxes.cameras)
    if state.pixel > max(COARSE_BOXES * width, 3.0 * config.noise.value("box_center_px")):
        found.append(
            f"boxes are {state.pixel:.0f} px from the best fit, far more than a detector's noise."
        )
    if share > OUTLIERS:
        found.append(f"{share:.0%} of the boxes are far from the best fit.")
    speeds = math.sqrt(2.0) * state.sigmas[FIRST_ROBOT:]
    fast = [
        f"{name} at {speed:.1f} m/s"
        for name, speed in zip(best.evidence.model.names, speeds, strict=True)
        if speed > FASTER * config.tracks.max_speed
    ]
    if fast:
        found.append(f"robots would have to move faster than they can: {', '.join(fast)}.")
    return tuple(found)
