# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a camera may have turned by itself while no robots explained its boxes.

Boxes that no robots explain (too fast, or elsewhere) do not move the robots. But those that are
found anew may be seen by a camera that has turned meanwhile: the covariance D of its angles grows.

Robots that are found again tell. If the camera did not turn and it was the boxes that were wrong,
such a robot is off where it was expected by d of covariance S; if it did, of S + A D A', with A
the derivative of places by the angles. So much less likely is it, from even odds on, that D
counts, and D itself is narrowed as by any measurement. That is told of all the times (`Episode`)
since the robot was seen: what turned away and back has not turned.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AttitudeAmbiguityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    turn_rate_radps: float = math.radians(20.0)
    """One sigma of the rate at which a camera turns whose boxes no robots explain, each axis,
    rad/s. Judged."""
    negligible_probability: float = 1e-3
    """Probability below which what the camera may have turned does not show in covariances. Adds
    less than 3 % to a sigma."""
    already_s: float = 0.3
    """For so long it has turned when that is noticed, s. Judged."""
    back_rad: float = math.radians(3.0)
    """An orientation that jumped is back so near to where it would be. Judged."""
    was_wrong_nats: float = -3.0
    """Nats: an orientation that jumps and later jumps back was wrong meanwhile, rather than the
    camera has turned just then. Judged."""
    episodes: int = 4
    """Times that are told apart; of those before, all is one. Judged."""


TUNING = AttitudeAmbiguityTuning()


@dataclass
class Episode:
    """A time in which no robots explained the boxes.

    Attributes:
        spread: (3, 3) D, rad².
        odds: logarithm of those that D counts; None: nothing has told yet.
        ago: time since it began, s.
    """

    spread: Array = field(default_factory=lambda: np.zeros((3, 3)))
    odds: float | None = None
    ago: float = 0.0

    @property
    def covariance(self) -> Array:
        """(3, 3) covariance of the angles, rad²."""
        share = 1.0 if self.odds is None else 0.5 + 0.5 * math.tanh(0.5 * self.odds)
        return share * self.spread if share > TUNING.negligible_probability else 0.0 * self.spread

    def update_odds(self, nats: float) -> None:
        """Take in by how much likelier it is that D counts."""
        self.odds = (self.odds or 0.0) + nats


