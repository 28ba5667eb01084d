# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether drones that see the same robots agree with one another."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.clocks import NO_OFFSET, ClockOffset
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AgreementTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    images: int = 100
    """Images with boxes of shared robots over which residuals are averaged. Judged."""
    least_images: int = 20
    """Least number of them for a verdict. Judged."""
    refused_share: float = 0.2
    """Share of a drone's boxes of shared robots beyond their gate from which it disagrees. By the
    gate's probability it is one in a million. Judged."""
    largest_ratio: float = 2.0
    """Mean normalised squared residual from which a drone disagrees. Judged: with right noise it
    stays within 0.8 to 1.3 of simulated flights."""


TUNING = AgreementTuning()


@dataclass(frozen=True)
class DroneReport:
    """What the fleet says of one drone at one time.

    Attributes:
        drone: its name.
        stamp_ns: of the image, ns.
        agreement: mean normalised squared residual of its boxes of shared robots, a degree of
            freedom; 1 is right, NaN without any.
        shared: number of robots that it and another drone have measured.
        offset: (2,) correction of its receiver less the mean of the others', East, North, m; NaN
            without others.
        offset_sigma: (2,) one sigma of it, m.
        disagrees: whether it contradicts the other drones.
        fault: sensor that has turned out to be wrong: compass, gimbal, receiver or height; "" if
            none has.
        clock: offset of its clock to the others'.
    """

    drone: str
    stamp_ns: int
    agreement: float
    shared: int
    offset: Array
    offset_sigma: Array
    disagrees: bool
    fault: str = ""
    clock: ClockOffset = NO_OFFSET


class Agreement:
    """Residuals of one drone's boxes of robots that another drone sees as well."""

    def __init__(self) -> None:
        self._fits: deque[tuple[float, int]] = deque(maxlen=TUNING.images)
        self._gated: deque[tuple[int, int]] = deque(maxlen=TUNING.images)

    def add(self, squared: float, count: int, refused: int, boxes: int) -> None:
        """Take in an image.

        Args:
            squared: normalised squared residual of the boxes used.
            count: its degrees of freedom.
            refused: number of boxes beyond their gate, of
            boxes: all of shared robots.
        """
        if count:
            self._fits.append((squared, count))
        if boxes:
            self._gated.append((refused, boxes))

    @property
    def ratio(self) -> float:
        """Mean normalised squared residual of a degree of freedom; NaN at first."""
        count = sum(one for _, one in self._fits)
        return sum(one for one, _ in self._fits) / count if count else float("nan")

    @property
    def disagrees(self) -> bool:
        """Whether too many boxes lie beyond their gates, or too far from where others see them."""
        if len(self._fits) >= TUNING.least_images and self.ratio > TUNING.largest_ratio:
            return True
        if len(self._gated) < TUNING.least_images:
            return False
        refused = sum(one for one, _ in self._gated)
        return refused > TUNING.refused_share * sum(one for _, one in self._gated)


def receiver_offset(state: SharedState, drone: int, drones: int) -> tuple[Array, Array]:
    """Return a receiver's correction less the mean of the others' (2,), and one sigma of it, m."""
    if drones < 2:
        return np.full(2, np.nan), np.full(2, np.nan)
    mean, P = state.platforms()
    weights = np.zeros((2, len(mean)))
    for one in range(drones):
        start = COUNT * one + GNSS.start
        weights[:, start : start + 2] = np.eye(2) * (1.0 if one == drone else -1.0 / (drones - 1))
    return weights @ mean, np.sqrt(np.maximum((weights @ P @ weights.T).diagonal(), 0.0))
