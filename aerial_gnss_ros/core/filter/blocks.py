# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots in blocks that share one covariance with the platform, addressed by row.

The joint covariance of `TUNING.block_robots` robots and the platform is kept in full, at cubic
cost. Further robots are kept in further blocks, each with its own copy of the platform's errors. No
block uses another's measurements, so that nothing counts twice; only the small contribution of
further robots to the platform's errors is lost. The cost is linear in the number of robots.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.rotation_fault import RotationFault
from aerial_gnss_ros.core.filter.linearization import by_angles
from aerial_gnss_ros.core.filter.plausible_state import check_covariance, check_robots
from aerial_gnss_ros.core.filter.state import JointState, copy_robot, inverse_of_errors
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.platform_model import COUNT

Array = NDArray[np.float64]
Turned = Callable[[Array, Array], dict[int, Array]]


@dataclass(frozen=True)
class BlocksTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    block_robots: int = 32
    """Robots of one block. More cost more than they add about the platform."""
    same_place_m: float = 0.1
    """Position difference of a robot and the track that it continues, one sigma, m. Judged."""


TUNING = BlocksTuning()


class StateBlocks:
    """Robots in rows 0 to n - 1, and the platform's errors.

    Attributes:
        rotation_fault: test for a rotating camera.
        ambiguity: possible rotation of the camera while no robots explained its boxes.
    """

    _groups: list[JointState]
    _count: int

    def clear(self, platform: Array) -> None:
        """Start without robots.

        Args:
            platform: (9, 9) covariance of the platform's errors.
        """
        self.rotation_fault = RotationFault()
        self.ambiguity = self.rotation_fault.ambiguity
        self._groups = [JointState(platform, self.rotation_fault)]
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def groups(self) -> list[JointState]:
        """The joint states."""
        return self._groups

    def restore(self, groups: list[JointState]) -> None:
        """Restore earlier joint states."""
        self.rotation_fault = groups[0].rotation_fault
        self.rotation_fault.ambiguity = self.ambiguity
        self._groups = groups
        self._count = sum(len(group) for group in groups)

    @property
    def platform(self) -> tuple[Array, Array]:
        """The platform's errors (9,) and their covariance (9, 9)."""
        first = self._groups[0]
        return first.mean[:COUNT].copy(), first.covariance[:COUNT, :COUNT].copy()

    def moments(self) -> tuple[Array, Array]:
        """Return means (n, 4) and covariances (n, 4, 4) of robots, the platform's share included.

        East, north, velocity east, velocity north; m, m/s.
        """
        mean, covariance = np.empty((self._count, 4)), np.empty((self._count, 4, 4))
        for group in self._groups:
            n, own = len(group.rows), group.covariance[COUNT:, COUNT:]
            robots = group.mean[COUNT:].reshape(n, 4)
            blocks = own.reshape(n, 4, n, 4).diagonal(axis1=0, axis2=2).transpose(2, 0, 1)
            if n == self._count:  # its rows are all, in order
                return robots.copy(), blocks.copy()
            mean[group.rows], covariance[group.rows] = robots, blocks
        return mean, covariance

    def given_platform(self) -> Array:
        """Return covariances (n, 2, 2) of the robots' positions given the platform's errors, m²."""
        found = np.empty((self._count, 2, 2))
        for group in self._groups:
            _, own, through = group.positions()
            inverse = inverse_of_errors(group.covariance[:COUNT, :COUNT])
            found[group.rows] = own - through @ inverse @ through.swapaxes(1, 2)
        return found

    def check(self) -> None:
        """Check that the state is plausible.

        Raises:
            StateError: a number is not finite, a covariance invalid, or a robot out of bounds.
        """
        for group in self._groups:
            check_covariance(group.covariance, "robots and platform")
            check_robots(group.mean[COUNT:].reshape(-1, 4), "robots")

    def add_fault_covariances(self, covariance: Array, turned: Turned | None = None) -> None:
        """Inflate covariances (n, 4, 4) of all robots by a possible rotation of the camera.

        Args:
            covariance: of the robots, changed in place.
            turned: returns what it leaves uncertain of robots (2, 2), by row, from derivatives by
                the angles (n, 2, 3) and the covariance of these (3, 3).
        """
        if self.rotation_fault.doubted or self.ambiguity.active:
            less = (
                {} if turned is None else turned(self._by_angles(), self.rotation_fault.covariance)
            )
            for group in self._groups:
                places = group.velocity_changes.position_covariances.copy()
                for slot in np.flatnonzero(group.unseen == 0.0).tolist() if less else ():
                    left = less.get(int(group.rows[slot]), places[slot])
                    left = left + self.ambiguity.apart * np.eye(2)
                    if np.trace(left) < np.trace(places[slot]):
                        places[slot] = left
                covariance[group.rows, :2, :2] += places
                covariance[group.rows, 2:, 2:] += group.velocity_changes.velocity_covariances

    def _by_angles(self) -> Array:
        """Return derivatives (n, 2, 3) of all robots' positions by the platform's angles, m/rad."""
        found = np.zeros((self._count, 2, 3))
        for group in self._groups:
            found[group.rows] = by_angles(group, np.arange(len(group)))
        return found

    def allocate(self, columns: Indices) -> Iterator[tuple[JointState, Indices, Indices]]:
        """Allocate rows for robots after the present ones.

        Args:
            columns: (m,) of their first detections.

        Yields:
            Groups with free slots, each with the new rows and their columns.
        """
        left = columns
        while len(left):
            group = next((one for one in self._groups if len(one) < TUNING.block_robots), None)
            if group is None:
                group = self._another_group()
            now, left = (
                left[: TUNING.block_robots - len(group)],
                left[TUNING.block_robots - len(group) :],
            )
            rows = np.arange(self._count, self._count + len(now))
            self._count += len(now)
            yield group, rows, now

    def inflate_velocities(self, rows: Indices, speed: Array | float, seconds: float) -> None:
        """Inflate velocity covariances of robots (`JointState.inflate_velocities`)."""
        if not len(rows):
            return
        speeds = np.full(self._count, np.nan)
        speeds[rows] = speed
        for group in self._groups:
            slots = np.flatnonzero(~np.isnan(speeds[group.rows]))
            if len(slots):
                group.inflate_velocities(slots, speeds[group.rows[slots]], seconds)

    def merge(self, old: int, new: int, told: bool = True) -> None:
        """Merge robot `old` into `new`, as which it was re-identified.

        Args:
            old: its row.
            new: likewise.
            told: whether its position is evidence on the camera's rotation.
        """
        group_of, slot_of = self._places_of_rows()
        before, group = self._groups[group_of[old]], self._groups[group_of[new]]
        first, second = int(slot_of[old]), int(slot_of[new])
        if self.ambiguity.active:
            apart, spread = self.separations(np.array([old]), np.array([new]))
            slots = np.array([second])
            moved, unseen = by_angles(group, slots), float(before.unseen[first])
            if told:
                self.ambiguity.update_reacquired(unseen, moved[0], apart[0, 0], spread[0, 0])
            self.rotation_fault.spread(group.velocity_changes, slots, moved)
        if before is group:
            fits = group.tie(first, second, TUNING.same_place_m)
            self._joined(group, first, second, fits)
            return
        # The old robot temporarily joins the new one's group, so that its history is used.
        guest = copy_robot(before, first, group)
        group.tie(guest, second, TUNING.same_place_m)
        group.drop(np.array([guest]))

    def _joined(self, group: JointState, first: int, second: int, fits: float) -> None:
        """Let other laws take in that two robots of a group are one, if there are any."""

    def update_reacquired(self, rows: Indices, offsets: Array, spread: Array) -> None:
        """Update with boxes of reacquired robots, after images that no robots explained.

        Args:
            rows: (m,) the robots, not yet corrected by these boxes.
            offsets: (m, 2) from their predicted positions, m.
            spread: (m, 2, 2) covariances of that, m².
        """
        if not self.ambiguity.active:
            return
        group_of, slot_of = self._places_of_rows()
        for row, apart, covariance in zip(rows.tolist(), offsets, spread, strict=True):
            group, slot = self._groups[group_of[row]], slot_of[row : row + 1]
            unseen = float(group.unseen[slot[0]])
            if self.ambiguity.episodes_since(unseen):
                self.ambiguity.update_reacquired(
                    unseen, by_angles(group, slot)[0], apart, covariance
                )

    def drop(self, rows: Indices) -> None:
        """Remove robots; later rows move up."""
        kept = np.ones(self._count, dtype=np.bool_)
        kept[rows] = False
        moved = np.cumsum(kept) - 1
        for group in self._groups:
            gone = np.flatnonzero(~kept[group.rows])
            if len(gone):
                group.drop(gone)
            group.rows = moved[group.rows]
        self._groups = [self._groups[0], *(one for one in self._groups[1:] if len(one))]
        self._count = int(kept.sum())

    def separations(self, old: Indices, new: Indices) -> tuple[Array, Array]:
        """Return offsets (n, m, 2) from robots `old` to robots `new`, and their covariances."""
        group_of, slot_of = self._places_of_rows()
        mean, covariance = self.moments()
        mean, covariance = mean[:, :2], covariance[:, :2, :2]
        offsets = mean[new][None] - mean[old][:, None]
        spread = covariance[old][:, None] + covariance[new][None]
        for i, a in enumerate(old):
            for j, b in enumerate(new):
                if group_of[a] == group_of[b]:
                    shared = _shared(self._groups[group_of[a]], slot_of[a], slot_of[b])
                    spread[i, j] -= shared + shared.T
        return offsets, spread

    def _another_group(self) -> JointState:
        first = self._groups[0]
        group = JointState(first.covariance[:COUNT, :COUNT], self.rotation_fault)
        group.mean[:] = first.mean[:COUNT]
        self._groups.append(group)
        return group

    def _places_of_rows(self) -> tuple[Indices, Indices]:
        group_of = np.zeros(self._count, np.intp)
        slot_of = np.zeros(self._count, np.intp)
        for number, group in enumerate(self._groups):
            group_of[group.rows] = number
            slot_of[group.rows] = np.arange(len(group))
        return group_of, slot_of


def _shared(group: JointState, a: int, b: int) -> Array:
    """Return the covariance (2, 2) of one robot's position with another's."""
    i, j = COUNT + 4 * a, COUNT + 4 * b
    return group.covariance[i : i + 2, j : j + 2]
