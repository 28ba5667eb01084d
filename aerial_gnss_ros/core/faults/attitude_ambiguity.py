# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ambiguity of the camera's attitude while its boxes fit no robot.

Boxes that fit no robot (too fast, or far away) do not update robots. Robots that are initialised
afterwards may be seen by a camera that has turned meanwhile: the covariance D of its angles grows.

A reacquired robot is evidence. If the camera did not turn and the boxes were wrong, its offset d
from the prediction has the covariance S; if it did turn, S + A D A', with A the derivative of
positions by the angles. The ratio of the two likelihoods updates the odds that D applies, from even
odds on, and D itself is updated as by any measurement. This concerns all episodes (`Episode`) since
the robot was last seen: a camera that turned away and back has not turned.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AttitudeAmbiguityTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    turn_rate_radps: float = math.radians(20.0)
    """Turn rate of a camera whose boxes fit no robot, one sigma, each axis, rad/s. Judged."""
    already_s: float = 0.3
    """Time for which a rotation has lasted when it is noticed, s. Judged."""
    back_rad: float = math.radians(3.0)
    """An orientation that jumped is back when it is this close to the expected one, rad. Judged."""
    episodes: int = 4
    """Greatest number of episodes kept apart; earlier ones are merged. Judged."""


TUNING = AttitudeAmbiguityTuning()


@dataclass
class Episode:
    """A period in which the boxes fitted no robot.

    Attributes:
        spread: (3, 3) D, rad².
        odds: log odds that D applies; None: no evidence yet.
        ago: time since it began, s.
        unseen: whether no robot was in view: only the return of the orientation is evidence.
    """

    spread: Array = field(default_factory=lambda: np.zeros((3, 3)))
    odds: float | None = None
    ago: float = 0.0
    unseen: bool = False

    @property
    def covariance(self) -> Array:
        """(3, 3) covariance of the angles, rad²."""
        share = 1.0 if self.odds is None else 0.5 + 0.5 * math.tanh(0.5 * self.odds)
        return share * self.spread if share > EVIDENCE.forgotten else 0.0 * self.spread

    def update_odds(self, nats: float) -> None:
        """Add evidence that D applies, as a log likelihood ratio."""
        self.odds = (self.odds or 0.0) + nats


