# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Targets in flight: damaged fields, bytes, order and times of everything that the topics bring."""

from __future__ import annotations

import contextlib
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from aerial_gnss_ros.adapters.results import result_messages
from aerial_gnss_ros.bags.typestore import serialize
from aerial_gnss_ros.core.values.estimates import FrameResult
from fuzz import mutate
from fuzz.checks import check, check_log
from fuzz.flight import TICKS_PER_S, WARM_S, Arrival, Phantoms, flown, in_flight, truth
from fuzz.types import typestore
from fuzz.vehicles import VEHICLES

Report = Callable[[str], None]
Change = Callable[[Arrival, random.Random, Report], tuple[Any, int] | None]
"""Returns the message to hand over and when it comes; None: it is lost."""
Damage = Callable[[random.Random, Arrival], tuple[Change, str]]
"""Makes the change of a case, and tells it in words."""

_NAMES = tuple(VEHICLES)


class Flying:
    """One aircraft with what was done to it.

    Args:
        vehicle: its name.
    """

    def __init__(self, vehicle: str) -> None:
        self.vehicle = vehicle
        self.ticks = flown(vehicle)
        self.tick = round(WARM_S * TICKS_PER_S)
        self._aircraft = in_flight(vehicle)
        self._truth = truth(VEHICLES[vehicle].flight) if VEHICLES[vehicle].judged else None
        self._phantoms = Phantoms(vehicle)
        self._places = self._phantoms.places
        self._last: FrameResult | None = None

    def feed(self, arrival: Arrival, message: Any, log_ns: int) -> None:
        """Hand over a message in the place of one that was to come, and judge what comes of it."""
        if arrival.name == "detections" and message is not arrival.message:
            self._phantoms.add(self.tick, message, arrival.message)
            self._places = self._phantoms.places
        for result in self._aircraft.feed(arrival.name, message, log_ns):
            check(result, self._truth, self._places)
            self._last = result

    def publish(self, messages: bool) -> None:
        """Do with the last result, and with what diagnostics show, what nodes do."""
        if messages and self._last is not None:
            for message in result_messages(self._last):
                serialize(message.msgtype, message.fields)
        self._last = None
        engine = self._aircraft.estimator
        _ = engine.inputs, engine.robots, engine.health
        check_log(engine.take_events(), engine.happened["images_failed"])


class InFlight:
    """Cases that follow one another in a flight with three tracked robots.

    Args:
        name: of the target.
        weight: share of the cases.
        damage: makes the change of a case.
        inputs: that are damaged; empty: all.
    """

    block = 40

    def __init__(
        self,
        name: str,
        weight: int,
        damage: Damage,
        inputs: tuple[str, ...] = (),
    ) -> None:
        self.name, self.weight = name, weight
        self._damage, self._inputs = damage, inputs
        self._flying: Flying | None = None

    def begin(self, block: int, _rng: random.Random) -> None:
        """Take the next vehicle, in flight."""
        self._flying = Flying(_NAMES[block % len(_NAMES)])

    def case(self, rng: random.Random, report: Report) -> None:
        """Damage one input for an image or some, and let some good ones follow."""
        flying = self._flying
        assert flying is not None  # noqa: S101 - begin() came first
        lasts = 1 if rng.random() < 0.9 else rng.randrange(2, 13)
        after = 0 if rng.random() < 0.6 else rng.randrange(1, 4)
        images = flying.ticks[flying.tick : flying.tick + lasts + after]
        if not images:
            return
        name = rng.choice(self._inputs or sorted({arrival.name for arrival in images[0]}))
        chosen = rng.choice([arrival for arrival in images[0] if arrival.name == name])
        seed = rng.random()  # every message of the case is damaged alike
        change, words = self._damage(random.Random(seed), chosen)
        report(f"{flying.vehicle}, image {flying.tick}, {lasts} images: {name} {words}")
        for k, image in enumerate(images):
            for arrival in image:
                if k < lasts and arrival.name == name and (lasts > 1 or arrival is chosen):
                    changed = change(arrival, random.Random(seed), report)
                    if changed is not None:
                        flying.feed(arrival, *changed)
                else:
                    flying.feed(arrival, arrival.message, arrival.log_ns)
            flying.tick += 1
        flying.publish(rng.random() < 0.2)


# --- fields ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Leaf:
    """A field that holds no message.

    Attributes:
        path: attributes and indices from the message.
        kind: such as float64; `[float64]` is an array, `<name>` an array of messages.
        fixed: length of an array that cannot have another; 0: any.
    """

    path: tuple[str | int, ...]
    kind: str
    fixed: int = 0


def leaves(msgtype: str, message: Any, path: tuple[str | int, ...] = ()) -> list[Leaf]:
    """Return all fields of a message."""
    found: list[Leaf] = []
    fields: list[tuple[str, Any]] = list(typestore().fielddefs[msgtype][1])
    for name, (kind, inner) in fields:
        here = (*path, name)
        value = getattr(message, name)
        if kind == Nodetype.BASE:
            found.append(Leaf(here, inner[0]))
        elif kind == Nodetype.NAME:
            found += leaves(inner, value, here)
        else:
            (element_kind, element), length = inner
            fixed = length if kind == Nodetype.ARRAY else 0
            if element_kind == Nodetype.NAME:
                found.append(Leaf(here, f"<{element}>", fixed))
                for i, item in enumerate(value):
                    found += leaves(element, item, (*here, i))
            else:
                found.append(Leaf(here, f"[{element[0]}]", fixed))
    return found


