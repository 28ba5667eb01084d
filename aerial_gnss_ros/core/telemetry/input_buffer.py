# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The buffer of one telemetry input: its samples, and what they show of one another.

Values that are sent again until the next is measured are not stored, nor are single wrong ones
(`jumps`). Unusable samples are stored as such: between them there is no value.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

from aerial_gnss_ros.core.telemetry.held_values import TUNING as HELD
from aerial_gnss_ros.core.telemetry.held_values import HeldValues, repeats, without_repeated
from aerial_gnss_ros.core.telemetry.interpolation_error import (
    InterpolationError,
    Uncertain,
    fix_error,
    orientation_error,
    scalar_error,
)
from aerial_gnss_ros.core.telemetry.jumps import (
    JumpFilter,
    fix_jumps,
    orientation_jumps,
    scalar_jumps,
    without_jump,
)
from aerial_gnss_ros.core.telemetry.series import (
    Missing,
    Sample,
    Series,
    fix_series,
    orientation_series,
    scalar_series,
)
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

T = TypeVar("T", Fix, Orientation, Scalar)


class InputBuffer(Generic[T]):
    """Stores samples of one input.

    Args:
        series: of the samples.
        error: learns of values between them.
        jumps: finds jumps and single wrong samples.
        judged_by: number of recent values by which it is judged whether they are held.
        unit: in which it is told how far off a sample is, and how many of it are a m or a rad.

    Attributes:
        series: the same.
        held: judges whether values are sent again.
    """

    def __init__(
        self,
        series: Series[T],
        error: InterpolationError[T],
        jumps: JumpFilter[T],
        judged_by: int,
        unit: tuple[str, float],
    ) -> None:
        self.series: Series[T] = series
        self.held = HeldValues(judged_by)
        self._error: InterpolationError[T] = error
        self._jumps: JumpFilter[T] = jumps
        self._unit = unit

    def clear(self) -> None:
        """Forget all samples."""
        self.series.clear()
        self.held.clear()
        self._error.clear()
        self._jumps.clear()

    def add(self, value: T, held_s: float) -> str:
        """Store a usable sample; return why one before it is wrong, else empty.

        Args:
            value: the sample.
            held_s: time within which a repeated value is no measurement, s.
        """
        last = self.series.last
        if last is not None and repeats(last, value, held_s):
            return ""
        self._store(self._jumps.update(value))
        unit, factor = self._unit
        off = factor * self._jumps.left_out
        return f"it lies {off:.2g} {unit} off those before and after it, which agree" if off else ""

    def add_unusable(self, value: T) -> None:
        """Store a sample that is marked as unusable."""
        self._store(self._jumps.interrupt())
        self.series.add(value)

    def discard_repeated(self, held_s: float, is_usable: Callable[[T], bool]) -> None:
        """Remove stored values that were sent again; their steps were no jumps.

        Args:
            held_s: time within which a repeated value is no measurement, s.
            is_usable: tells samples that can be used from others.
        """
        stored = self.series.values
        stored.extend(self._jumps.clear())
        self.series.clear()
        self._error.clear()
        for value in without_repeated(stored, held_s):
            once = without_jump(value)
            if is_usable(once):
                self._store(self._jumps.update(once))
            else:
                self.series.add(once)

    def at(self, stamp_ns: int) -> tuple[Sample[T], Uncertain | None] | Missing:
        """Return the value at a time and, between samples, its error; or why there is none."""
        sample = self.series.at(stamp_ns)
        if isinstance(sample, Missing):
            return sample
        between = sample.gap_s > 0.0
        return sample, self._error.at(stamp_ns, sample.age_s, sample.gap_s) if between else None

    def _store(self, values: list[T]) -> None:
        for value in values:
            last = self.series.last
            if last is not None and last.jumped != value.jumped:
                self._error.interrupt()
            self._error.add(value)
            self.series.add(value)


AnyBuffer = InputBuffer[Fix] | InputBuffer[Orientation] | InputBuffer[Scalar]
_METRES, _DEGREES = ("m", 1.0), ("deg", math.degrees(1.0))


def fix_buffer(max_gap_s: float, keep_s: float) -> InputBuffer[Fix]:
    """Return a buffer of the drone's positions."""
    series = fix_series(max_gap_s, keep_s=keep_s)
    return InputBuffer(series, fix_error(), fix_jumps(), HELD.positions, _METRES)


def orientation_buffer(max_gap_s: float, keep_s: float) -> InputBuffer[Orientation]:
    """Return a buffer of orientations."""
    series = orientation_series(max_gap_s, keep_s=keep_s)
    return InputBuffer(series, orientation_error(), orientation_jumps(), HELD.values, _DEGREES)


def scalar_buffer(max_gap_s: float, keep_s: float) -> InputBuffer[Scalar]:
    """Return a buffer of heights."""
    series = scalar_series(max_gap_s, keep_s=keep_s)
    return InputBuffer(series, scalar_error(), scalar_jumps(), HELD.values, _METRES)
