# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What objects hold at a time, so that they can be put back to it.

The objects themselves stay: their attributes, and the contents of the arrays and containers that
they hold, are put back in place, so whatever refers to them goes on to. Values of immutable types,
frozen dataclasses among them, are shared and not copied; so is whatever a tuple holds. Containers
hold values of one type.

A snapshot precedes every image, so it must be quick: what is to be done with the attributes of a
class is worked out once for each combination of their types (`Plans`), and `__dict__` is left
alone, since Python slows down objects whose dictionary was asked for.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import is_dataclass
from enum import Enum
from functools import cached_property
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

_SHARED, _ARRAY, _INSTANCE, _FLAT, _NESTED = range(5)
_CONTAINERS = (dict, list, deque, set)


class _Plan(NamedTuple):
    """Places, among some values, of what must be copied or gone into."""

    arrays: tuple[int, ...]
    instances: tuple[int, ...]
    containers: tuple[int, ...]
    nested: tuple[int, ...]


class _Attributes(NamedTuple):
    """Of the instances of a class: names, and what returns their values."""

    names: tuple[str, ...]
    get: Callable[[Any], tuple[Any, ...]]


class Plans(dict[tuple[type, ...], _Plan | None]):
    """How values are kept, by their types; None where there is nothing to be done.

    Args:
        constant: classes whose instances are left alone, with all that only they hold.
    """

    def __init__(self, constant: tuple[type, ...] = ()) -> None:
        super().__init__()
        self._constant = constant
        self.attributes: dict[type, _Attributes] = {}

    def __missing__(self, types: tuple[type, ...]) -> _Plan | None:
        kinds = [self._kind(one) for one in types]
        places = [[i for i, kind in enumerate(kinds) if kind == one] for one in range(1, 5)]
        arrays, instances, flat, nested = map(tuple, places)
        plan = _Plan(arrays, instances, flat + nested, nested) if any(kinds) else None
        self[types] = plan
        return plan

    def look_at(self, one: object) -> _Attributes:
        """Return how to have the attributes of an object, and note it for its class."""
        kind = type(one)
        names = tuple(n for n in vars(one) if not isinstance(getattr(kind, n, 0), cached_property))
        get = attrgetter(*names) if names else lambda _: ()
        if len(names) == 1:
            get = _alone(get)
        self.attributes[kind] = found = _Attributes(names, get)
        return found

    def _kind(self, one: type) -> int:
        if issubclass(one, np.ndarray):
            return _ARRAY
        if issubclass(one, _CONTAINERS):
            return _FLAT if issubclass(one, set) else _NESTED
        frozen = is_dataclass(one) and one.__dataclass_params__.frozen  # type: ignore[attr-defined]
        if frozen or issubclass(one, (*self._constant, tuple, str, Enum, np.generic)):
            return _SHARED
        return _INSTANCE if one.__dictoffset__ and one.__module__ != "builtins" else _SHARED


class Snapshot:
    """The state of some objects, and of all that they hold, as of now.

    Args:
        roots: instances with attributes.
        plans: how values are kept.
    """

    def __init__(self, roots: tuple[object, ...], plans: Plans) -> None:
        self._found = found = _Found([], [], [*roots])
        self._values: list[tuple[tuple[str, ...], tuple[Any, ...]]] = []
        kept = self._values
        seen: set[int] = set()
        known = plans.attributes
        arrays, containers, instances = found
        for one in instances:  # grows while it is gone through
            if id(one) in seen:
                kept.append(((), ()))
                continue
            seen.add(id(one))
            kind = type(one)
            own = known[kind] if kind in known else plans.look_at(one)
            try:
                values = own.get(one)
            except AttributeError:  # it has other attributes than those before it
                own = plans.look_at(one)
                values = own.get(one)
            kept.append((own.names, values))
            plan = plans[tuple(map(type, values))]
            if plan is None:
                continue
            here, inside, held, nested = plan
            for i in here:
                arrays.append(values[i])
            for i in inside:
                instances.append(values[i])
            for i in held:
                containers.append(values[i])
            for i in nested:
                if values[i]:
                    _look_into(values[i], plans, found)
        self._arrays = [array.copy() for array in arrays]
        self._contents = [container.copy() for container in containers]

    def restore(self) -> None:
        """Put everything back."""
        found = self._found
        for array, content in zip(found.arrays, self._arrays, strict=True):
            array[...] = content
        for held, content in zip(found.containers, self._contents, strict=True):
            held.clear()
            if isinstance(held, dict):
                dict.update(held, content)  # that of a Counter adds
            elif isinstance(held, set):
                held.update(content)
            else:
                held.extend(content)
        for one, (names, values) in zip(found.instances, self._values, strict=True):
            for name, value in zip(names, values, strict=True):
                setattr(one, name, value)


class _Found(NamedTuple):
    """What is kept, as far as it is found."""

    arrays: list[Any]
    containers: list[Any]
    instances: list[Any]


def _alone(get: Callable[[Any], Any]) -> Callable[[Any], tuple[Any, ...]]:
    return lambda one: (get(one),)


def _look_into(container: Any, plans: Plans, found: _Found) -> None:
    """Note what a list, a deque or the values of a dict hold."""
    values: Iterable[Any] = container.values() if isinstance(container, dict) else container
    plan = plans[(type(next(iter(values))),)]
    if plan is None:
        return
    if plan.arrays:
        found.arrays.extend(values)
    elif plan.instances:
        found.instances.extend(values)
    else:
        found.containers.extend(values)
        if plan.nested:
            for value in values:
                if value:
                    _look_into(value, plans, found)
