# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Time-sorted telemetry: samples at a scene's time by interpolation, never by extrapolation."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Generic, Protocol, TypeVar

from aerial_gnss_ros.core.telemetry.interpolation import (
    interpolate_fixes,
    interpolate_orientations,
    interpolate_scalars,
)
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

_COMPACT_AT = 1024


class Stamped(Protocol):
    """A value with a time of validity."""

    @property
    def stamp_ns(self) -> int:
        """Time of validity, ns."""


T = TypeVar("T", bound=Stamped)


class Missing(str, Enum):
    """Why there is no value at a time."""

    NONE = "none"
    """No sample ever arrived."""
    WAIT = "wait"
    """The newest sample is a little older: the bracketing one may still arrive."""
    STALE = "stale"
    """The newest sample is older by more than `max_gap`: only a late one can help."""
    GAP = "gap"
    """The samples on both sides are more than `max_gap` apart."""
    BEFORE = "before"
    """The time is before the oldest sample."""

    @property
    def can_arrive(self) -> bool:
        """Whether waiting for more samples makes sense."""
        return self in (Missing.NONE, Missing.WAIT, Missing.STALE)

    def reason(self, source: Input) -> Reason:
        """Return the refusal that is counted when the wait is over."""
        if self is Missing.GAP:
            return Reason.gap(source)
        if self in (Missing.NONE, Missing.BEFORE):
            return Reason.no(source)
        return Reason.stale(source)


@dataclass(frozen=True)
class Sample(Generic[T]):
    """A value at the requested time.

    Attributes:
        value: interpolated; its stamp is the requested time.
        age_s: distance in time to the farther of the samples used, s.
        gap_s: time between these, s; 0 if one has exactly that time.
    """

    value: T
    age_s: float
    gap_s: float = 0.0


class Series(Generic[T]):
    """Samples of one input, sorted by stamp whatever the order of their arrival.

    A second sample with the same stamp replaces the first. Appending in order takes constant time
    on average, a lookup logarithmic time.

    Args:
        interpolated: interpolates two samples at a fraction from 0 to 1 and stamps the result.
        max_gap_s: neighbours farther apart are not interpolated, s.
        keep_s: samples older than the newest by more are dropped, s.
        max_length: greatest number of newest samples kept.
    """

    def __init__(
        self,
        between: Callable[[T, T, float, int], T],
        max_gap_s: float,
        *,
        keep_s: float = 60.0,
        max_length: int = 100_000,
    ) -> None:
        self._between = between
        self._max_gap_ns = round(max_gap_s * 1e9)
        self._keep_ns = round(keep_s * 1e9)
        self._max_length = max_length
        self._stamps: list[int] = []
        self._values: list[T] = []
        self._start = 0  # older samples are dropped; removed periodically, many at once

    def __len__(self) -> int:
        return len(self._stamps) - self._start

    @property
    def first_stamp_ns(self) -> int | None:
        """Stamp of the oldest sample kept, ns."""
        return self._stamps[self._start] if len(self) else None

    @property
    def last_stamp_ns(self) -> int | None:
        """Stamp of the newest sample, ns."""
        return self._stamps[-1] if len(self) else None

    @property
    def last(self) -> T | None:
        """The sample with the newest stamp."""
        return self._values[-1] if len(self) else None

    @property
    def values(self) -> list[T]:
        """The samples kept, the oldest first."""
        return self._values[self._start :]

    def stamps(self, first_ns: int, last_ns: int) -> list[int]:
        """Return the stamps of the samples from one time to another, ns."""
        first = bisect_left(self._stamps, first_ns, lo=self._start)
        return self._stamps[first : bisect_right(self._stamps, last_ns, lo=self._start)]

    def clear(self) -> None:
        """Forget everything."""
        self._stamps.clear()
        self._values.clear()
        self._start = 0

    def add(self, value: T) -> None:
        """Insert a sample by its stamp."""
        stamp = value.stamp_ns
        if self._start == len(self._stamps) or stamp > self._stamps[-1]:
            self._stamps.append(stamp)
            self._values.append(value)
        else:
            place = bisect_left(self._stamps, stamp, lo=self._start)
            if self._stamps[place] == stamp:
                self._values[place] = value
                return
            self._stamps.insert(place, stamp)
            self._values.insert(place, value)
        self._forget()

    def at(self, stamp_ns: int) -> Sample[T] | Missing:
        """Return the value at a time, or why there is none."""
        stamps, values = self._stamps, self._values
        after = bisect_left(stamps, stamp_ns, lo=self._start)
        if after < len(stamps):
            if stamps[after] == stamp_ns:
                return Sample(values[after], 0.0)
            before = after - 1
            if before >= self._start and stamps[after] - stamps[before] <= self._max_gap_ns:
                since, gap = stamp_ns - stamps[before], stamps[after] - stamps[before]
                value = self._between(values[before], values[after], since / gap, stamp_ns)
                return Sample(value, max(since, gap - since) * 1e-9, gap * 1e-9)
        missing = self.missing_at(stamp_ns)
        assert missing is not None  # noqa: S101 - by the same neighbours
        return missing

    def missing_at(self, stamp_ns: int) -> Missing | None:
        """Return why there is no value at a time, None if there is one."""
        stamps = self._stamps
        if self._start == len(stamps):
            return Missing.NONE
        late = stamp_ns - stamps[-1]
        if late > 0:
            return Missing.WAIT if late <= self._max_gap_ns else Missing.STALE
        after = bisect_left(stamps, stamp_ns, lo=self._start)
        if stamps[after] == stamp_ns:
            return None
        if after == self._start:
            return Missing.BEFORE
        return Missing.GAP if stamps[after] - stamps[after - 1] > self._max_gap_ns else None

    def latest(self, stamp_ns: int) -> T | None:
        """Return the newest sample not later than a time: for values valid until replaced."""
        after = bisect_right(self._stamps, stamp_ns, lo=self._start)
        return self._values[after - 1] if after > self._start else None

    def _forget(self) -> None:
        stamps, last = self._stamps, len(self._stamps) - 1
        oldest = stamps[-1] - self._keep_ns
        # The newest sample from before the window stays: `latest` may need it.
        while self._start < last and (
            stamps[self._start + 1] <= oldest or last - self._start >= self._max_length
        ):
            self._start += 1
        if self._start > _COMPACT_AT and 2 * self._start > last + 1:
            del self._stamps[: self._start]
            del self._values[: self._start]
            self._start = 0


def fix_series(max_gap_s: float, *, keep_s: float = 60.0) -> Series[Fix]:
    """Return a series of the drone's positions; interpolates on the shorter way round the Earth."""
    return Series(interpolate_fixes, max_gap_s, keep_s=keep_s)


def orientation_series(max_gap_s: float, *, keep_s: float = 60.0) -> Series[Orientation]:
    """Return a series of orientations; interpolates on the shortest rotation (slerp)."""
    return Series(interpolate_orientations, max_gap_s, keep_s=keep_s)


def scalar_series(max_gap_s: float, *, keep_s: float = 60.0) -> Series[Scalar]:
    """Return a series of heights or levels; interpolates linearly."""
    return Series(interpolate_scalars, max_gap_s, keep_s=keep_s)


def held_series(*, keep_s: float = 60.0) -> Series[T]:
    """Return a series of values valid until replaced (camera, water level): only `latest`."""

    def earlier(before: T, _after: T, _fraction: float, _stamp_ns: int) -> T:
        return before

    return Series(earlier, float(2**62) * 1e-9, keep_s=keep_s)
