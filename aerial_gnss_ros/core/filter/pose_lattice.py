# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measured camera poses at multiples of a time step, smoothed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.map_pose import MapPose

Array = NDArray[np.float64]

STEP_S = 0.1
STEP_NS = 100_000_000

WEIGHTS = np.array([-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0]) / 21.0
MARGIN = len(WEIGHTS) // 2


@dataclass(frozen=True)
class PoseLatticeTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_jumps: int = 64
    """Number of jumps that are kept. Judged."""


TUNING = PoseLatticeTuning()


@dataclass(frozen=True)
class SampledPose(MapPose):
    """A pose between samples of telemetry.

    Attributes:
        interpolation: (6,) variances by interpolation, see `CameraPose`, times the time for which
            these errors last, m² s and rad² s.
    """

    interpolation: Array


PoseAt = Callable[[int], "MapPose | bool"]
"""The camera in `map` at a time, ns; without a pose, whether its telemetry may still arrive."""


def smoothed(values: Array) -> Array:
    """Return (n - 6, …) of values (n, …), smoothed by a parabola over seven samples.

    Neighbouring windows overlap, so the remaining noise is correlated and does not look like motion
    of the camera. (Savitzky and Golay 1964.)
    """
    n = len(values) - 2 * MARGIN
    return np.asarray(sum(w * values[i : i + n] for i, w in enumerate(WEIGHTS.tolist())))


_NONE = np.zeros(6)


class PoseLattice:
    """Poses at multiples of `STEP_S`, computed once; the oldest are dropped.

    Args:
        length: least number of poses kept.

    Attributes:
        jumps_s: times at which telemetry jumped, s.
    """

    def __init__(self, length: int) -> None:
        self._length = length + 2 * MARGIN
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._first = self._next = 0
        self._poses: list[MapPose] = []  # immutable: a snapshot shares them
        self._sampled = False
        self.jumps_s: tuple[float, ...] = ()

    def fill(self, first: int, last: int, pose_at: PoseAt, final: bool) -> bool:
        """Fill in what `between` needs for poses `first` to `last`; False: telemetry is awaited.

        Poses that cannot be computed are NaN; with `final` also those that telemetry could still
        give.
        """
        first, last = first - MARGIN, last + 1 + MARGIN
        if not self._poses or not self._first <= first <= self._next:
            self.clear()
            self._first = self._next = first
        while self._next <= last:
            pose = pose_at(self._next * STEP_NS)
            if pose is True and not final:
                return False
            if isinstance(pose, bool):
                pose = MapPose(np.full(3, np.nan), np.full((3, 3), np.nan))
            self._sampled |= isinstance(pose, SampledPose)
            self._poses.append(pose)
            self._next += 1
        surplus = len(self._poses) - self._length
        if surplus > 0:
            del self._poses[:surplus]
            self._first += surplus
        return True

    def note_jump(self, time_s: float) -> None:
        """Note that telemetry jumped at a time, s."""
        self.jumps_s = (*self.jumps_s, time_s)[-TUNING.most_jumps :]

    def interpolation(self, first: int, last: int, passed: float) -> Array | None:
        """Return (n, 6) variances of some poses by interpolation; None: none has any.

        Images between the same samples share an error: together they count for one.

        Args:
            first: index of the first.
            last: index of the last.
            passed: time since the image before, s.
        """
        if not self._sampled or passed <= 0.0:
            return None
        poses = self._poses[first - self._first : last + 1 - self._first]
        lasting = [one.interpolation if isinstance(one, SampledPose) else _NONE for one in poses]
        return np.array(lasting) / passed

    def between(self, first: int, last: int, fraction: float) -> tuple[Array, Array]:
        """Return positions (n, 3) and rotations (n, 3, 3) at `fraction` after each of some poses.

        Rotation matrices are averaged, which is accurate to 1e-3 over the few degrees of some
        steps.

        Args:
            first: index of the first.
            last: index of the last.
            fraction: of the way to the next, 0 to 1.
        """
        begin, end = first - self._first - MARGIN, last - self._first + 2 + MARGIN
        poses = self._poses[begin:end]
        places = smoothed(np.array([pose.position for pose in poses]))
        turns = smoothed(np.array([pose.rotation for pose in poses]))
        keep = 1.0 - fraction
        return (
            keep * places[:-1] + fraction * places[1:],
            keep * turns[:-1] + fraction * turns[1:],
        )
