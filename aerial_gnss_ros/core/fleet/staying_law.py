# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A law of all drones' errors and robots in which some robots stay (see `moored_law`).

Another drone's errors are not part of the active `JointState`. So what conditions robots, lets them
go or adds one passes on to these errors here, by the same linear maps.
"""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.moored_law import CURRENT, TUNING, MooredLaw, given_errors
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.state import JointState, inverse_of_errors
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel

Array = NDArray[np.float64]


class StayingState(SharedState):
    """Errors of all drones, and robots of which some stay.

    Args:
        swimming: the state in which all swim, at the beginning.
        law: its active part, in which robots may stay.
    """

    def __init__(self, swimming: SharedState, law: MooredLaw) -> None:
        vars(self).update(
            {name: copy.deepcopy(own) for name, own in vars(swimming).items() if name != "joint"}
        )
        more = len(law) - len(swimming.joint)
        self.joint = law
        self.appended(np.zeros((4 * more, self._cross.shape[1])))

    def stay(self, slot: int, current: int) -> None:
        """Pass on that a robot has the current's velocity, before `joint` is told so."""
        v, c = _velocity(slot), _velocity(current)
        P = self.joint.covariance
        rows, by_others = P[v] - P[c], self._cross[v] - self._cross[c]
        spread = rows[:, v] - rows[:, c] + TUNING.apart_mps**2 * np.eye(2)
        gain = np.linalg.solve(spread, by_others)
        self._mean = self._mean - (self.joint.mean[v] - self.joint.mean[c]) @ gain
        self._cross = self._cross - rows.T @ gain
        self._own = self._own - by_others.T @ gain
        self._cross[v] = 0.0
        self._by_pose[slot, 2:] = 0.0

    def swim(self, slot: int, current: int) -> None:
        """Pass on that a robot swims after all."""
        v, c = _velocity(slot), _velocity(current)
        self._cross[v - 2] += self._cross[v]
        self._cross[v] = self._cross[c]

    def take(self, swimming: SharedState, slot: int) -> None:
        """Add a robot of the state in which all swim: its distribution given all drones' errors."""
        mean, P = swimming.ordered()
        errors = np.arange(len(mean) - 4 * len(swimming.joint))
        own = errors.size + 4 * slot + np.arange(4)
        by_errors = P[np.ix_(own, errors)] @ inverse_of_errors(P[np.ix_(errors, errors)])
        given = P[np.ix_(own, own)] - by_errors @ P[np.ix_(errors, own)]
        law = self.joint
        size, (here, whole, order) = len(law.mean), self.whole()
        firsts = [0, *(size + COUNT * k for k in range(len(order) - 1))]
        places = [firsts[order.index(one)] + np.arange(COUNT) for one in sorted(order)]
        there = np.concatenate(places)
        state = mean[own] + by_errors @ (here[there] - mean[errors])
        cross = by_errors @ whole[there]
        spread = cross[:, there] @ by_errors.T + given
        source = swimming.joint
        row = source.rows[[slot]]
        law.append(row, state[None], np.zeros((1, 4, COUNT)), 0.5 * (spread + spread.T)[None])
        law.covariance[size:, :size] = cross[:, :size]
        law.covariance[:size, size:] = cross[:, :size].T
        self.appended(cross[:, size:])
        law.unseen[-1], law.own[:, -1] = source.unseen[slot], source.own[:, slot]
        law.ids[-1] = source.ids[slot]
        law.manoeuvre_noise.copy(source.manoeuvre_noise, slot)
        law.velocity_changes.copy(source.velocity_changes, slot)
        self.inherit(swimming, slot)

    def known_errors(self) -> tuple[Array, Array]:
        """Return robots' covariance with all drones' errors (4 n, 9 N), and that of these."""
        with_active = self.joint.covariance[COUNT:, :COUNT]
        return np.concatenate([with_active, self._cross[COUNT:]], axis=1), self._errors()


class StayingLaw(MooredLaw):
    """The active part of a `StayingState`.

    Attributes:
        swimming: the state in which all swim.
        shared: the state of which this is the active part.
    """

    swimming: SharedState
    shared: StayingState

    @classmethod
    def beside(cls, swimming: SharedState) -> StayingLaw:
        """Return a law beside the one in which all swim; no robot stays yet."""
        law = cls.of(swimming.joint, adrift=False)
        assert isinstance(law, StayingLaw)  # noqa: S101 - `of` makes one of its class
        law.swimming, law.shared = swimming, StayingState(swimming, law)
        return law

    @property
    def unsure(self) -> float:
        """Variance of robots' places, each axis, if all drones were known, m²."""
        (own,) = np.nonzero(self.ids != CURRENT)
        return 0.5 * float(np.trace(self.own_covariances(own), axis1=1, axis2=2).mean())

    def fit(
        self, slots: Indices, pixels: Array, view: CameraView, model: PlatformModel, level: float
    ) -> Outcome:
        """Update robots with pixels of the active drone's image (see `MooredLaw`)."""
        return self.shared.correct(slots, pixels, view, model, np.inf, level)

    def take(self, base: JointState, slot: int) -> None:
        """Take in a robot of the law that lets all swim."""
        assert base is self.swimming.joint  # noqa: S101 - there is no other
        self.shared.take(self.swimming, slot)
        self.sway[-1] = 0.0

    def drop(self, slots: Indices) -> None:
        """Forget robots (see `JointState`)."""
        kept = np.ones(len(self), dtype=np.bool_)
        kept[slots] = False
        super().drop(slots)
        self.shared.dropped(kept)

    def moor(self, slot: int) -> None:
        """Take in that a robot stays, and swings."""
        self.shared.stay(slot, self.current)
        super().moor(slot)

    def release(self, slot: int, state: Array, covariance: Array) -> None:
        """Take in that a robot swims after all (see `MooredLaw`)."""
        self.shared.swim(slot, self.current)
        super().release(slot, state, covariance)

    def own_covariances(self, slots: Indices) -> Array:
        """Return covariances (m, 2, 2) of where robots are seen if all drones were known, m²."""
        with_errors, errors = self.shared.known_errors()
        states = with_errors.reshape(len(self), 4, -1)[slots]
        sway = self.sway[slots, None, None]
        blocks = self.blocks()[slots]
        rows = blocks[:, :2] + sway * blocks[:, 2:]
        own = rows[:, :, :2] + sway * rows[:, :, 2:]
        return given_errors(own, states[:, :2] + sway * states[:, 2:], errors)

    def jointly_published(self) -> tuple[Array, Array]:
        """Return all that is published (9 N + 4 n,), all drones' errors first, and its covariance.

        See `MooredLaw`.
        """
        mean, covariance = self.shared.ordered()
        n, first = len(self), len(mean) - 4 * len(self)
        self.put_published(mean, covariance, first)
        blocks = covariance[first:, first:].reshape(n, 4, n, 4)
        every = np.arange(n)
        blocks[every, :, every] = self.published()[1]
        return mean, covariance


def _velocity(slot: int) -> Indices:
    """Return where in the active part a robot's velocity is (2,)."""
    places: Indices = COUNT + 4 * slot + np.array([2, 3])
    return places