def _reach(message: Any, path: tuple[str | int, ...]) -> Any:
    for step in path:
        message = message[step] if isinstance(step, int) else getattr(message, step)
    return message


def set_field(rng: random.Random, message: Any, leaf: Leaf) -> str:
    """Change a field; return what it became, in words."""
    *above, last = leaf.path
    holder = _reach(message, tuple(above))
    value = getattr(holder, str(last))
    changed = _changed(rng, value, leaf)
    setattr(holder, str(last), changed)
    return f"{'.'.join(map(str, leaf.path))} = {str(changed)[:60]!r}"


def _changed(rng: random.Random, value: Any, leaf: Leaf) -> Any:
    kind = leaf.kind
    if kind.startswith("<"):
        return _other_items(rng, list(value))
    if kind.startswith("["):
        return _other_array(rng, value, kind[1:-1], leaf.fixed)
    if kind in ("float64", "float32"):
        return _as_float(mutate.number(rng, float(value)), kind)
    if kind == "bool":
        return not value
    if kind in ("string", "wstring"):
        return mutate.text(rng, value)
    return mutate.whole(rng, int(value), kind)


def _as_float(value: float, kind: str) -> float:
    with np.errstate(over="ignore"):
        return float(np.float32(value)) if kind == "float32" else value


def _other_items(rng: random.Random, items: list[Any]) -> list[Any]:
    way = rng.randrange(4)
    if way == 0 or not items:
        return []
    if way == 1:
        return items[:-1]
    return items * (2 if way == 2 else rng.randrange(3, 40))


def _other_array(rng: random.Random, value: Any, kind: str, fixed: int) -> Any:
    if kind in ("string", "wstring"):
        return [mutate.text(rng, item) for item in value]
    array = np.array(value)
    if not fixed and rng.random() < 0.3:
        count = rng.choice((0, 1, 4, 5, 8, 12, 14, 1000))
        array = np.resize(array, count) if len(array) else np.zeros(count, array.dtype)
    if not len(array):
        return array
    places = range(len(array)) if rng.random() < 0.3 else (rng.randrange(len(array)),)
    for place in places:
        old = array[place]
        with np.errstate(over="ignore"):
            array[place] = (
                mutate.number(rng, float(old)) if kind.startswith("float")
                else mutate.whole(rng, int(old), kind)
            )  # fmt: skip
    return array


def _fields(many: int) -> Damage:
    def damage(rng: random.Random, chosen: Arrival) -> tuple[Change, str]:
        if rng.random() < 0.12:
            return _travel(rng)
        every = leaves(chosen.msgtype, chosen.message)
        stamps = [leaf for leaf in every if {"stamp", "timestamp"} & set(leaf.path)]
        count = 1 if many == 1 else rng.randrange(1, many + 1)
        pools = [stamps if stamps and rng.random() < 0.2 else every for _ in range(count)]
        targets = [rng.choice(pool) for pool in pools]

        def change(arrival: Arrival, own: random.Random, report: Report) -> tuple[Any, int]:
            message = typestore().deserialize_cdr(arrival.raw, arrival.msgtype)
            for leaf in targets:
                with contextlib.suppress(IndexError):  # a list has fewer items here
                    report(set_field(own, message, leaf))
            return message, arrival.log_ns

        return change, ""

    return damage


def _travel(rng: random.Random) -> tuple[Change, str]:
    """Lose a message, send it twice, or let it come at another time."""
    way = rng.randrange(3)
    if way == 0:
        return lambda _arrival, _own, _report: None, "is lost"
    shift = rng.choice((-(10**18), -(10**10), -(10**8), 10**8, 10**9, 10**10, 10**14, 10**18))
    if way == 1:
        return lambda a, _own, _report: (a.message, a.log_ns + shift), f"comes {shift:g} ns later"
    return lambda a, _own, _report: (a.message, -a.log_ns), "comes at a negative time"


# --- bytes -----------------------------------------------------------------------------------


def _octets(_rng: random.Random, chosen: Arrival) -> tuple[Change, str]:
    def change(arrival: Arrival, own: random.Random, _report: Report) -> tuple[Any, int] | None:
        raw = mutate.octets(own, arrival.raw, chosen.raw)
        try:
            return typestore().deserialize_cdr(raw, arrival.msgtype), arrival.log_ns
        except Exception:  # noqa: BLE001 - the middleware refuses it: it never comes
            return None

    return change, "bytes"


def targets() -> list[InFlight]:
    """Return the targets in flight."""
    return [
        InFlight("messages", 24, _fields(1)),
        InFlight("combined", 8, _fields(4)),
        InFlight("bytes", 14, _octets),
        InFlight("camera_info", 5, _fields(4), ("camera_info",)),
    ]
