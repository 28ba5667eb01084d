# SPDX-License-Identifier: Apache-2.0
"""The camera's measured pose at any time of a recording, for many times at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.recording import Recording

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

STEP_S = 0.02
MOST_STEPS = 30_000
TURN_S, MOVE_S = 0.3, 1.0
"""Rates are means over this long to either side: differences of two samples are mostly noise, and
noise in a derivative is taken for information on the latency. A drone's place changes more smoothly
than a gimbal turns, and its noise is larger against its motion."""
REACH_S = 3.1
"""Poses are taken so far beyond the images: the largest latency is 3 s either way."""


@dataclass(frozen=True)
class Poses:
    """Camera poses in `map` at n times.

    Attributes:
        position: (n, 3) East, North, Up, m.
        rotation: (n, 3, 3) camera FLU in `map`.
        velocity: (n, 3) m/s.
        turning: (n, 3) about East, North, Up, rad/s.
        known: (n,) False where telemetry lacks; the values there mean nothing.
    """

    position: Array
    rotation: Array
    velocity: Array
    turning: Array
    known: NDArray[np.bool_]


class PoseTable:
    """Poses on a fine grid of times, between which they are interpolated.

    Args:
        recording: after the replay.
    """

    def __init__(self, recording: Recording) -> None:
        first = recording.sightings[0].stamp_ns - round(REACH_S * 1e9)
        last = recording.sightings[-1].stamp_ns + round(REACH_S * 1e9)
        step = max(STEP_S, (last - first) * 1e-9 / MOST_STEPS)
        self._first_ns, self._step_s = first, step
        count = int((last - first) * 1e-9 / step) + 2
        self._position = np.zeros((count, 3))
        self._rotation = np.tile(np.eye(3), (count, 1, 1))
        self._known = np.zeros(count, dtype=np.bool_)
        for i in range(count):
            pose = recording.pose(first + round(i * step * 1e9))
            if pose is not None:
                self._position[i], self._rotation[i] = pose.position, pose.rotation
                self._known[i] = True
        turned = self._rotation[1:] @ self._rotation[:-1].swapaxes(1, 2)
        self._turned = Rotation.from_matrix(turned).as_rotvec()
        angle = np.vstack([np.zeros(3), np.cumsum(self._turned, axis=0)])
        self._velocity, self._turning = (
            _rates(self._position, step, MOVE_S), _rates(angle, step, TURN_S),
        )  # fmt: skip

    def at(self, stamps_ns: Stamps) -> Poses:
        """Return poses at times (n,)."""
        at = (stamps_ns - self._first_ns) * 1e-9 / self._step_s
        low = np.clip(at.astype(np.intp), 0, len(self._position) - 2)
        share = at - low
        known = self._known[low] & self._known[low + 1] & (share >= 0.0) & (share <= 1.0)
        moved = self._position[low + 1] - self._position[low]
        turned = self._turned[low]
        rotation = Rotation.from_rotvec(share[:, None] * turned).as_matrix() @ self._rotation[low]
        return Poses(
            self._position[low] + share[:, None] * moved, rotation, self._velocity[low],
            self._turning[low], known,
        )  # fmt: skip


def _rates(values: Array, step_s: float, reach_s: float) -> Array:
    """Return mean rates (n, 3) round each of the values (n, 3)."""
    reach = max(1, round(reach_s / step_s))
    at = np.arange(len(values))
    low, high = np.maximum(at - reach, 0), np.minimum(at + reach, len(values) - 1)
    rates: Array = (values[high] - values[low]) / ((high - low) * step_s)[:, None]
    return rates