class AttitudeAmbiguity:
    """Of one camera.

    Args:
        most: angle up to which doubt grows, one sigma of each axis, rad.

    Attributes:
        episodes: the last ones.
        active: whether there ever was a doubt.
    """

    def __init__(self, most: float) -> None:
        self._most_s = most / TUNING.turn_rate_radps
        self._earlier: Array = np.zeros((3, 3))  # of times before the episodes
        self.episodes: list[Episode] = []
        self._lasts = self._grown = 0.0
        self._jump, self._jumped_s = np.zeros(3), 0.0
        self._turned = np.zeros(3)
        self._displaced = self._shifted = 0.0
        self.active = False

    @property
    def apart(self) -> float:
        """Variance of each axis of robots that all were elsewhere at once, m².

        What displaced them, a turn, a height, a zoom or a receiver, and so in which direction it
        does by now, is not known: only how far it was.
        """
        return self._displaced + self._shifted

    @property
    def covariance(self) -> Array:
        """(3, 3) covariance of the angles, rad²."""
        return sum((one.covariance for one in self.episodes), self._earlier)

    def predict(self, seconds: float, keep: float) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            keep: factor by which the angles' errors still count after it.
        """
        self._jumped_s += seconds
        self._earlier *= keep * keep
        self._displaced *= keep * keep
        self._shifted *= keep * keep
        for one in self.episodes:
            one.ago += seconds
            one.spread *= keep * keep

    def update(self, seconds: float, over: bool = False) -> None:
        """Take in that for so long no robots explained the boxes, s; 0: some do.

        Args:
            seconds: time since the last image, s.
            over: whether these are robots that were seen before, where they should be.
        """
        if not seconds:
            if self._lasts and over:
                self.episodes[-1].spread = np.zeros((3, 3))
                if not self._turned.any():
                    self._displaced = 0.0
            self._lasts = 0.0
        elif not self._lasts:  # one image may be in error
            self._begin(seconds)
        else:
            self._lasts += seconds
            before, self._grown = self._grown, min(self._lasts, self._most_s)
            grown = TUNING.turn_rate_radps**2 * (self._grown**2 - before**2)
            self.episodes[-1].spread = self.episodes[-1].spread + grown * np.eye(3)
            self.active = True

    def _begin(self, seconds: float) -> None:
        told = [one for one in self.episodes if one.spread.any()]
        if len(told) == TUNING.episodes:
            self._earlier = self._earlier + told.pop(0).covariance
        self.episodes = [*told, Episode(ago=seconds)]
        self._lasts, self._grown = TUNING.already_s + seconds, 0.0

    def note_displacement(self, turn: Array, spread: Array, squared: float) -> None:
        """Take in that all robots are elsewhere, as a turn of the camera would have it.

        Either it has turned now, or it had before and is right again; so robots can be as far off
        as they seem displaced.

        Args:
            turn: (3,) about the axes of roll, pitch, heading, rad.
            spread: (3, 3) covariance of that, rad².
            squared: distance of a robot from where it was before any doubt, the largest, m².
        """
        self._turned = self._turned + turn
        self._lasts = 0.0
        self._displaced = squared
        self.active = True
        if self.episodes:
            self.episodes[-1].spread = np.outer(turn, turn) + spread

    def shifted(self, squared: float) -> None:
        """Take in how far the drone's position is from where it was before it jumped, m².

        Nobody knows which of the two is right.
        """
        self._shifted = squared
        self.active = self.active or squared > 0.0

    def keep_jump(self) -> None:
        """Take in that images count again, while the orientation has jumped and is not back.

        No box could tell meanwhile whether it was the camera.
        """
        if self._jump.any():
            self._begin(0.0)
            self.episodes[-1].spread = np.outer(self._jump, self._jump)
            self.active = True

    def note_return(self) -> None:
        """Take in that the camera is again as it was when nothing was in doubt."""
        for one in self.episodes:
            one.spread = np.zeros((3, 3))
        self._turned = np.zeros(3)
        self._displaced = self._lasts = 0.0

    def update_jump(self, turn: Array, seconds: float) -> bool:
        """Take in that the orientation has jumped; return whether it is back.

        Args:
            turn: (3,) about the axes of roll, pitch, heading, rad.
            seconds: time since the image before, s.
        """
        if not self._jump.any():
            self._jumped_s = seconds
        self._jump = self._jump + turn
        if math.sqrt(self._jump @ self._jump) > TUNING.back_rad:
            return False
        for one in self.episodes:
            # Robots that went along are elsewhere now: `displaced` tells.
            if one.ago <= self._jumped_s + 1e-6 and not self._turned.any():
                one.update_odds(TUNING.was_wrong_nats)
        self._jump = np.zeros(3)
        return True

    def episodes_since(self, unseen: float) -> list[Episode]:
        """Return the times of which a robot tells that is found after so long, s.

        Of those before it was last seen it tells nothing: that was by the same camera.
        """
        return [one for one in self.episodes if one.ago <= unseen + 1e-6 and one.spread.any()]

    def update_reacquired(
        self, unseen: float, by_angles: Array, apart: Array, spread: Array
    ) -> None:
        """Take in where a robot was found again.

        Args:
            unseen: time since it was seen before, s.
            by_angles: (2, 3) A, how its place moves with the platform's angles, m/rad.
            apart: (2,) d, from where it was expected, m.
            spread: (2, 2) S, covariance of that if the camera did not turn, m².
        """
        since = self.episodes_since(unseen)
        if not since:
            return
        wide = spread + sum(by_angles @ one.spread @ by_angles.T for one in since)
        # Something contradicted the robots, be it of a size that no turn would have. What is more
        # than the robot can have swum is an estimate of it without bias.
        beyond = float(apart @ apart) - float(np.trace(spread))
        self._displaced = max(self._displaced, beyond)
        less = _log_density(apart, wide) - _log_density(apart, spread)
        for one in since:
            with_it = one.spread @ by_angles.T
            gain = np.linalg.solve(wide, with_it.T).T
            told = gain @ apart
            one.update_odds(less)
            one.spread = one.spread - gain @ with_it.T + np.outer(told, told)


def _log_density(error: Array, spread: Array) -> float:
    """Return the logarithm of a normal density but for a constant."""
    squared = float(error @ np.linalg.solve(spread, error))
    return -0.5 * (squared + float(np.linalg.slogdet(spread)[1]))
