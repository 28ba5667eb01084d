# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several simulated drones over the same robots: formations, and receivers that err in common."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.sensors import SensorPlan, SharedGnss

MOST_DRONES = 8
NAMES = "abcdefgh"
BESIDE = math.radians(20.0)
"""Angle, seen from the robots, between two drones that fly side by side, rad."""
FAR = 4.0
"""Stand-off of a far drone, as a multiple of the first one's stand-off or height."""
ABOVE = 1.3
"""Height of a drone above, as a multiple of that of the drone before it."""
SEED_STEP = 1_000_003
"""Between the seeds of two drones of one formation: a prime, so that seeds nearby do not meet."""


def _opposite(plan: FlightPlan, k: int, count: int) -> FlightPlan:
    return replace(plan, bearing=(plan.bearing or 0.0) + 2.0 * math.pi * k / count)


def _beside(plan: FlightPlan, k: int, count: int) -> FlightPlan:
    del count
    return replace(plan, bearing=(plan.bearing or 0.0) + BESIDE * k)


def _above(plan: FlightPlan, k: int, count: int) -> FlightPlan:
    del count
    if not k:
        return plan
    high = plan.height_m * ABOVE**k
    return replace(plan, kind="hover", height_m=high, tilt=math.pi / 2, stand_off_m=0.0)


def _far(plan: FlightPlan, k: int, count: int) -> FlightPlan:
    del count
    if not k:
        return plan
    away = FAR * max(plan.stand_off, plan.height_m)
    return replace(plan, bearing=(plan.bearing or 0.0) + 0.5 * math.pi * k, stand_off_m=away)


FORMATIONS: dict[str, Callable[[FlightPlan, int, int], FlightPlan]] = {
    "opposite": _opposite,
    "beside": _beside,
    "above": _above,
    "far": _far,
}
"""Plan of drone k of some drones, from that of the first, by the formation's name."""


@dataclass(frozen=True)
class Formation:
    """How several drones fly.

    Attributes:
        kind: `opposite` (evenly around the robots), `beside` (20 deg apart as seen from them),
            `above` (the others hover above them) or `far` (the others at four times the distance,
            so that they see them at a grazing angle).
        count: number of drones.
        share: part of the variance of receivers' offsets that is common to all, 0 to 1.
    """

    kind: str = "opposite"
    count: int = 2
    share: float = 0.5

    def __post_init__(self) -> None:
        if self.kind not in FORMATIONS:
            raise ConfigError(f"a formation is one of {', '.join(FORMATIONS)}, not {self.kind!r}.")
        if not 1 <= self.count <= MOST_DRONES:
            raise ConfigError(f"1 to {MOST_DRONES} drones fly together, not {self.count}.")


def flights(plan: FlightPlan, formation: Formation, seed: int) -> list[GeneratedFlight]:
    """Return the drones' flights; the first is that of a drone alone.

    Args:
        plan: of the first drone.
        formation: how the others fly.
        seed: of the flights.
    """
    first = GeneratedFlight(plan, seed)
    plan = replace(plan, bearing=first.bearing, turn=first.turn)
    of = FORMATIONS[formation.kind]
    others = [
        GeneratedFlight(of(plan, k, formation.count), seed + SEED_STEP * k)
        for k in range(1, formation.count)
    ]
    return [first, *others]


def together(
    first: Callable[[GeneratedFlight, Sequence[GeneratedFlight]], Experiment],
    plan: FlightPlan,
    formation: Formation,
    seed: int,
    sensors: Sequence[SensorPlan] = (),
) -> dict[str, Experiment]:
    """Return the flights of several drones over the same robots, by the drones' names a, b, ...

    Args:
        first: returns the experiment of the first drone from its flight and those of the others.
        plan: of the first drone's flight.
        formation: how the others fly.
        seed: of all random numbers.
        sensors: plans of the drones' sensors; none: all have those of the first.

    Raises:
        InputError: a camera sees no water close enough.
    """
    flown = flights(plan, formation, seed)
    lead = first(flown[0], flown[1:])
    plans = list(sensors) or [lead.sensors_plan] * formation.count
    best = min(plan.sigmas["gnss_offset_m"] for plan in plans)
    common = SharedGnss(seed + SEED_STEP * MOST_DRONES, formation.share, best)
    made: dict[str, Experiment] = {}
    for k, (flight, own) in enumerate(zip(flown, plans, strict=True)):
        one = replace(
            lead,
            flight=flight,
            sensors_plan=replace(own, shared=common) if formation.count > 1 else own,
            places=lead.places,
            distractors=0 if k else lead.distractors,
            seed=seed + SEED_STEP * k,
            world_seed=seed,
            others=(),
        )
        if k:
            one.distractors, one.props = lead.distractors, lead.props
        made[NAMES[k]] = one
    return made
