# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measured camera poses at multiples of a time step, smoothed."""

from __future__ import annotations

import math
from collections import deque
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

    step_m: float = 0.3
    """Step of the camera's position by which telemetry may have jumped, m. Judged."""
    step_rad: float = 0.03
    """The same of its orientation, rad: a turn by 1.7 deg. A turn by w changes a matrix by √2 w.
    Judged."""
    same_rate: float = 0.5
    """A rate has not changed if it has by less than this share of the step. A camera that begins
    to turn has another rate, and telemetry once a second shows no steps. Judged."""

    jump_poses: int = 5
    """Number of poses in a row that show a jump: a step between samples bends three of them."""
    usual_share: float = 0.8
    """Share of recent poses whose bends are noise, or motion of the camera, for sure. Judged."""
    times_usual: float = 3.0
    """A jump bends poses more than so many times what that share of them has: noisy telemetry, or a
    receiver that wanders, jumps no more often. Judged."""
    recent_poses: int = 100
    """Number of poses that are recent: 10 s. Judged."""
    least_poses: int = 20
    """With fewer nothing is known of what is usual. Judged."""
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


def _usual(bends: deque[float]) -> float:
    """Return what `usual_share` of the last bends of poses do not exceed; 0: nothing is known."""
    if len(bends) < TUNING.least_poses:
        return 0.0
    return sorted(bends)[int(TUNING.usual_share * len(bends))]


_NONE = np.zeros(6)


class PoseLattice:
    """Poses at multiples of `STEP_S`, computed once; the oldest are dropped.

    Args:
        length: least number of poses kept.

    Attributes:
        jumps_s: times at which telemetry may have jumped, s.
    """

    def __init__(self, length: int) -> None:
        self._length = length + 2 * MARGIN
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._first = self._next = 0
        self._poses: list[MapPose] = []  # immutable: a snapshot shares them
        self._sampled = False
        # A list: a snapshot shares what a tuple holds.
        self._bends = [deque[float](maxlen=TUNING.recent_poses) for _ in ("position", "rotation")]
        self._steps: list[tuple[float, float, int]] = []
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
            self._look_for_step()
            self._next += 1
        self._judge_steps()
        surplus = len(self._poses) - self._length
        if surplus > 0:
            del self._poses[:surplus]
            self._first += surplus
        return True

    def _look_for_step(self) -> None:
        """Note a step of the pose after which its rate is what it was before."""
        last = self._poses[-TUNING.jump_poses :]
        if len(last) < TUNING.jump_poses:
            return
        for kind, (values, least) in enumerate(
            (
                (np.array([pose.position for pose in last]), TUNING.step_m),
                (np.array([pose.rotation for pose in last]), math.sqrt(2.0) * TUNING.step_rad),
            )
        ):
            bends = np.diff(values, n=2, axis=0).reshape(len(last) - 2, -1)
            most = float(np.linalg.norm(bends, axis=1).max())
            changed = float(np.linalg.norm(bends.sum(axis=0)))
            if math.isfinite(most):
                self._bends[kind].append(most)
            if most > least and changed < TUNING.same_rate * most:
                self._steps.append(((self._next - len(last) // 2) * STEP_S, most, kind))

    def _judge_steps(self) -> None:
        """Take for jumps those steps that are larger than telemetry's usual noise."""
        for step_s, size, kind in self._steps:
            if size > TUNING.times_usual * _usual(self._bends[kind]):
                self.jumps_s = (*self.jumps_s, step_s)[-TUNING.most_jumps :]
        self._steps.clear()

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
