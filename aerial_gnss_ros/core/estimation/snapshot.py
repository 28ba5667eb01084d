# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Snapshots of objects' state that can be restored.

The objects themselves stay: their attributes, and the contents of their arrays and containers, are
restored in place, so references to them stay valid. Values of immutable types, including frozen
dataclasses, and the contents of tuples are shared, not copied. Containers hold values of one type.

A snapshot precedes every image, so it must be fast: one loop visits all objects, the treatment of a
class's attributes is determined once for each combination of their types (`Plans`), and `__dict__`
is not used, since Python slows down objects whose dictionary was accessed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import is_dataclass
from enum import Enum
from functools import cached_property
from operator import attrgetter, methodcaller
from typing import Any, NamedTuple

import numpy as np

_SHARED, _ARRAY, _INSTANCE, _FLAT, _NESTED = range(5)
_CONTAINERS = (dict, list, deque, set)


class _Plan(NamedTuple):
    """Indices of the values that must be copied or visited."""

    arrays: tuple[int, ...]
    instances: tuple[int, ...]
    containers: tuple[int, ...]
    nested: tuple[int, ...]


class _Attributes(NamedTuple):
    """Attribute names of a class, and a getter of their values; None for containers."""

    names: tuple[str, ...]
    get: Callable[[Any], tuple[Any, ...]] | None


class Plans(dict[tuple[type, ...], _Plan | None]):
    """Treatment of values by type; None if nothing is to be done.

    Args:
        constant: classes whose instances are skipped, with everything that only they hold.
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
        """Return the getter of an object's attributes, and cache it for its class."""
        kind = type(one)
        found = _Attributes((), None)
        if not issubclass(kind, _CONTAINERS):
            own = [n for n in vars(one) if not isinstance(getattr(kind, n, 0), cached_property)]
            if len(own) == 1:
                own *= 2  # of one name `attrgetter` returns the value, of two a tuple
            found = _Attributes(tuple(own), attrgetter(*own) if own else lambda _: ())
        self.attributes[kind] = found
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
    """The present state of some objects and of all that they hold.

    Args:
        roots: instances with attributes.
        plans: treatment of values by type.
    """

    def __init__(self, roots: tuple[object, ...], plans: Plans) -> None:  # noqa: PLR0912 - quick
        self._objects: list[tuple[Any, tuple[str, ...], tuple[Any, ...]]] = []
        self._arrays: list[Any] = []
        self._containers: list[Any] = []
        arrays, containers, known = self._arrays, self._containers, plans.attributes
        todo: list[Any] = [*roots]
        seen: set[int] = set()
        for one in todo:  # grows during the iteration
            if id(one) in seen:
                continue
            seen.add(id(one))
            kind = type(one)
            names, get = known[kind] if kind in known else plans.look_at(one)
            if get is None:  # a container that is not empty: all of its values have one type
                held: Iterable[Any] = one.values() if isinstance(one, dict) else one
                plan = plans[(type(next(iter(held))),)]
                if plan is None:
                    continue
                if plan.arrays:
                    arrays.extend(held)
                elif plan.instances:
                    todo.extend(held)
                else:
                    containers.extend(held)
                    todo.extend(filter(None, held) if plan.nested else ())
                continue
            try:
                values = get(one)
            except AttributeError:  # it has other attributes than those before it
                names, get = plans.look_at(one)
                values = get(one) if get else ()
            self._objects.append((one, names, values))
            plan = plans[tuple(map(type, values))]
            if plan is None:
                continue
            here, inside, held_here, nested = plan
            for i in here:
                arrays.append(values[i])
            for i in inside:
                todo.append(values[i])  # noqa: PERF401 - slower for one or two
            for i in held_here:
                containers.append(values[i])
            for i in nested:
                if values[i]:
                    todo.append(values[i])  # noqa: PERF401 - likewise
        self._copies = list(map(np.ndarray.copy, arrays))
        self._contents = list(map(methodcaller("copy"), containers))

    def restore(self) -> None:
        """Restore everything."""
        for array, content in zip(self._arrays, self._copies, strict=True):
            array[...] = content
        for held, content in zip(self._containers, self._contents, strict=True):
            held.clear()
            if isinstance(held, dict):
                dict.update(held, content)  # that of a Counter adds
            elif isinstance(held, set):
                held.update(content)
            else:
                held.extend(content)
        for one, names, values in self._objects:
            for name, value in zip(names, values, strict=True):
                setattr(one, name, value)
