# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tells new values of telemetry from old ones that are sent again until the next is measured.

Many sources send values more often than they measure them: a driver at 50 Hz of a receiver at 5 Hz,
subtitles of a video, a table with a row for each image. Taken for measurements, such values make
the drone stand still and then jump. The receiver tells: its noise repeats no position to the last
bit, so a source that repeats most of them, for about as long each, holds its values. Then only the
first sample of each value is a measurement, of all inputs: what the gimbal or the height repeats
for no longer than the receiver does may be held as well.

A receiver that stands still, or rounds, repeats positions for different times. It is left alone.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Value = Fix | Orientation | Scalar
Components = tuple[float, ...]


@dataclass(frozen=True)
class HeldValuesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    runs: int = 3
    """Number of recent positions by which it is judged whether they are held. Judged."""
    repeated: int = 2
    """Least number of these sent more than once: not all are, of 6 Hz sent at 10 Hz. Judged."""
    longest_ratio: float = 2.0
    """Greatest ratio of the longest to the median time for which one was sent. Judged."""
    hold_ratio: float = 1.5
    """Ratio to the median time after which a repeated value is a measurement again: a drone that
    stands still, or a gimbal with a coarse resolution. Judged."""
    longest_s: float = 2.0
    """Upper bound of that time, s: beyond, there would be a gap (`max_gap`). Judged."""


TUNING = HeldValuesTuning()


def components(value: Value) -> Components:
    """Return what is equal to the last bit where a value is repeated."""
    if isinstance(value, Fix):
        altitude = 0.0 if math.isnan(value.altitude) else value.altitude
        return value.latitude, value.longitude, altitude
    if isinstance(value, Orientation):
        return tuple(value.quaternion.tolist())
    return (value.value,)


class HeldValues:
    """Judges by the receiver's positions for how long values are held.

    Attributes:
        held_s: time within which a repeated value is no measurement, s; 0: positions are not held.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all positions."""
        self.held_s = 0.0
        self._place: Components = ()
        self._began_ns = self._newest_ns = -(2**62)
        self._sent = 0
        self._runs: deque[tuple[float, int]] = deque(maxlen=TUNING.runs)

    def repeats(self, one: Value, other: Value) -> bool:
        """Return whether a sample repeats an earlier one of its input that is held."""
        since_s = (other.stamp_ns - one.stamp_ns) * 1e-9
        return 0.0 <= since_s < self.held_s and components(one) == components(other)

    def update(self, fix: Fix) -> None:
        """Update with a usable position; one that is older than the last is ignored."""
        if fix.stamp_ns <= self._newest_ns:
            return
        self._newest_ns, place = fix.stamp_ns, components(fix)
        if place == self._place:
            self._sent += 1
            return
        if self._place:
            self._runs.append(((fix.stamp_ns - self._began_ns) * 1e-9, self._sent))
        self._place, self._began_ns, self._sent = place, fix.stamp_ns, 1
        if len(self._runs) < TUNING.runs:
            return
        times = sorted(seconds for seconds, _ in self._runs)
        usual, longest = times[len(times) // 2], times[-1]
        if sum(sent > 1 for _, sent in self._runs) < TUNING.repeated:
            self.held_s = 0.0
        elif longest <= TUNING.longest_ratio * usual:
            self.held_s = min(TUNING.hold_ratio * usual, TUNING.longest_s)
