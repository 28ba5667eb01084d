# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The cases of `faults.py`: every kind of fault on every input, in pairs, and by name."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from fault_flights import DURATION_S, ROBOTS, Flown, Item, Run, Value, flown
from fault_judge import Row, Verdict, judged, rows_of
from fault_kinds import DAY_NS, INPUTS, KINDS, MEANINGLESS, Change, each, moved, one_of, stamped

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Fix, Scalar
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.sensors import START_NS

BEGIN_S, END_S = 15.0, 20.0
BODY = {"gimbal.reference": "body"}


@dataclass(frozen=True)
class Case:
    """One fault.

    Attributes:
        words: which, such as `fix: jump`.
        changes: what becomes of the messages of each input.
        begin_s, end_s: from when to when, s since the flight's start.
        aboard, sees: of the flight, see `fault_flights.flown`.
        stated: parameters of the estimator.
        wrong: parameters that are part of the fault, which the flight without it lacks.
    """

    words: str
    changes: dict[str, Change] = field(default_factory=dict)
    begin_s: float = BEGIN_S
    end_s: float = END_S
    aboard: str = "gimbal"
    sees: str = "detections"
    stated: dict[str, object] = field(default_factory=dict)
    wrong: dict[str, object] = field(default_factory=dict)

    def items(self, flight: Flown, seed: int) -> list[Item]:
        """Return the messages with the fault, in the order of arrival."""
        start, end = (START_NS + round(t * 1e9) for t in (self.begin_s, self.end_s))
        kept: list[Item] = []
        befallen: dict[str, list[Item]] = {source: [] for source in self.changes}
        for item in flight.items:
            during = item.source in befallen and start <= item.arrival_ns < end
            (befallen[item.source] if during else kept).append(item)
        for source, items in befallen.items():
            if items:
                kept += self.changes[source](items, generator(seed, f"fault {source}"))
        return sorted(kept, key=lambda item: item.arrival_ns)


def matrix() -> Iterator[Case]:
    """Yield every kind of fault on every input by itself."""
    for source in INPUTS:
        for kind, change in KINDS.items():
            if (source, kind) in MEANINGLESS:
                continue
            sees = "images" if source == "images" else "detections"
            yield Case(f"{source}: {kind}", {source: change}, sees=sees)
            if source == "attitude":
                yield Case(f"attitude in use: {kind}", {source: change}, aboard="body", stated=BODY)


PAIRS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("fix", "attitude"): ("absent", "zero", "NaN", "frozen value", "jump", "late"),
    ("attitude", "gimbal"): ("absent", "jump", "slow drift", "frozen value", "noise times ten"),
    ("fix", "height"): ("absent", "zero", "jump", "slow drift", "frozen value"),
    ("gimbal", "height"): ("jump", "frozen value", "absent"),
    ("camera_info", "detections"): ("absent", "late", "out of order", "frozen stamp",
                                    "stamp a day off"),
    ("camera_info", "images"): ("absent", "late", "out of order", "frozen stamp",
                                "stamp a day off"),
    ("fix", "attitude", "gimbal", "height"): ("absent", "late", "zero", "NaN", "frozen value",
                                              "stamp a day off"),
}  # fmt: skip
"""A power dip, an inertial unit or a compass, a receiver that also tells the height, one bus of the
flight controller, one camera driver, the whole telemetry."""


def pairs() -> Iterator[Case]:
    """Yield the faults that befall what belongs together."""
    for sources, kinds in PAIRS.items():
        used = "attitude" in sources
        for kind in kinds:
            yield Case(
                f"{' + '.join(sources)}: {kind}", dict.fromkeys(sources, KINDS[kind]),
                aboard="body" if used else "gimbal", stated=BODY if used else {},
                sees="images" if "images" in sources else "detections",
            )  # fmt: skip


def _fixes(change: Callable[[Fix], Fix]) -> dict[str, Change]:
    def apply(value: Value) -> Value:
        assert isinstance(value, Fix)  # noqa: S101 - of the input fix
        return change(value)

    return {"fix": each(apply)}


def _stuck(height_m: float) -> dict[str, Change]:
    return {"height": each(lambda value: Scalar(value.stamp_ns, height_m))}


def _elsewhere(latitude_deg: float = 0.0, longitude_deg: float = 0.0) -> dict[str, Change]:
    return _fixes(lambda fix: replace(
        fix, latitude=fix.latitude + math.radians(latitude_deg),
        longitude=fix.longitude + math.radians(longitude_deg),
    ))  # fmt: skip


def _stated(variance: float, bias_m: float = 33.0) -> dict[str, Change]:
    covariance = np.diag([variance] * 3)
    return _fixes(lambda fix: replace(moved(fix, bias_m), covariance=covariance))  # type: ignore[type-var]


