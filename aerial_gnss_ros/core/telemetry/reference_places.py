# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where references are at a time: as stated, or by the fixes that they send."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.references import Reference
from aerial_gnss_ros.core.telemetry.interpolation import interpolate_fixes
from aerial_gnss_ros.core.telemetry.series import Sample, Series, fix_series
from aerial_gnss_ros.core.values.reference_place import ReferencePlace
from aerial_gnss_ros.core.values.samples import Fix

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReferencePlacesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    longest_gap_s: float = 2.5
    """Fixes farther apart are not interpolated: 1 Hz is usual, and one may be lost. Judged."""
    longest_wait_s: float = 1.5
    """A fix is carried on with its velocity for so long: images do not wait for it. Judged."""
    boat_acceleration: float = 0.3
    """What a boat may accelerate between two fixes or after the last one, one sigma, m/s².
    Judged."""


TUNING = ReferencePlacesTuning()


def reference_input(name: str) -> str:
    """Return the name of the input on which a reference sends its fixes."""
    return f"reference_{name}"


def is_reference(name: str) -> bool:
    """Return whether an input is a reference's."""
    return name.startswith(reference_input(""))


class ReferencePlaces:
    """Knows where references are.

    Args:
        references: as configured.

    Attributes:
        configured: whether there are any.
    """

    def __init__(self, references: Iterable[Reference]) -> None:
        self._moving = {one.name: one for one in references if one.topic}
        self._fixes: dict[str, Series[Fix]] = {
            name: fix_series(TUNING.longest_gap_s) for name in self._moving
        }
        self._staying = tuple(_stated(one) for one in references if one.position)
        self.configured = bool(self._moving or self._staying)

    def replaced(self, references: Iterable[Reference]) -> ReferencePlaces:
        """Return those of another configuration, with the fixes of those that it keeps."""
        made = ReferencePlaces(references)
        for name, one in made._moving.items():
            if self._moving.get(name) == one:
                made._fixes[name] = self._fixes[name]
        return made

    @property
    def sent(self) -> tuple[str, ...]:
        """The references that send fixes, by name."""
        return tuple(self._moving)

    def add(self, name: str, fix: Fix) -> str:
        """Keep a fix; return why it is no use, else empty."""
        if not fix.valid:
            return "its receiver has no fix"
        if not (abs(fix.latitude) <= 0.5 * math.pi and abs(fix.longitude) <= math.pi):
            return "its latitude or longitude is not on Earth"
        if fix.latitude == fix.longitude == 0.0:
            return "it is at 0, 0, what receivers send without a fix"
        if math.isnan(self._variances(name, fix)[0, 0]):
            return f"it has no covariance; set references.{name}.sigma_m"
        self._fixes[name].add(fix)
        return ""

    def at(self, stamp_ns: int) -> tuple[ReferencePlace, ...]:
        """Return where those are of which it is known at a time, ns."""
        if not self._fixes:
            return self._staying
        found = list(self._staying)
        for name, series in self._fixes.items():
            sample = _at(series, stamp_ns)
            if sample is not None:
                one, fix = self._moving[name], sample.value
                bent = 0.5 * TUNING.boat_acceleration * sample.age_s**2
                spread = self._variances(name, fix) + bent**2 * np.eye(2)
                found.append(
                    ReferencePlace(
                        name, one.class_id, fix.latitude, fix.longitude, spread, one.height_m, True
                    )
                )
        return tuple(found)

    def clear(self) -> None:
        """Forget all fixes."""
        for series in self._fixes.values():
            series.clear()

    def _variances(self, name: str, fix: Fix) -> Array:
        """Return a fix's own covariance (2, 2), or the stated one; NaN without both, m²."""
        if fix.covariance is not None:
            own = fix.covariance[:2, :2]
            if np.isfinite(own).all() and (own.diagonal() > 0.0).all():
                return own
        stated: Array = self._moving[name].variance * np.eye(2)
        return stated


def _at(series: Series[Fix], stamp_ns: int) -> Sample[Fix] | None:
    """Return a fix at a time and for how long it may have turned since one; None: too long."""
    sample = series.at(stamp_ns)
    if isinstance(sample, Sample):
        near = series.latest(stamp_ns)
        since = sample.age_s if near is None else (stamp_ns - near.stamp_ns) * 1e-9
        return replace(sample, age_s=min(since, sample.age_s))
    last = series.last
    if last is None or not 0 < stamp_ns - last.stamp_ns <= TUNING.longest_wait_s * 1e9:
        return None
    before = series.latest(last.stamp_ns - 1)
    age_s = (stamp_ns - last.stamp_ns) * 1e-9
    if before is None or last.stamp_ns - before.stamp_ns > TUNING.longest_gap_s * 1e9:
        return None
    share = (stamp_ns - before.stamp_ns) / (last.stamp_ns - before.stamp_ns)
    fix = interpolate_fixes(before, last, share, stamp_ns)
    return Sample(replace(fix, covariance=last.covariance), age_s)


def _stated(one: Reference) -> ReferencePlace:
    latitude, longitude = map(math.radians, one.position)
    spread = one.variance * np.eye(2)
    return ReferencePlace(one.name, one.class_id, latitude, longitude, spread, one.height_m)
