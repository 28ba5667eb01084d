# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Snapshots of objects' state that can be restored.

The objects themselves stay: their attributes, and the contents of their arrays and containers, are
restored in place, so references to them stay valid. Values of immutable types, including frozen
dataclasses, and the contents of tuples are shared, not copied. Containers hold values of one type,
arrays numbers: these are kept as bytes, which take a fifth of the time of copied arrays.

A snapshot precedes every image, so it must be fast. Objects that attributes hold are nearly always
those of the snapshot before: their values are kept in one row, and only if a type or an object
differs the tree is walked again (`Plans.layout`). A row takes a tenth of the memory of copied
dictionaries, which would displace what the estimation needs from the processor's cache.

Python makes an object's `__dict__` when it is accessed for the first time, with keys that the
instances of its class share. From then on its attributes take five times as long to read (CPython
3.11), so the walk replaces it by a dictionary with keys of its own.

Objects in containers come and go, except those of a list that holds the same ones as before. The
treatment of a class's attributes is determined once for each combination of their types, and their
`__dict__` is not used.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import is_dataclass
from enum import Enum
from functools import cached_property
from itertools import chain
from operator import attrgetter, is_
from typing import Any, NamedTuple

import numpy as np

_SHARED, _ARRAY, _INSTANCE, _FLAT, _NESTED = range(5)
_CONTAINERS = (dict, list, deque, set)
Values = tuple[Any, ...]


class _Plan(NamedTuple):
    """Indices of the values that must be copied or visited."""

    arrays: tuple[int, ...]
    instances: tuple[int, ...]
    dicts: tuple[int, ...]
    others: tuple[int, ...]
    nested: tuple[int, ...]


class _Attributes(NamedTuple):
    """Attribute names of a class, and a getter of their values."""

    names: tuple[str, ...]
    get: Callable[[Any], Values]


class _Layout(NamedTuple):
    """Objects reached through attributes alone, and the treatment of all their values in a row.

    Attributes:
        roots: where the walk began.
        states: `__dict__` of each object, in the order of the walk.
        names: of the attributes in each.
        types: of the values.
        plan: of these.
        inner: the objects at `plan.instances`.
        held: lists in the row whose objects are among `states`, by index, and these objects.
        ids: of all objects.
        plain: indices of containers known to hold nothing that must be copied or visited.
    """

    roots: Values
    states: list[dict[str, Any]]
    names: list[tuple[str, ...]]
    types: list[type]
    plan: _Plan
    inner: list[Any]
    held: list[tuple[int, list[Any]]]
    ids: frozenset[int]
    plain: set[int]


class Plans(dict[tuple[type, ...], _Plan | None]):
    """Treatment of values by type; None if nothing is to be done.

    Args:
        constant: classes whose instances are skipped, with everything that only they hold.
        rebound: classes of objects in containers that change only by assignment to attributes:
            what these hold is not changed in place, so it is shared.
    """

    def __init__(self, constant: tuple[type, ...] = (), rebound: tuple[type, ...] = ()) -> None:
        super().__init__()
        self._constant = constant
        self.rebound = rebound
        self.attributes: dict[type, _Attributes] = {}
        self._layout: _Layout | None = None

    def __missing__(self, types: tuple[type, ...]) -> _Plan | None:
        plan = self._plan(types)
        self[types] = plan if any(plan) else None
        return self[types]

    def _plan(self, types: tuple[type, ...]) -> _Plan:
        kinds = [self._kind(one) for one in types]
        places = [[i for i, kind in enumerate(kinds) if kind == one] for one in range(1, 5)]
        arrays, instances, flat, nested = map(tuple, places)
        dicts = tuple(i for i in nested if issubclass(types[i], dict))
        others = tuple(i for i in flat + nested if not issubclass(types[i], dict))
        return _Plan(arrays, instances, dicts, others, nested)

    def read(self, one: object) -> tuple[_Attributes, Values]:
        """Return an object's attributes and their values."""
        kind = type(one)
        if kind in self.attributes:
            found = self.attributes[kind]
            try:
                return found, found.get(one)
            except AttributeError:  # it has other attributes than those before it
                pass
        own = [n for n in vars(one) if not isinstance(getattr(kind, n, 0), cached_property)]
        if len(own) == 1:
            own *= 2  # of one name `attrgetter` returns the value, of two a tuple
        found = _Attributes(tuple(own), attrgetter(*own) if own else lambda _: ())
        self.attributes[kind] = found
        return found, found.get(one)

    def layout(self, roots: Values) -> tuple[_Layout, list[Any]]:
        """Return the objects that attributes hold, and the values of all in a row."""
        known = self._layout
        if known is not None and all(map(is_, roots, known.roots)):
            row = list(chain.from_iterable(map(dict.values, known.states)))
            inner = map(row.__getitem__, known.plan.instances)
            if list(map(type, row)) == known.types and all(map(is_, inner, known.inner)):
                for i, held in known.held:
                    if len(row[i]) != len(held) or not all(map(is_, row[i], held)):
                        break
                else:
                    return known, row
        self._layout = self._walk(roots)
        return self.layout(roots)

    def _walk(self, roots: Values) -> _Layout:
        objects, seen, row = [*roots], {id(one) for one in roots}, list[Any]()
        lists: list[tuple[int, list[Any]]] = []
        for one in objects:  # grows during the iteration
            one.__dict__ = dict(vars(one))  # of its own: see the module
            for value in vars(one).values():
                found = [value] if self._kind(type(value)) == _INSTANCE else []
                if self._keeps(value):
                    found = [*value]
                    lists.append((len(row), found))
                row.append(value)
                for each in found:
                    if id(each) not in seen:
                        seen.add(id(each))
                        objects.append(each)
        types = list(map(type, row))
        plan, states = self._plan(tuple(types)), [vars(one) for one in objects]
        inner = [row[i] for i in plan.instances]
        names = list(map(tuple, states))
        plain = {i for i, _ in lists}
        return _Layout(roots, states, names, types, plan, inner, lists, frozenset(seen), plain)

    def _keeps(self, value: Any) -> bool:
        """Return whether a list holds objects that are nearly always those of before."""
        if type(value) is not list or not value:
            return False
        kind = type(value[0])
        return kind not in self.rebound and self._kind(kind) == _INSTANCE

    def _kind(self, one: type) -> int:
        if issubclass(one, np.ndarray):
            return _ARRAY
        if issubclass(one, _CONTAINERS):
            return _FLAT if issubclass(one, set) else _NESTED
        frozen = is_dataclass(one) and one.__dataclass_params__.frozen  # type: ignore[attr-defined]
        if frozen or issubclass(one, (*self._constant, tuple, str, Enum, np.generic)):
            return _SHARED
        return _INSTANCE if one.__dictoffset__ and one.__module__ != "builtins" else _SHARED


