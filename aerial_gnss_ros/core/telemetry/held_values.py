# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tells new values of telemetry from old ones that are sent again until the next is measured.

Many sources send values more often than they measure them: a driver at 50 Hz of a receiver at 5 Hz,
subtitles of a video, a table with a row for each image. Taken for measurements, such values make
the drone stand still and then jump. Noise repeats no value to the last bit, so an input that
repeats most of them, for about as long each, holds its values: only the first sample of each is a
measurement. What the gimbal or the height repeats for no longer than the receiver holds positions
may be held as well: one driver sends them all.

A drone that stands still, or a sensor that rounds, repeats values for different times, and comes
back to earlier ones, which noise does not. That is left alone. A receiver hardly ever rounds as
coarsely as it is exact, gimbals do: more of their values have to be repeated for as long each.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

Value = Fix | Orientation | Scalar
Components = tuple[float, ...]
T = TypeVar("T", Fix, Orientation, Scalar)


@dataclass(frozen=True)
class HeldValuesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    positions: int = 3
    """Number of recent positions by which it is judged whether they are held. Judged."""
    values: int = 10
    """The same of other values, which may be repeated because they are rounded. Judged."""
    remembered: int = 60
    """Number of values to which a rounded one may come back. Judged."""
    repeated: float = 0.6
    """Least share of these sent more than once: not all are, of 6 Hz sent at 10 Hz. Judged."""
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


def repeats(one: Value, other: Value, held_s: float) -> bool:
    """Return whether a sample repeats an earlier one of its input within some time, s."""
    since_s = (other.stamp_ns - one.stamp_ns) * 1e-9
    return 0.0 <= since_s < held_s and components(one) == components(other)


def without_repeated(samples: Sequence[T], held_s: float) -> list[T]:
    """Return samples without those that repeat the last one kept before them."""
    kept: list[T] = []
    for one in samples:
        if not (kept and repeats(kept[-1], one, held_s)):
            kept.append(one)
    return kept


class HeldValues:
    """Judges for how long an input holds its values.

    Args:
        runs: number of recent values by which it is judged.

    Attributes:
        held_s: time within which a repeated value is no measurement, s; 0: values are not held.
    """

    def __init__(self, runs: int) -> None:
        self._runs: deque[tuple[float, int]] = deque(maxlen=runs)
        self._past: deque[Components] = deque(maxlen=TUNING.remembered)
        self.clear()

    def clear(self) -> None:
        """Forget all values."""
        self.held_s = 0.0
        self._value: Components = ()
        self._began_ns = self._newest_ns = -(2**62)
        self._sent = 0
        self._runs.clear()
        self._past.clear()

    def update(self, sample: Value) -> None:
        """Update with a usable sample; one that is older than the last is ignored."""
        if sample.stamp_ns <= self._newest_ns:
            return
        self._newest_ns, value = sample.stamp_ns, components(sample)
        if value == self._value:
            self._sent += 1
            return
        if self._value:
            self._runs.append(((sample.stamp_ns - self._began_ns) * 1e-9, self._sent))
            self._past.append(self._value)
        if value in self._past:
            self._runs.clear()
        self._value, self._began_ns, self._sent = value, sample.stamp_ns, 1
        self._judge()

    def _judge(self) -> None:
        runs = len(self._runs)
        if runs < (self._runs.maxlen or 0):
            return
        times = sorted(seconds for seconds, _ in self._runs)
        usual, longest = times[runs // 2], times[-1]
        if sum(sent > 1 for _, sent in self._runs) < TUNING.repeated * runs:
            self.held_s = 0.0
        elif longest <= TUNING.longest_ratio * usual:
            self.held_s = min(TUNING.hold_ratio * usual, TUNING.longest_s)