def _hidden(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return images that show no robot for as long as other faults last."""
    until = items[0].arrival_ns + round((END_S - BEGIN_S) * 1e9) if items else 0
    return [
        item.says(item.value.rows([]))
        if isinstance(item.value, DetectionFrame) and item.arrival_ns < until
        else item
        for item in items
    ]


def _nowhere(fix: Fix) -> Fix:
    return replace(fix, latitude=0.0, longitude=0.0, altitude=0.0)


def named() -> Iterator[Case]:
    """Yield the faults that have a name of their own."""
    for seconds in (0.1, 1.0, 2.0, 5.0):
        yield Case(f"fix: 0, 0 for the first {seconds:g} s", _fixes(_nowhere), -2.0, seconds)
    yield Case("fix: longitude's sign flipped",
               _fixes(lambda fix: replace(fix, longitude=-fix.longitude)))  # fmt: skip
    yield Case("fix: latitude 60 deg off", _elsewhere(60.0))
    swapped = _fixes(lambda fix: replace(fix, latitude=fix.longitude, longitude=fix.latitude))
    yield Case("fix: latitude and longitude swapped", swapped)
    whole = -2.0, DURATION_S + 2.0
    yield Case("fix: longitude 500 all flight",
               _fixes(lambda fix: replace(fix, longitude=math.radians(500.0))), *whole)  # fmt: skip
    for word, value in (("infinite", math.inf), ("NaN", math.nan), ("negative", -1.0)):
        yield Case(f"fix: covariance {word}, 33 m off, all flight", _stated(value), *whole)
    yield Case("fix: jump of 8 m", {"fix": each(lambda value: moved(value, 8.0))})
    for source, size, unit in (("fix", 6.0, "m"), ("height", 5.0, "m"), ("gimbal", 20.0, "deg")):
        yield Case(
            f"{source}: jump of {size:g} {unit} that stays, no robot in view",
            {source: each(partial(moved, by=size)), "detections": _hidden}, end_s=DURATION_S + 2.0,
        )  # fmt: skip
    yield Case("gimbal: jump of 5 deg", {"gimbal": each(lambda value: moved(value, 5.0))})
    yield Case("height: jump of 1 m", {"height": each(lambda value: moved(value, 1.0))})
    for height_m in (0.5, 1.0):
        yield Case(f"height: stuck at {height_m:g} m", _stuck(height_m))
    yield Case("height: one of 1e18",
               {"height": one_of(each(lambda value: Scalar(value.stamp_ns, 1e18)))})  # fmt: skip
    for source in ("fix", "attitude", "gimbal", "camera_info", "detections"):
        for word, shift in (("ahead", DAY_NS), ("behind", -DAY_NS)):
            yield Case(f"{source}: one stamp a day {word}", {source: one_of(stamped(shift))})
    stampable = ("fix", "attitude", "gimbal", "camera_info", "detections")
    yield Case("all: stamps a day off", dict.fromkeys(stampable, stamped(DAY_NS)))
    for degrees in (1.0, 3.0):
        away = {"map.latitude_deg": 13.19 + degrees, "map.longitude_deg": -59.64}
        yield Case(f"map: origin {degrees:g} deg away", {}, *whole, wrong=away)


def cases() -> list[Case]:
    """Return all of them."""
    return [*matrix(), *pairs(), *named()]


_clean: dict[tuple[str, int, str, str], list[Row]] = {}
_begun: dict[tuple[str, int, str, str], tuple[Run, int]] = {}
"""Flights until a second before most faults begin, and how many messages that are."""


def clean_rows(case: Case, kind: str, seed: int) -> list[Row]:
    """Return the positions of a case's flight without the fault; it is flown once."""
    key = kind, seed, case.aboard, case.sees
    if key not in _clean:
        flight = flown(*key)
        until_ns = START_NS + round((BEGIN_S - 1.0) * 1e9)
        count = sum(item.arrival_ns < until_ns for item in flight.items)
        run = Run(flight, case.stated).fly(list(flight.items[:count]), ends=False)
        _begun[key] = run.again(), count
        run.fly(list(flight.items[count:]))
        if run.died or len({row.name for row in rows_of(flight, run.results)}) < ROBOTS:
            raise RuntimeError(f"the {kind} of seed {seed} fails without a fault: {run.died}")
        _clean[key] = rows_of(flight, run.results)
    return _clean[key]


def fly(case: Case, kind: str, seed: int) -> tuple[Verdict, Run]:
    """Fly a case and judge it."""
    clean = clean_rows(case, kind, seed)
    key = kind, seed, case.aboard, case.sees
    flight, (begun, count) = flown(*key), _begun[key]
    items = case.items(flight, seed)
    same = len(items) >= count and all(map(operator.is_, items[:count], flight.items))
    if same and not case.wrong and case.sees == "detections":
        run = begun.again().fly(items[count:])
    else:
        run = Run(flight, case.stated | case.wrong).fly(items)
    return judged(rows_of(flight, run.results), clean, case.begin_s, case.end_s), run
