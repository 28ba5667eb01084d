# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All telemetry at the time of one scene, or what is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from aerial_gnss_ros.core.telemetry.interpolation_error import Uncertain
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation


@dataclass(frozen=True)
class SceneTelemetry:
    """All telemetry at the time of one scene; None for inputs that the configuration does not need.

    Attributes:
        stamp_ns: time of the scene, ns.
        fix: position of the antenna.
        attitude: body FLU in ENU (or in magnetic ENU).
        gimbal: camera FLU in the gimbal's reference.
        height: above the height's reference, m.
        water_level: above the same reference, m.
        oldest_age_s: largest distance in time to a sample used, s.
        uncertain: errors of interpolated values, by input.
    """

    stamp_ns: int
    fix: Fix
    attitude: Orientation | None
    gimbal: Orientation | None
    height: float | None
    water_level: float
    oldest_age_s: float
    uncertain: Mapping[Input, Uncertain] = field(default_factory=dict)


@dataclass(frozen=True)
class MissingTelemetry:
    """Why there is no telemetry for a scene.

    Attributes:
        reason: the refusal, with the input's name.
        can_arrive: whether waiting makes sense.
        later_s: time from the scene to the input's oldest sample, s; 0 if that is not the reason.
    """

    reason: Reason
    can_arrive: bool
    later_s: float = 0.0
