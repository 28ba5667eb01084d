# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots of a fleet stay: a law in which some do, beside the one in which all swim.

As for one drone (`moored`), both laws take in each image, and what is published has the moments of
both, weighed by their evidence. That robots drift with a current is not asked: a drift and the
difference of the drones' clocks displace robots alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored import MooredHypothesis
from aerial_gnss_ros.core.filter.moored_law import TUNING as LAW
from aerial_gnss_ros.core.filter.moored_law import MooredLaw
from aerial_gnss_ros.core.filter.moored_mixture import TUNING as MIXTURE
from aerial_gnss_ros.core.filter.moored_mixture import MooredGroup
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.staying_law import StayingLaw
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StayingTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    swing_sigmas: float = 1.25
    """Least swing, and that at first, in sigmas by which boxes leave a robot's place uncertain if
    all drones were known. Much more would speak against the law before it is found to be less; with
    none, of robots on watch circles of 3 to 10 cm 4 % of the positions are beyond chi-square 13.8.
    """
    shows_s: float = 10.0
    """For how long after its last box of a robot a drone counts as one that shows it, s: much less
    than the time in which errors of a drone could look like a robot's drift. Judged."""


TUNING = StayingTuning()


class _Hypothesis(MooredHypothesis):
    """That some robots of a state stay."""

    def __init__(self, state: SharedState) -> None:
        self._state = state
        self._shown_s: dict[tuple[int, int], float] = {}  # when, by number of robot and drone
        super().__init__(state.joint, adrift=False)

    def update(
        self, outcome: Outcome, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        latest, shown = self._now_s - TUNING.shows_s, self.base.ids[outcome.slots].tolist()
        self._shown_s = {one: at for one, at in self._shown_s.items() if at >= latest}
        self._shown_s |= {(robot, self._state.active): self._now_s for robot in shown}
        super().update(outcome, pixels, view, model, level)

    def _stay(self, law: MooredLaw) -> int:
        """Return how many robots stay; one that several drones show counts as several.

        The drift of a single robot may be an error of the platform, but hardly of two at once.
        """
        stay = law.ids[law.sway > 0.0].tolist()
        return max(len(stay), sum(robot in stay for robot, _ in self._shown_s))

    def _begin(self) -> MooredLaw:
        law = StayingLaw.beside(self._state)
        self._least_variance = TUNING.swing_sigmas**2 * law.unsure
        law.variance = min(self._least_variance, LAW.first_sway_m**2)
        return law

    def _move(
        self, law: MooredLaw, seconds: float, keep: Array, stationary: Array, motion: MotionModel
    ) -> None:
        assert isinstance(law, StayingLaw)  # noqa: S101 - `_begin` made it
        law.shared.predict(seconds, [*keep], [*stationary], motion)


class StayingRobots(MooredGroup):
    """Weighs whether robots stay.

    Args:
        state: in which all swim.
    """

    def __init__(self, state: SharedState) -> None:
        self.base = state.joint
        self._one = _Hypothesis(state)
        self.both = [self._one]

    @property
    def law(self) -> StayingLaw | None:
        """The law in which some stay; None where none is tried."""
        law = self._one.law
        assert law is None or isinstance(law, StayingLaw)  # noqa: S101 - see `_Hypothesis`
        return law

    def reset(self) -> None:
        """Give it up: the state was changed by what was no image."""
        self._one.reset()

    def predict(
        self, seconds: float, keep: list[Array], stationary: list[Array], motion: MotionModel
    ) -> None:
        """Move on in time, before the state does (see `SharedState.predict`)."""
        self._one.predict(seconds, np.array(keep), np.array(stationary), motion)

    def look(self, drone: int, view: CameraView) -> None:
        """Take in the pose of a drone's image (see `SharedState.look`)."""
        if self.law is not None:
            self.law.shared.look(drone, view)

    def settle(self) -> None:
        """Bring robots back to the fleet's time (see `SharedState.settle`)."""
        if self.law is not None:
            self.law.shared.settle()

    def tie(self, first: int, second: int, sigma: float) -> None:
        """Take in that two robots of the state are one; see `DroneBlocks.tie`."""
        if self.law is None:
            return
        places = self._one.places()
        if min(places[first], places[second]) >= 0:
            self.law.shared.tie(int(places[first]), int(places[second]), sigma)

    def update(
        self, outcome: Outcome, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> None:
        """Take in an image that the state has taken in already (see `MooredHypothesis`)."""
        self._one.update(outcome, pixels, view, model, level)
        if self._one.law is not None:
            self._one.evidence = min(self._one.evidence, MIXTURE.swimming_behind_nats)
