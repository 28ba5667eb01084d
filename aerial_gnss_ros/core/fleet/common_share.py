# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much receivers have in common, as far as the drones' data tell.

The filter assumes one share of the receivers' variance that is common. How far the estimated
offsets of the drones lie apart makes other shares more or less probable. Under each of these, the
posterior of the offsets follows from that of the filter, as only their prior differs, and all else
follows from the offsets by regression. What is published is the mean of the mixture over the
shares, with its covariance; the filter itself goes on with the one that it assumes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS
from aerial_gnss_ros.core.references.position_law import PositionLaw

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CommonShareTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    count: int = 8
    """Number of shares that are weighed. Judged: twice as many change positions by millimetres."""
    largest: float = 0.98
    """Greatest share that is weighed: multipath is each receiver's own. Judged."""


TUNING = CommonShareTuning()


class CommonShare:
    """Weighs shares of the receivers' variance that is common.

    Args:
        share: that the filter assumes, 0 to 1, and the mean of the prior: a beta distribution that
            is uniform at 0.5 and gets narrower towards 0 and 1, which are taken to be certain.
    """

    def __init__(self, share: float) -> None:
        self.share = share
        self.shares = np.zeros(0)
        self._stated = b""
        self._priors = np.zeros(0), np.zeros(0), np.zeros(0)
        if 0.0 < share < 1.0:
            from scipy.special import betaincinv  # takes long to import, and only fleets need it

            middles = (np.arange(TUNING.count) + 0.5) / TUNING.count
            equally = betaincinv(2.0 * share, 2.0 - 2.0 * share, middles)
            self.shares = np.minimum(equally, TUNING.largest)

    def weights(self, law: PositionLaw, stationary: Sequence[Array]) -> Array:
        """Return the probabilities of `shares`.

        Args:
            law: what the filter, which assumes `share`, knows of all drones' errors.
            stationary: (9, 9) prior covariance of each drone's errors.
        """
        return self._mixture(law, stationary)[0]

    def weighed(self, law: PositionLaw, stationary: Sequence[Array]) -> PositionLaw:
        """Return mean and covariance of the mixture over all shares.

        Args:
            law: what the filter, which assumes `share`, knows of all drones' errors and of robots.
            stationary: (9, 9) prior covariance of each drone's errors.
        """
        exact = any(one[axis, axis] <= 0.0 for one in stationary for axis in (0, 1))
        if not len(self.shares) or len(stationary) < 2 or exact:
            return law
        weights, means, spreads = self._mixture(law, stationary)
        own = law.receivers
        mean = weights @ means
        apart = means - mean
        spread = np.einsum("k,kij->ij", weights, spreads) + (weights * apart.T) @ apart
        before = law.covariance[np.ix_(own, own)]
        by_receivers = np.linalg.solve(before, law.covariance[own]).T
        return PositionLaw(
            law.rows,
            law.mean + by_receivers @ (mean - law.mean[own]),
            law.covariance + by_receivers @ (spread - before) @ by_receivers.T,
        )

    def _mixture(self, law: PositionLaw, stationary: Sequence[Array]) -> tuple[Array, Array, Array]:
        """Return probabilities (k,), means (k, 2 N) and covariances of the receivers' offsets.

        With e ~ N(0, P0) the data gave N(m, P), so their likelihood of e has the information
        J = P⁻¹ - P0⁻¹ and the vector P⁻¹ m. Another prior P1 gives the covariance (J + P1⁻¹)⁻¹.
        """
        own = law.receivers
        scale, inverses, sizes = self._priors_of(stationary)
        each = np.outer(scale, scale)
        known = np.linalg.inv(law.covariance[np.ix_(own, own)] / each)
        values, vectors = np.linalg.eigh(known - inverses[0])
        told = (vectors * np.maximum(values, 0.0)) @ vectors.T
        toward = known @ (law.mean[own] / scale)
        spreads = np.linalg.inv(told + inverses[1:])
        means = spreads @ toward
        logs = 0.5 * (np.linalg.slogdet(spreads)[1] - sizes + means @ toward)
        weights = np.exp(logs - logs.max())
        return weights / weights.sum(), means * scale, spreads * each

    def _priors_of(self, stationary: Sequence[Array]) -> tuple[Array, Array, Array]:
        """Return sigmas of the receivers' offsets, inverse priors in these units, log determinants.

        The first inverse is that of the share which the filter assumes; it has no determinant.
        They are made anew only where a receiver states something else.
        """
        stated = b"".join(one[GNSS, GNSS].tobytes() for one in stationary)
        if stated != self._stated:
            firsts = COUNT * np.arange(len(stationary))[:, None]
            places = (firsts + np.arange(GNSS.start, GNSS.stop)).ravel()
            priors = np.array(
                [joint_prior([*stationary], one)[np.ix_(places, places)]
                 for one in (self.share, *self.shares)]
            )  # fmt: skip
            scale = np.sqrt(priors[0].diagonal())
            priors /= np.outer(scale, scale)
            sizes = np.linalg.slogdet(priors[1:])[1]
            self._stated, self._priors = stated, (scale, np.linalg.inv(priors), sizes)
        return self._priors
