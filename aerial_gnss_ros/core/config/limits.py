# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Limits of plausible telemetry: samples beyond are refused as bad_<input>."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key


@dataclass(frozen=True)
class LimitsConfig:
    """Physical limits of the inputs; samples beyond are refused as bad_fix or bad_height."""

    speed_mps: float = key(
        100.0,
        "Greatest speed over ground of the platform. A fix farther from the previous one than this "
        "speed and fix_step_m allow is refused.",
        unit="m/s",
        low=1.0,
        high=400.0,
    )
    fix_step_m: float = key(
        50.0,
        "Greatest instantaneous jump of a fix that is admitted: receivers jump when they lose or "
        "regain corrections. The filter handles smaller jumps.",
        unit="m",
        low=1.0,
        high=10000.0,
    )
    fix_settle_s: float = key(
        60.0,
        "Of two contradictory places, the one with fixes for longer is used; the new one always "
        "after this time. A smaller value accepts a receiver that fails for that long.",
        unit="s",
        low=3.0,
        high=3600.0,
    )
    fix_sigma_m: float = key(
        1000.0,
        "A fix that states a larger standard deviation is refused: receivers send such values "
        "while they have no fix.",
        unit="m",
        low=10.0,
        high=100000.0,
    )
    null_island_m: float = key(
        10.0,
        "A fix nearer to latitude 0, longitude 0 is refused: receivers send zeros while they "
        "have no fix. 0 refuses nothing there.",
        unit="m",
        low=0.0,
        high=10000.0,
    )
    climb_mps: float = key(
        20.0,
        "Greatest climb or descent rate of the platform. A height farther from the previous one "
        "than this rate and height_step_m allow is refused.",
        unit="m/s",
        low=0.5,
        high=200.0,
    )
    height_step_m: float = key(
        5.0,
        "Greatest instantaneous jump of the height that is admitted, as over a pier or a boat.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    height_settle_s: float = key(
        10.0,
        "Of two contradictory heights, the one received for longer is used; the new one always "
        "after this time, unless it repeats one exact value.",
        unit="s",
        low=3.0,
        high=3600.0,
    )
    water_step_m: float = key(
        5.0,
        "Greatest difference of a water level from the previous one, as by waves at a gauge. "
        "Levels that differ more are refused until they have been received for longer than the "
        "others were, 3 to 10 s.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    height_min_m: float = key(
        0.5,
        "Heights above the water up to this are refused: no camera sees robots from there, and "
        "range finders send such values when they measure nothing.",
        unit="m",
        low=0.0,
        high=100.0,
    )
    height_max_m: float = key(
        10000.0,
        "Heights beyond this are refused, above as well as below their reference.",
        unit="m",
        low=1.0,
        high=50000.0,
    )
    origin_distance_m: float = key(
        20000.0,
        "Fixes farther from the origin of map are refused: its flat axes distort positions there "
        "by 1 m. A configured origin that far from the flight is an error.",
        unit="m",
        low=1000.0,
        high=100000.0,
    )
