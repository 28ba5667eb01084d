# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects sensors that repeat a value to the last bit although their samples have noise.

Many sensors repeat values legitimately: a steady gimbal reports tenths of a degree, a receiver's
positions are sent more often than measured. So a repetition means nothing until the sensor has
shown noise: each of its last samples differed from the previous one in two angles at least, as
white noise makes them, and by steps that no resolution rounds. (Gimbals that are level report a
roll of 0.) Noise does not repeat both. From then on a repeated value is refused until it changes.

Receivers smooth their positions, so their noise is not white. A receiver at rest may repeat itself;
one that moves at speed does not stop from one sample to the next.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAMPLES = 40
"""Consecutive samples that must have shown noise."""

NOISY_ANGLES = 2
"""Number of angles that must have: a camera that pans moves one."""

FINE_SHARE = 0.25
"""Share of the median second difference below which the smallest is, unless values are rounded."""

SAME = 1e-9
"""Components that differ by less are equal: conversions round."""

BEFORE = 5
"""Steps over which the platform's motion is measured."""

SPEED_MPS = 1.0
"""Least speed of a platform that does not stop from one sample to the next, m/s."""

JITTER_M = 1e-3
"""Least median second difference of a real receiver's positions, m; a simulator's may have none."""


class Repetition:
    """Repetition test of one orientation.

    Attributes:
        repeats: whether the last sample was a repetition.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self.repeats = False
        self._exact: tuple[float, ...] = ()
        self._stamp_ns = -(2**62)
        self._angles: deque[tuple[float, ...]] = deque(maxlen=SAMPLES)

    def update(self, stamp_ns: int, quaternion: Sequence[float]) -> bool:
        """Update with a sample; return whether it is a repetition.

        Args:
            stamp_ns: ns; samples no newer than the last one are ignored.
            quaternion: x, y, z, w.
        """
        exact = tuple(quaternion)
        if stamp_ns <= self._stamp_ns:
            return self.repeats and exact == self._exact
        self._stamp_ns = stamp_ns
        if exact == self._exact:
            self.repeats = self.repeats or self._has_noise()
            if not self.repeats:
                self._angles.clear()
            return self.repeats
        self._angles.append(_angles(exact))
        self._exact, self.repeats = exact, False
        return False

    def _has_noise(self) -> bool:
        """Return whether enough angles of the last samples differ as white noise does.

        Second differences of white noise alternate (correlation -2/3: three in four change sign),
        those of a motion persist.
        """
        if len(self._angles) < SAMPLES:
            return False
        steps = np.diff(np.array(self._angles), axis=0)
        steps = (steps + math.pi) % (2.0 * math.pi) - math.pi
        bends = np.diff(steps, axis=0)
        alternate = np.sum(np.sign(bends[1:] * bends[:-1]), axis=0) < 0.0
        sizes = np.sort(np.abs(bends), axis=0)
        fine = (sizes[0] > 0.0) & (sizes[0] < FINE_SHARE * sizes[len(sizes) // 2])
        differ = (np.abs(steps) > SAME).all(axis=0)
        return int(np.count_nonzero(alternate & fine & differ)) >= NOISY_ANGLES


class Standing:
    """Repetition test of one receiver's positions.

    Attributes:
        repeats: whether the last sample was a repetition.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self.repeats = False
        self._differed = 0
        self._last: deque[tuple[int, tuple[float, float]]] = deque(maxlen=BEFORE + 1)

    def update(
        self, stamp_ns: int, place: tuple[float, float], metres: tuple[float, float]
    ) -> bool:
        """Update with a sample; return whether it is a repetition.

        Args:
            stamp_ns: ns; samples no newer than the last one are ignored.
            place: latitude and longitude, rad.
            metres: length of a radian of each, m.
        """
        last = self._last[-1] if self._last else (-(2**62), (math.nan, math.nan))
        if stamp_ns <= last[0]:
            return self.repeats and place == last[1]
        if place == last[1]:
            self.repeats = self.repeats or self._in_motion(metres)
            if not self.repeats:
                self._differed = 0
                self._last.clear()
                self._last.append((stamp_ns, place))
            return self.repeats
        differs = place[0] != last[1][0] and place[1] != last[1][1]
        self._differed = self._differed + 1 if differs else 0
        if self.repeats:  # the step that ends a repetition is no motion
            self._last.clear()
        self._last.append((stamp_ns, place))
        self.repeats = False
        return False

    def _in_motion(self, metres: tuple[float, float]) -> bool:
        if self._differed < SAMPLES or len(self._last) <= BEFORE:
            return False
        times = np.array([stamp_ns for stamp_ns, _ in self._last]) * 1e-9
        steps = np.diff(np.array([place for _, place in self._last]), axis=0) * np.array(metres)
        way = steps.sum(axis=0)
        length = math.hypot(*way)
        speed = length / max(times[-1] - times[0], 1e-3)
        last = float(steps[-1] @ way) / max(length * (times[-1] - times[-2]), 1e-6)
        jitter = np.linalg.norm(np.diff(steps, axis=0), axis=1)
        return speed >= SPEED_MPS and last >= 0.5 * speed and float(np.median(jitter)) >= JITTER_M


def _angles(quaternion: tuple[float, ...]) -> tuple[float, ...]:
    """Return roll, pitch and yaw, rad: coarse sensors repeat them one by one."""
    x, y, z, w = quaternion
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, math.asin(sine), yaw
