# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator's door: samples that cannot be true are refused before anything is kept.

`validity` judges each sample by itself, `continuity` and `repetition` those that follow one
another.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.geodesy import SEMI_MAJOR_M
from aerial_gnss_ros.core.telemetry.continuity import Continuity, Verdict
from aerial_gnss_ros.core.telemetry.repetition import Repetition, Standing
from aerial_gnss_ros.core.telemetry.validity import validate
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

FROZEN_S = 10.0
"""A receiver may repeat one position for so long while the drone flies on."""

WATER_SETTLE_S = 10.0
"""Of two levels of the water that contradict each other, the new one counts after this time."""

_REPEATS = (
    "it repeats an old value to the last bit under a new stamp, which its noise does not do: its "
    "source has frozen"
)

Place = tuple[float, float]


def distance(one: Place, other: Place) -> float:
    """Return the distance of two places, m, on a sphere: limits are no matter of metres.

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
    """Judges samples of the telemetry.

    Args:
        config: the limits, and what is needed of a fix.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        limits = config.limits
        self._limits = limits
        self._places: Continuity[Place] = Continuity(
            distance, limits.fix_step_m, limits.speed_mps, limits.fix_settle_s, frozen_s=FROZEN_S
        )
        self._heights = self._vertical()
        # Without a height the fix's altitude stands for it.
        self._altitudes = self._vertical() if config.height.source == "none" else None
        self._levels: Continuity[float] = Continuity(
            _difference, limits.water_step_m, 0.0, WATER_SETTLE_S
        )
        self._standing = Standing()
        self._repetitions = {Input.ATTITUDE: Repetition(), Input.GIMBAL: Repetition()}
        self._moved = ""

    def _vertical(self) -> Continuity[float]:
        limits = self._limits
        step, speed, settle_s = limits.height_step_m, limits.climb_mps, limits.height_settle_s
        return Continuity(_difference, step, speed, settle_s, must_vary=True)

    def pop_relocation(self) -> str:
        """Return why what was seen before was seen from a wrong place, in words, and forget it.

        Empty as a rule.
        """
        moved, self._moved = self._moved, ""
        return moved

    @property
    def agreed_s(self) -> float:
        """For how long fixes have agreed on where the drone is, s."""
        return self._places.lasted_s

    def clear(self) -> None:
        """Forget what came before: time began anew."""
        self._places.clear()
        self._heights.clear()
        self._levels.clear()
        if self._altitudes is not None:
            self._altitudes.clear()
        self._standing.clear()
        for one in self._repetitions.values():
            one.clear()

    def fix(self, fix: Fix) -> tuple[str, Fix]:
        """Return why a fix is no use (empty: it is), and the fix, marked where it is not."""
        trouble, kept = validate(fix, self._limits)
        trouble = trouble or self._discontinuity(fix) or self._frozen(fix)
        assert isinstance(kept, Fix)  # noqa: S101 - of its own kind
        return trouble, replace(kept, valid=False) if trouble else kept

    def orientation(self, source: Input, value: Orientation) -> tuple[str, Orientation]:
        """Return why an orientation is no use, and the orientation, NaN where it is not."""
        trouble, kept = validate(value, self._limits)
        assert isinstance(kept, Orientation)  # noqa: S101 - of its own kind
        if trouble:
            return trouble, kept
        if self._repetitions[source].take(value.stamp_ns, value.quaternion.tolist()):
            return _REPEATS, replace(value, quaternion=np.full(4, np.nan))
        return "", kept

    def _frozen(self, fix: Fix) -> str:
        metres = SEMI_MAJOR_M, SEMI_MAJOR_M * math.cos(fix.latitude)
        place = fix.latitude, fix.longitude
        return _REPEATS if self._standing.take(fix.stamp_ns, place, metres) else ""

    def _discontinuity(self, fix: Fix) -> str:
        verdict = self._places.update(fix.stamp_ns, (fix.latitude, fix.longitude))
        if not verdict.accepted:
            return _words("it is", verdict, "limits.speed_mps and fix_step_m")
        if verdict.replaced:
            self._moved = f"The drone is {verdict.distance:,.0f} m from where its fixes were before"
        if self._altitudes is None or not math.isfinite(fix.altitude):
            return ""
        verdict = self._altitudes.update(fix.stamp_ns, fix.altitude)
        if not verdict.accepted:
            return _words("its altitude is", verdict, "limits.climb_mps and height_step_m")
        if verdict.replaced:
            self._moved = f"The fix's altitude is {verdict.distance:.0f} m from what it was before"
        return ""

    def height(self, height: Scalar) -> tuple[str, Scalar]:
        """Return why a height is no use, and the height, NaN where it is not."""
        trouble, kept = validate(height, self._limits)
        assert isinstance(kept, Scalar)  # noqa: S101 - of its own kind
        if trouble:
            return trouble, kept
        verdict = self._heights.update(height.stamp_ns, height.value)
        if not verdict.accepted:
            words = _words(f"{height.value:g} m is", verdict, "limits.climb_mps and height_step_m")
            return words, replace(height, value=math.nan)
        if verdict.replaced:
            self._moved = (
                f"The height is {height.value:.1f} m, {verdict.distance:.0f} m from what it was "
                "before"
            )
        return "", kept

    def level(self, level: Scalar) -> str:
        """Return why a level of the water is no use; it may stay the same for ever."""
        trouble, _ = validate(level, self._limits)
        if trouble:
            return trouble
        verdict = self._levels.update(level.stamp_ns, level.value)
        if verdict.replaced:
            self._moved = f"The water is {verdict.distance:.0f} m from where it was before"
        if verdict.accepted:
            return ""
        return (
            f"{level.value:g} m is {verdict.distance:.0f} m from the level before it: water does "
            "not move so (limits.water_step_m allows less); if it is right, go on sending it"
        )


def _words(what: str, verdict: Verdict, keys: str) -> str:
    """Return why a sample cannot have followed the one before it."""
    return (
        f"{what} {verdict.distance:.0f} m from the last one that counts, {verdict.elapsed_s:.2g} s "
        f"before: no platform moves so ({keys} allow less)"
    )
