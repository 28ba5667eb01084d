# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Admission of telemetry: implausible samples are refused before they are stored.

`validity` tests each sample by itself, `continuity` and `repetition` test consecutive ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.geodesy import SEMI_MAJOR_M
from aerial_gnss_ros.core.telemetry.continuity import Continuity, Verdict
from aerial_gnss_ros.core.telemetry.repetition import Repetition, Standing
from aerial_gnss_ros.core.telemetry.validity import unusable, validate
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

FROZEN_S = 10.0
"""Time for which a receiver may repeat one position while the drone moves, s."""

WATER_SETTLE_S = 10.0
"""Time after which a new water level replaces one that contradicts it, s."""

_REPEATS = (
    "it repeats an old value to the last bit under a new stamp, although its samples have noise: "
    "its source has frozen"
)

Place = tuple[float, float]


def distance(one: Place, other: Place) -> float:
    """Return the distance of two positions on a sphere, m, accurate enough for limits.

    Args:
        one: latitude and longitude, rad.
        other: likewise.
    """
    north, east = other[0] - one[0], other[1] - one[1]
    chord = math.sin(0.5 * north) ** 2
    chord += math.cos(one[0]) * math.cos(other[0]) * math.sin(0.5 * east) ** 2
    return 2.0 * SEMI_MAJOR_M * math.asin(min(1.0, math.sqrt(chord)))


def _difference(one: float, other: float) -> float:
    return abs(other - one)


class Plausibility:
    """Tests telemetry samples.

    Args:
        config: limits, and what a fix must provide.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        limits = config.limits
        self._limits = limits
        self._places: Continuity[Place] = Continuity(
            distance, limits.fix_step_m, limits.speed_mps, limits.fix_settle_s, frozen_s=FROZEN_S
        )
        self._water_m = config.water_level.value_m
        self._surface_m = config.surface.altitude
        self._heights = self._vertical(self._height_sees)
        # Without a height the fix's altitude replaces it.
        replaced = config.height.source == "none"
        self._altitudes = self._vertical(self._altitude_sees) if replaced else None
        self._levels: Continuity[float] = Continuity(
            _difference, limits.water_step_m, 0.0, WATER_SETTLE_S
        )
        self._standing = Standing()
        self._repetitions = {Input.ATTITUDE: Repetition(), Input.GIMBAL: Repetition()}
        self._moved = ""

    def _vertical(self, usable: Callable[[float], bool]) -> Continuity[float]:
        limits = self._limits
        step, speed, settle_s = limits.height_step_m, limits.climb_mps, limits.height_settle_s
        return Continuity(_difference, step, speed, settle_s, must_vary=True, usable=usable)

    def _height_sees(self, height: float) -> bool:
        """Return whether a camera at a height, m, sees robots: otherwise it contradicts nothing."""
        return self._limits.height_min_m < height - self._water_m <= self._limits.height_max_m

    def _altitude_sees(self, altitude: float) -> bool:
        """Return the same of an altitude, m, that replaces the height."""
        above_m = altitude - self._surface_m
        return self._limits.height_min_m < above_m <= self._limits.height_max_m

    def pop_relocation(self) -> str:
        """Return, once, a sentence on why earlier samples were from a wrong position.

        Usually empty.
        """
        moved, self._moved = self._moved, ""
        return moved

    @property
    def agreed_s(self) -> float:
        """Time for which fixes have agreed on the drone's position, s."""
        return self._places.lasted_s

    def clear(self) -> None:
        """Discard all samples after a reset of time."""
        self._places.clear()
        self._heights.clear()
        self._levels.clear()
        if self._altitudes is not None:
            self._altitudes.clear()
        self._standing.clear()
        for one in self._repetitions.values():
            one.clear()

    def fix(self, fix: Fix) -> tuple[str, Fix]:
        """Return why a fix is refused (empty: accepted), and the fix, marked if refused."""
        trouble, kept = validate(fix, self._limits)
        trouble = trouble or self._discontinuity(fix) or self._frozen(fix)
        assert isinstance(kept, Fix)  # noqa: S101 - of its own kind
        return trouble, unusable(kept) if trouble else kept

    def orientation(self, source: Input, value: Orientation) -> tuple[str, Orientation]:
        """Return why an orientation is refused, and the orientation, NaN if refused."""
        trouble, kept = validate(value, self._limits)
        assert isinstance(kept, Orientation)  # noqa: S101 - of its own kind
        if trouble:
            return trouble, kept
        if self._repetitions[source].update(value.stamp_ns, value.quaternion.tolist()):
            return _REPEATS, unusable(value)
        return "", kept

    def _frozen(self, fix: Fix) -> str:
        metres = SEMI_MAJOR_M, SEMI_MAJOR_M * math.cos(fix.latitude)
        place = fix.latitude, fix.longitude
        return _REPEATS if self._standing.update(fix.stamp_ns, place, metres) else ""

    def _discontinuity(self, fix: Fix) -> str:
        verdict = self._places.update(fix.stamp_ns, (fix.latitude, fix.longitude))
        if not verdict.accepted:
            return _words("it is", verdict, "limits.speed_mps and fix_step_m")
        if verdict.replaced:
            self._moved = f"The drone is {verdict.distance:,.0f} m from its earlier fixes"
        if self._altitudes is None or not math.isfinite(fix.altitude):
            return ""
        verdict = self._altitudes.update(fix.stamp_ns, fix.altitude)
        if not verdict.accepted:
            return _words("its altitude is", verdict, "limits.climb_mps and height_step_m")
        if verdict.replaced:
            self._moved = f"The fix's altitude is {verdict.distance:.0f} m from what it was before"
        return ""

    def height(self, height: Scalar) -> tuple[str, Scalar]:
        """Return why a height is refused, and the height, NaN if refused."""
        trouble, kept = validate(height, self._limits)
        assert isinstance(kept, Scalar)  # noqa: S101 - of its own kind
        if trouble:
            return trouble, kept
        verdict = self._heights.update(height.stamp_ns, height.value)
        if not verdict.accepted:
            words = _words(f"{height.value:g} m is", verdict, "limits.climb_mps and height_step_m")
            return words, unusable(height)
        if verdict.replaced:
            self._moved = (
                f"The height is {height.value:.1f} m, {verdict.distance:.0f} m from what it was "
                "before"
            )
        return "", kept

    def level(self, level: Scalar) -> str:
        """Return why a water level is refused; it may stay constant."""
        trouble, _ = validate(level, self._limits)
        if trouble:
            return trouble
        verdict = self._levels.update(level.stamp_ns, level.value)
        if verdict.replaced:
            self._moved = f"The water is {verdict.distance:.0f} m from where it was before"
        if verdict.accepted:
            self._water_m = level.value
            return ""
        return (
            f"{level.value:g} m is {verdict.distance:.0f} m from the previous level: water does "
            "not move that fast (limits.water_step_m); if it is right, keep sending it"
        )


def _words(what: str, verdict: Verdict, keys: str) -> str:
    """Return the sentence for a sample that cannot follow the previous one."""
    return (
        f"{what} {verdict.distance:.0f} m from the last accepted one, {verdict.elapsed_s:.2g} s "
        f"before: no platform moves that fast ({keys})"
    )
