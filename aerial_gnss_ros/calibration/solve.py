# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds the constants of a recording: delays first, then the platform's errors.

Both come from the likelihood of the boxes (`evidence.py`), but a robot that swims is trusted with
delays only. Where it swims is seen against how the camera turns and shakes, which it knows nothing
of; how large its path is and how it bends is just what a wrong height or tilt changes, and no robot
swims as a model says. For the platform's errors its path is therefore left free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.checks import agreed, trouble
from aerial_gnss_ros.calibration.evidence import HUBER, State
from aerial_gnss_ros.calibration.excitation import excitation
from aerial_gnss_ros.calibration.fit import Fit
from aerial_gnss_ros.calibration.layout import (
    BOX,
    CONSTANTS,
    EXTRA,
    FIRST_ROBOT,
    FOCAL,
    LATENCY,
)
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.search import LEAST_IMAGES, Found, Search
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import counted

Array = NDArray[np.float64]

SWIMS_MPS, FREE_MPS = 0.01, 10.0
FREE_STEPS = 6
CAUTION = 1.3
"""Sigmas are so much larger than the likelihood has them: neither robots nor errors are as the
model says."""
OF_SAMPLE = 0.0
"""How a drone moves between two samples is not known: delays are known to so much of their gap."""
RIVAL_NATS = 6.0


def calibrate(
    recording: Recording,
    config: EstimatorConfig,
    *,
    focal: bool = False,
    progress: Callable[[int], None] = lambda _done: None,
) -> Fit:
    """Find all constants.

    Args:
        recording: after the replay.
        config: that it was made with.
        focal: estimate the focal length too.
        progress: called with a growing number.

    Raises:
        InputError: too few robots were seen.
    """
    seen = sum(1 for frame in recording.frames.values() if len(frame))
    if seen < LEAST_IMAGES:
        raise InputError(
            f"{counted(seen, 'image')} have boxes that may be robots, and a calibration needs "
            f"{LEAST_IMAGES} at least; record a robot that is seen for longer."
        )
    search = Search(recording, focal)
    modes = search.grid(progress)
    if not modes:
        raise InputError(
            "No robot was seen in several images that follow one another closely; record a robot "
            "that is seen for longer, with more images a second."
        )
    fits = search.best(modes)
    best = search.refined(fits[0], search.together)
    extra = search.apart_fit(best)
    if extra is not None:
        best, fits = search.refined(extra, search.apart), [extra]
    return _fit(search, best, fits[1:], extra is not None, config, focal)


def _fit(
    search: Search,
    best: Found,
    rivals: list[Found],
    apart: bool,
    config: EstimatorConfig,
    focal: bool,
) -> Fit:
    delays = [LATENCY, EXTRA] if apart else [LATENCY]
    size = best.evidence.layout.size
    picks = np.eye(size)[delays]
    covariance = best.evidence.covariance(best.state, picks)
    doubts = {}
    for rival in rivals:
        if rival.score > best.score - RIVAL_NATS:
            doubts["latency"] = f"{rival.latency_s:+.2f} s fits nearly as well"
    held = search.apart if apart else search.together
    factors = CAUTION * agreed(search, best, held, delays)
    covariance = covariance * np.outer(factors, factors)
    covariance = covariance + (OF_SAMPLE * search.motion.sample_s) ** 2 * np.eye(len(delays))
    names, mean, whole = _platform(best, delays, covariance, focal)
    mean[0] -= config.camera.latency_s
    state, evidence = best.state, best.evidence
    classes = evidence.names
    speeds = state.strengths[FIRST_ROBOT:]
    return Fit(
        names, mean, whole, state.pixel, len(state.distances),
        int(np.sum(state.distances > HUBER * 1.4)), len(np.unique(best.evidence.boxes.images)),
        classes, excitation(
            evidence.poses(state.unknowns), evidence.boxes.images, evidence.tracks,
            evidence.places(state.unknowns),
        ), tuple(float(one) * 2.0**0.5 for one in speeds), doubts,
        trouble(best, config),
    )  # fmt: skip


def _platform(
    best: Found, delays: list[int], covariance: Array, focal: bool
) -> tuple[tuple[str, ...], Array, Array]:
    """Return names, values and covariance of all constants, delays first."""
    evidence = best.evidence
    strengths = best.state.strengths.copy()
    swims = strengths[FIRST_ROBOT:] > SWIMS_MPS
    strengths[FIRST_ROBOT:][swims] = FREE_MPS
    told = None if best.state.told is None else best.state.told.copy()
    if told is not None:
        told[FIRST_ROBOT:-1][swims] = 0.0
        told[-1] *= not swims.any()
    held = frozenset([LATENCY, EXTRA]) | (frozenset() if focal else frozenset([FOCAL]))
    free: State = replace(best.state, strengths=strengths, told=told)
    free = evidence.descend(free, FREE_STEPS, held, adapt=False)
    layout = evidence.layout
    names = ["height", "gimbal_roll", "gimbal_pitch", "heading"]
    picks = [layout.mean_of(name) for name in CONSTANTS]
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
    found = ["latency", "fix_latency"][: len(delays)] + names
    order = [
        found.index(n)
        for n in (
            "latency",
            "fix_latency",
            "heading",
            "gimbal_pitch",
            "gimbal_roll",
            "height",
            "focal",
        )
        if n in found
    ]
    mean = np.concatenate([best.state.unknowns[delays], table @ free.unknowns])
    return tuple(found[i] for i in order), mean[order], whole[np.ix_(order, order)]


def bound(recording: Recording, latency_s: float, speed_mps: float) -> float:
    """Return the Cramér-Rao bound of the latency's sigma, s, for who knows how robots move.

    Args:
        recording: after the replay.
        latency_s: the true one.
        speed_mps: one sigma of a robot's velocity, each axis.
    """
    search = Search(recording, focal=False)
    linked = search.fine.evidence(latency_s, 0.0)
    if linked is None:
        return float("inf")
    evidence, state = linked.evidence, linked.state
    strengths = state.strengths.copy()
    strengths[FIRST_ROBOT:], strengths[BOX] = speed_mps, 0.05
    pixel = recording.config.noise.value("box_center_px")
    state = replace(state, strengths=strengths, pixel=pixel)
    state = evidence.descend(state, 3, search.together | {LATENCY}, adapt=False)
    state = evidence.evaluated(state, search.together)
    pick = np.eye(1, evidence.layout.size, LATENCY)
    return float(np.sqrt(evidence.covariance(state, pick)[0, 0]))
