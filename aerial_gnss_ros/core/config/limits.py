# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of what no platform can do: samples beyond are refused as bad_<input>."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key


@dataclass(frozen=True)
class LimitsConfig:
    """Physical limits of the inputs: what lies beyond is refused as bad_fix or bad_height."""

    speed_mps: float = key(
        100.0,
        "Fastest speed over ground of the platform. A fix farther from the one before than this "
        "speed and fix_step_m allow is refused.",
        unit="m/s",
        low=1.0,
        high=400.0,
    )
    fix_step_m: float = key(
        50.0,
        "A fix may jump by this much at once: receivers do when they lose or regain corrections. "
        "The filter judges smaller jumps.",
        unit="m",
        low=1.0,
        high=10000.0,
    )
    fix_settle_s: float = key(
        60.0,
        "Where two places contradict each other, the one where fixes came for longer counts; the "
        "new one always after this time. Less believes a receiver that fails for as long.",
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
        "Fastest climb or descent of the platform. A height farther from the one before than this "
        "speed and height_step_m allow is refused.",
        unit="m/s",
        low=0.5,
        high=200.0,
    )
    height_step_m: float = key(
        5.0,
        "A height may jump by this much at once, as over a pier or a boat.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    height_settle_s: float = key(
        10.0,
        "Where two heights contradict each other, the one that came for longer counts; the new "
        "one always after this time, unless it repeats one exact value.",
        unit="s",
        low=3.0,
        high=3600.0,
    )
    water_step_m: float = key(
        5.0,
        "A water level may differ by this much from the one before it, as by waves at a gauge. One "
        "that differs by more is refused until such levels have come for longer than the others "
        "had, 3 to 10 s.",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    height_min_m: float = key(
        0.5,
        "A height above the water of this or less is refused: no camera sees robots from there, "
        "and range finders send it when they see nothing.",
        unit="m",
        low=0.0,
        high=100.0,
    )
    height_max_m: float = key(
        10000.0,
        "A height that is larger is refused, and so is one so far below its reference.",
        unit="m",
        low=1.0,
        high=50000.0,
    )
    origin_distance_m: float = key(
        20000.0,
        "Fixes farther from the origin of map are refused: positions there are wrong by 1 m by its "
        "flat axes. A configured origin that far from the flight is an error.",
        unit="m",
        low=1000.0,
        high=100000.0,
    )