def _content(held: Any) -> type:
    """Return the type of what a container that is not empty holds: all of it has one type."""
    return type(next(iter(held.values() if isinstance(held, dict) else held)))


class Snapshot:
    """The present state of some objects and of all that they hold.

    Args:
        roots: instances with attributes.
        plans: treatment of values by type.
    """

    def __init__(self, roots: Values, plans: Plans) -> None:
        layout, row = plans.layout(roots)
        self._layout, self._row = layout, row
        self._objects: list[tuple[list[Any], tuple[str, ...], list[Values]]] = []
        value, plan, plain = row.__getitem__, layout.plan, layout.plain
        self._arrays: list[Any] = list(map(value, plan.arrays))
        self._dicts: list[Any] = list(map(value, plan.dicts))
        self._others: list[Any] = list(map(value, plan.others))
        todo: list[Any] = []
        for i in plan.nested:
            if i not in plain and row[i]:
                if plans[(_content(row[i]),)] is None:
                    plain.add(i)
                else:
                    todo.append(row[i])
        self._visit(todo, set(layout.ids), plans)
        self._numbers = list(map(np.ndarray.tobytes, self._arrays))
        self._items = list(map(dict.copy, self._dicts))
        self._contents = list(map(tuple, self._others))

    def _visit(self, todo: list[Any], seen: set[int], plans: Plans) -> None:
        """Visit containers that are not empty, and what they hold."""
        for one in todo:  # grows during the iteration
            if id(one) in seen:
                continue
            seen.add(id(one))
            if isinstance(one, _CONTAINERS):
                kind = _content(one)
                plan = plans[(kind,)]
                if plan is None:
                    continue
                held = [*one.values()] if isinstance(one, dict) else [*one]
                if kind in plans.rebound:
                    own, _ = plans.read(held[0])
                    self._objects.append((held, own.names, list(map(own.get, held))))
                elif plan.arrays:
                    self._arrays += held
                elif plan.instances:
                    todo.extend(held)
                else:
                    inner = self._dicts if plan.dicts else self._others
                    inner += held
                    todo.extend(filter(None, held) if plan.nested else ())
                continue
            own, values = plans.read(one)
            self._objects.append(([one], own.names, [values]))
            plan = plans[tuple(map(type, values))]
            if plan is not None:
                value = values.__getitem__
                self._arrays += map(value, plan.arrays)
                self._dicts += map(value, plan.dicts)
                self._others += map(value, plan.others)
                todo.extend(map(value, plan.instances))
                todo.extend(filter(None, map(value, plan.nested)))

    def restore(self) -> None:
        """Restore everything."""
        for array, numbers in zip(self._arrays, self._numbers, strict=True):
            array[...] = np.frombuffer(numbers, array.dtype).reshape(array.shape)
        for held, items in zip(self._dicts, self._items, strict=True):
            held.clear()
            dict.update(held, items)  # that of a Counter adds
        for held, content in zip(self._others, self._contents, strict=True):
            held.clear()
            held.update(content) if isinstance(held, set) else held.extend(content)
        values = iter(self._row)
        for state, names in zip(self._layout.states, self._layout.names, strict=True):
            state.clear()
            state.update(zip(names, values))  # noqa: B905 - each takes as many as it has names
        for objects, names, found in self._objects:
            for one, held in zip(objects, found, strict=True):
                for name, value in zip(names, held, strict=True):
                    setattr(one, name, value)
