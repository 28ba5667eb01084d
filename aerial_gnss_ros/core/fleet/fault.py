# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What may be wrong with a drone, and how much the filter's own state says for it.

A drone states how large its errors are. A fault is an error of one of its sensors that is far
larger. Which one explains the data is a comparison of marginal likelihoods: a Gaussian posterior
tells how probable all measurements are if some components of its prior had another variance, so no
second filter is needed (a Savage-Dickey ratio).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.evidence import UNCLEAR
from aerial_gnss_ros.core.models.platform_model import COUNT, PLATFORM

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FaultTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    probability: float = 0.01
    """Prior probability that a certain sensor of a drone is faulty. Judged."""
    sure: float = 0.99
    """Probability that a drone is the wrong one, given that one is, from which it is said to be:
    blaming another one is worse than blaming none. Judged."""
    probably: float = 0.8
    """Probability that one of the drones is wrong from which all that may be it disagree, which
    blames none: where all is as stated, two compasses differ so much once in 2000 flights (3.5
    sigmas). Judged."""
    turned: float = 0.03
    """The same as `probability` of a compass that is turned: by iron, or for want of the
    declination, it fails more often than anything else. Judged."""
    turned_rad: float = math.radians(15.0)
    """One sigma of such a compass, rad. Judged."""
    compass_rad: float = math.radians(60.0)
    """One sigma of a compass that shows any direction, rad. Judged."""
    gimbal_rad: float = math.radians(10.0)
    """One sigma of a faulty roll or pitch, rad. Judged."""
    receiver_m: float = 20.0
    """One sigma of a faulty receiver, each axis, m. Judged."""
    height_m: float = 5.0
    """One sigma of a faulty height, m. Judged."""


TUNING = FaultTuning()


@dataclass(frozen=True)
class Fault:
    """A sensor that is wrong.

    Attributes:
        sensor: its name.
        errors: which of `PLATFORM` it makes larger.
        sigma: one sigma of them, m or rad.
        probability: before any data.
    """

    sensor: str
    errors: tuple[str, ...]
    sigma: float
    probability: float = TUNING.probability

    @property
    def columns(self) -> list[int]:
        """Their places in `PLATFORM`."""
        return [PLATFORM.index(name) for name in self.errors]

    @property
    def variances(self) -> Array:
        """(9,) variances that it adds to those that the drone states."""
        found = np.zeros(COUNT)
        found[self.columns] = self.sigma**2
        return found


FAULTS = (
    Fault("compass", ("heading",), TUNING.compass_rad),
    Fault("gimbal", ("roll", "pitch"), TUNING.gimbal_rad),
    Fault("receiver", ("gnss_east", "gnss_north"), TUNING.receiver_m),
    Fault("height", ("height",), TUNING.height_m),
    Fault("compass", ("heading",), TUNING.turned_rad, TUNING.turned),
)


@dataclass(frozen=True)
class Suspicion:
    """A fault of a drone.

    Attributes:
        drone: its number.
        fault: of it.
        log_ratio: log of the marginal likelihood ratio of the fault to none, nats.
    """

    drone: int
    fault: Fault
    log_ratio: float

    @property
    def weight(self) -> float:
        """Log of its probability, but for a constant, nats."""
        return math.log(self.fault.probability) + self.log_ratio


def probabilities(suspicions: list[Suspicion]) -> list[float]:
    """Return the probability of each of some faults of which at most one is real."""
    none = max(1.0 - sum(one.fault.probability for one in suspicions), TUNING.probability)
    logs = [math.log(none), *(one.weight for one in suspicions)]
    weights = np.exp(np.array(logs) - max(logs))
    found: list[float] = (weights / weights.sum())[1:].tolist()
    return found


def culprit(suspicions: list[Suspicion]) -> Suspicion | None:
    """Return the likeliest fault of the drone that is surely wrong; None if none surely is."""
    suspected = suspects(suspicions)
    if len(suspected) != 1:
        return None
    return max((one for one in suspicions if one.drone in suspected), key=lambda one: one.weight)


def suspects(suspicions: list[Suspicion], least: float = 1.0 - UNCLEAR) -> set[int]:
    """Return the drones of which one is wrong; none if it may be that none is.

    Drones that are surely not the wrong one are left out.

    Args:
        suspicions: of all drones.
        least: probability from which one is.
    """
    share: dict[int, float] = {}
    for one, probability in zip(suspicions, probabilities(suspicions), strict=True):
        share[one.drone] = share.get(one.drone, 0.0) + probability
    wrong = sum(share.values())
    if wrong < least:
        return set()
    surely = {drone for drone, one in share.items() if one >= TUNING.sure * wrong}
    return surely or {drone for drone, one in share.items() if one > (1.0 - TUNING.sure) * wrong}


def suspicions(state: SharedState, stationary: list[Array]) -> list[Suspicion]:
    """Return how much the filter's state says for each fault of each drone.

    Args:
        state: the filter.
        stationary: (9, 9) covariance of each drone's errors that it used.
    """
    mean, covariance = state.platforms()
    prior = state.prior(stationary)
    return [
        Suspicion(
            drone, fault,
            log_ratio(mean, covariance, prior, [COUNT * drone + k for k in fault.columns],
                      fault.sigma**2),
        )
        for drone in range(len(stationary))
        for fault in FAULTS
        if prior[COUNT * drone + fault.columns[0], COUNT * drone + fault.columns[0]] > 0.0
    ]  # fmt: skip


def log_ratio(
    mean: Array, covariance: Array, prior: Array, columns: list[int], more: float
) -> float:
    """Return the log marginal likelihood ratio of another prior to the one that was used, nats.

    With e ~ N(0, P0) the data gave N(m, P). If some of e had a further offset b ~ N(0, v I), the
    likelihood of b has the score s = P0⁻¹ m and the information J = P0⁻¹ - P0⁻¹ P P0⁻¹, both
    restricted to these, and the ratio is |I + v J|^(-1/2) exp(s' (I / v + J)⁻¹ s / 2).

    Args:
        mean: (d,) m.
        covariance: (d, d) P.
        prior: (d, d) P0.
        columns: places of b.
        more: v; negative: what a prior without that part would give.
    """
    scale = np.sqrt(prior.diagonal())
    known = np.flatnonzero(scale > 0.0)
    scale, places = scale[known], np.searchsorted(known, columns)
    each = np.outer(scale, scale)
    weak = 1e-6 * np.eye(len(known))  # receivers that have everything in common
    inverse = np.linalg.inv(prior[np.ix_(known, known)] / each + weak)
    P = covariance[np.ix_(known, known)] / each + weak
    score = (inverse @ (mean[known] / scale))[places]
    J = (inverse - inverse @ P @ inverse)[np.ix_(places, places)]
    values, vectors = np.linalg.eigh(J)
    J = (vectors * np.maximum(values, 0.0)) @ vectors.T
    score = vectors @ (
        vectors.T @ score * (values > 0.0)
    )  # what nothing was measured of says nothing
    variances = np.diag(more / np.square(scale[places]))
    M = np.eye(len(places)) + variances @ J
    sign, log_determinant = np.linalg.slogdet(M)
    if sign <= 0.0:  # the data tell less than the part that would be missing
        return 0.0
    return 0.5 * float(score @ np.linalg.solve(M, variances @ score)) - 0.5 * float(log_determinant)