class AttitudeAmbiguity:
    """Attitude ambiguity of one camera.

    Args:
        most: angle up to which an episode's covariance grows, one sigma, each axis, rad.

    Attributes:
        episodes: the latest ones.
        active: whether there has been an ambiguity.
    """

    def __init__(self, most: float) -> None:
        self._most_s = most / TUNING.turn_rate_radps
        self._earlier: Array = np.zeros((3, 3))  # of times before the episodes
        self.episodes: list[Episode] = []
        self._lasts = self._grown = 0.0
        self._jump, self._jumped_s = np.zeros(3), 0.0
        self._turned = np.zeros(3)
        self._displaced = self._shifted = self._climbed = 0.0
        self.active = False

    @property
    def apart(self) -> float:
        """Isotropic position variance, each axis, after all robots were displaced together, m².

        The cause (rotation, height, zoom or receiver) is unknown, and so is the present direction;
        only the distance is known.
        """
        return self._displaced + self._shifted + self._climbed

    @property
    def covariance(self) -> Array:
        """(3, 3) covariance of the angles, rad²."""
        return sum((one.covariance for one in self.episodes), self._earlier)

    def predict(self, seconds: float, keep: float) -> None:
        """Advance in time.

        Args:
            seconds: length of the step, s.
            keep: factor by which the angle errors decay during the step.
        """
        self._jumped_s += seconds
        self._earlier *= keep * keep
        self._displaced *= keep * keep
        self._climbed *= keep * keep
        for one in self.episodes:
            one.ago += seconds
            one.spread *= keep * keep

    def update(self, seconds: float, over: bool = False) -> None:
        """Update with whether an image's boxes fit robots.

        Args:
            seconds: time since the last image if they fit none, s; 0 if they fit some.
            over: whether those are robots known before the episode, at their predicted positions.
        """
        if not seconds:
            if self._lasts and over and not self.episodes[-1].unseen:
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
        """Record a rotation of the camera that displaced all robots at once.

        Either the camera has turned now, or it had turned before and is right again; so robots may
        be off by as much as they were displaced.

        Args:
            turn: (3,) about the axes of roll, pitch, heading, rad.
            spread: (3, 3) covariance of that, rad².
            squared: greatest squared distance of a robot from its position before the episode, m².
        """
        self._turned = self._turned + turn
        self._lasts = 0.0
        self._displaced = squared
        self.active = True
        if self.episodes:
            self.episodes[-1].spread = np.outer(turn, turn) + spread

    def shifted(self, squared: float) -> None:
        """Take in how far the receiver's place may be from the right one, mean square, m²."""
        self._shifted = squared
        self.active = self.active or squared > 0.0

    def climbed(self, squared: float) -> None:
        """Record the squared distance by which jumps of the height may displace robots, m².

        Either height may be the right one.
        """
        self._climbed = squared
        self.active = self.active or squared > 0.0

    def keep_jump(self, unseen: bool = False) -> None:
        """Record an orientation jump without return that no box has confirmed or refuted.

        Args:
            unseen: whether no robot was in view. Boxes that fit robots are no evidence then: they
                may be displaced ones of others. The return of the orientation is (`update_jump`).
        """
        if self._jump.any():
            self._begin(0.0)
            self.episodes[-1].spread = np.outer(self._jump, self._jump)
            self.episodes[-1].unseen = unseen
            self.active = True

    def note_return(self) -> None:
        """Record that the camera is back in the state before the ambiguity."""
        for one in self.episodes:
            if not one.unseen:
                one.spread = np.zeros((3, 3))
        self._turned = np.zeros(3)
        self._displaced = self._lasts = 0.0

    def update_jump(self, turn: Array, seconds: float) -> bool:
        """Update with a jump of the orientation; return whether it is back.

        Args:
            turn: (3,) about the axes of roll, pitch, heading, rad.
            seconds: time since the previous image, s.
        """
        if not self._jump.any():
            self._jumped_s = seconds
        self._jump = self._jump + turn
        if math.sqrt(self._jump @ self._jump) > TUNING.back_rad:
            return False
        for one in self.episodes:
            # Robots that moved along are handled by `note_displacement`.
            if one.ago <= self._jumped_s + 1e-6 and not self._turned.any():
                one.update_odds(-CLEAR_NATS)
                one.unseen = False
        self._jump = np.zeros(3)
        return True

    def episodes_since(self, unseen: float) -> list[Episode]:
        """Return the episodes for which a robot unseen for a time is evidence.

        Earlier ones also affected the prediction from its last sighting.
        """
        return [
            one
            for one in self.episodes
            if one.ago <= unseen + 1e-6 and one.spread.any() and not one.unseen
        ]

    def update_reacquired(
        self, unseen: float, by_angles: Array, apart: Array, spread: Array
    ) -> None:
        """Update with the offset at which a robot was reacquired.

        Args:
            unseen: time since it was last seen, s.
            by_angles: (2, 3) A, derivative of its position by the platform's angles, m/rad.
            apart: (2,) d, from the prediction, m.
            spread: (2, 2) S, covariance of that if the camera did not turn, m².
        """
        since = self.episodes_since(unseen)
        if not since:
            return
        wide = spread + sum(by_angles @ one.spread @ by_angles.T for one in since)
        # The displacement need not be a rotation. Its square beyond the prediction's variance is an
        # unbiased estimate.
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
    """Return the log of a Gaussian density up to a constant."""
    squared = float(error @ np.linalg.solve(spread, error))
    return -0.5 * (squared + float(np.linalg.slogdet(spread)[1]))
