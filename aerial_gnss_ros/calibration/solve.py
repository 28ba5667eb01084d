# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Estimates the constants of a recording: delays first, then the platform's errors.

Both come from the likelihood of the boxes (`evidence.py`). Robots that swim contribute to the
delays only: their motion is independent of the camera's rotation and vibration. But a wrong height
or tilt changes the size and curvature of their paths, and no robot follows the motion model
exactly, so their paths are left free when the platform's errors are estimated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.checks import between_samples, disagreement, misfit
from aerial_gnss_ros.calibration.evidence import DAMPINGS, HUBER, State
from aerial_gnss_ros.calibration.excitation import excitation
from aerial_gnss_ros.calibration.fit import UNKNOWNS, Fit
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.search import LEAST_IMAGES, Candidate, Search
from aerial_gnss_ros.calibration.unknowns import CONSTANTS, FIRST_ROBOT, FIX_DELAY, FOCAL, LATENCY
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import counted

Array = NDArray[np.float64]

SWIMS_MPS, FREE_MPS = 0.01, 10.0
FREE_STEPS = 1
"""Number of steps with free paths: one, a linear fit about the most likely unknowns. Further steps
would lower the height, because all paths are short near the camera."""
CAUTION = 1.3
"""Factor on the sigmas of the likelihood: neither robots nor errors follow the model exactly."""
RIVAL_NATS = 6.0 * CAUTION**2
"""Log-likelihood deficit below which a fit may be the true one: a factor of 400 with sigmas
increased by `CAUTION`."""


def calibrate(
    recording: Recording,
    config: EstimatorConfig,
    *,
    focal: bool = False,
    progress: Callable[[int], None] = lambda _done: None,
) -> Fit:
    """Estimate all constants.

    Args:
        recording: after the replay.
        config: of the replay.
        focal: whether to estimate the focal length.
        progress: called with a growing number.

    Raises:
        InputError: too few robots were seen.
    """
    seen = sum(1 for frame in recording.frames.values() if len(frame))
    if seen < LEAST_IMAGES:
        raise InputError(
            f"{counted(seen, 'image')} have boxes that may be robots, but a calibration needs at "
            f"least {LEAST_IMAGES}; record a robot that is in view for longer."
        )
    search = Search(recording, focal)
    modes = search.grid(progress)
    if not modes:
        raise InputError(
            "No robot was seen in several images in quick succession; record a robot that is in "
            "view for longer, with more images a second."
        )
    fits = search.best(modes)
    best, rivals = fits[0], _rivals(fits)
    separate = search.separate_fit(best)
    if separate is not None:
        best, rivals = search.refined(separate, search.separate), []
    best = search.to_all(best, search.common if separate is None else search.separate)
    return _fit(search, best, rivals, separate is not None, config, focal)


def _rivals(fits: list[Candidate]) -> list[float]:
    """Return the latencies that fit nearly as well as the best, s."""
    return [one.latency_s for one in fits[1:] if one.score > fits[0].score - RIVAL_NATS]


def _fit(
    search: Search,
    best: Candidate,
    rivals: list[float],
    separate: bool,
    config: EstimatorConfig,
    focal: bool,
) -> Fit:
    delays = [LATENCY, FIX_DELAY] if separate else [LATENCY]
    evidence, state = best.evidence, best.state
    model = evidence.model
    held = search.separate if separate else search.common
    factors = CAUTION * disagreement(search, best, held, delays)
    picks = np.eye(model.layout.size)[delays]
    covariance = evidence.covariance(state, picks) * np.outer(factors, factors)
    names, mean, whole = _with_platform(best, delays, covariance, focal)
    mean[0] -= config.camera.latency_s
    ambiguities = {"latency": f"{rivals[-1]:+.2f} s fits nearly as well"} if rivals else {}
    locked = between_samples(search, best, held)
    if locked is not None:
        ambiguities["latency"] = locked
    flown = excitation(
        model.poses(state.unknowns), model.boxes.images, model.tracks, model.places(state.unknowns)
    )
    return Fit(
        names, mean, whole, state.pixel, len(state.distances),
        int(np.sum(state.distances > HUBER * 1.4)), len(np.unique(model.boxes.images)),
        model.names, flown, tuple(float(one) * 2.0**0.5 for one in state.sigmas[FIRST_ROBOT:]),
        ambiguities, misfit(best, config),
    )  # fmt: skip


def _with_platform(
    best: Candidate, delays: list[int], covariance: Array, focal: bool
) -> tuple[tuple[str, ...], Array, Array]:
    """Return names, values and covariance of all constants, delays first."""
    evidence = best.evidence
    held = frozenset([LATENCY, FIX_DELAY]) | (frozenset() if focal else frozenset([FOCAL]))
    free = evidence.descend(_with_free_paths(best.state), FREE_STEPS, held, adapt=False)
    layout = evidence.model.layout
    picks = [layout.mean_of(name) for name in CONSTANTS]
    names = ["latency", "fix_latency"][: len(delays)] + list(CONSTANTS)
    if focal:
        names.append("focal")
        picks.append(np.eye(1, layout.size, FOCAL)[0])
    table = np.array(picks)
    own = CAUTION**2 * evidence.covariance(free, table)
    slopes = evidence.slopes(free, table, delays, held)
    whole = np.block(
        [
            [covariance, covariance @ slopes.T],
            [slopes @ covariance, own + slopes @ covariance @ slopes.T],
        ]
    )
    mean = np.concatenate([best.state.unknowns[delays], table @ free.unknowns])
    order = [names.index(one.name) for one in UNKNOWNS if one.name in names]
    return tuple(names[i] for i in order), mean[order], whole[np.ix_(order, order)]


def _with_free_paths(state: State) -> State:
    """Return the state with free paths of all swimming robots."""
    sigmas = state.sigmas.copy()
    swims = sigmas[FIRST_ROBOT:] > SWIMS_MPS
    sigmas[FIRST_ROBOT:][swims] = FREE_MPS
    effective = None if state.effective is None else state.effective.copy()
    if effective is not None:
        effective[FIRST_ROBOT:-1][swims] = 0.0
        effective[-1] *= not swims.any()
    return replace(state, sigmas=sigmas, effective=effective, damping=DAMPINGS[0])
