# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters as frozen dataclasses: one source of defaults, units, ranges and messages.

A group of parameters is a frozen dataclass whose fields are made with `key`; groups nest. The
dotted name of a leaf (`camera.latency_s`) is its name in YAML, as a ROS parameter and in errors.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.plain_text import printable
from aerial_gnss_ros.text.sentences import cut, shown

T = TypeVar("T")

LEAST_SIZE = 1e-30
"""Smallest size of a number that is not 0: squares and their inverses are finite."""
_SUGGESTED = 5
_ALIKE = 0.5
"""Least share of common letters in a misspelt name, as difflib counts it."""


@dataclass(frozen=True)
class Key:
    """Documentation of a parameter, shown in YAML comments, descriptors and errors."""

    doc: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    length: int | None = None
    dynamic: bool = False
    optional: bool = False


def key(
    default: Any,
    doc: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    length: int | None = None,
    dynamic: bool = False,
    optional: bool = False,
) -> Any:
    """Return a dataclass field with its documentation.

    Args:
        default: the default; its type must be that of the annotation.
        doc: meaning and consequence, in one or two sentences.
        unit: SI unit or `deg`, `px`, …
        low: least allowed value (of each element of a list).
        high: largest allowed value.
        choices: allowed strings.
        length: required number of elements of a list.
        dynamic: True if a running node accepts a new value.
        optional: True if NaN means «not given».
    """
    meaning = Key(doc, unit, low, high, choices, length, dynamic, optional)
    return field(default=default, metadata={"key": meaning})


def group(cls: type[T]) -> T:
    """Return a field that holds a nested group of parameters with its defaults."""
    made: T = field(default_factory=cls)
    return made


@dataclass(frozen=True)
class Leaf:
    """One parameter: dotted name, Python type, default and meaning."""

    name: str
    kind: Any
    default: Any
    key: Key


_HINTS: dict[type[Any], dict[str, Any]] = {}


def type_hints(cls: type[Any]) -> dict[str, Any]:
    """Return the types of a group's fields; cached, because every key of a file needs them."""
    if cls not in _HINTS:
        _HINTS[cls] = get_type_hints(cls)
    return _HINTS[cls]


def leaves(cls: type[Any], prefix: str = "") -> Iterator[Leaf]:
    """Yield every parameter of a group in the order of its definition."""
    hints = type_hints(cls)
    for item in fields(cls):
        name, kind = prefix + item.name, hints[item.name]
        if is_dataclass(kind) and isinstance(kind, type):
            yield from leaves(kind, name + ".")
        elif "key" in item.metadata:
            default = item.default if item.default is not MISSING else None
            yield Leaf(name, kind, default, item.metadata["key"])


def flatten(nested: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a nested mapping as one with dotted names; what is empty stays as it is."""
    flat: dict[str, Any] = {}
    for name, value in nested.items():
        if isinstance(value, Mapping) and value:
            flat.update(flatten(value, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def without_empty_groups(flat: Mapping[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """Return values by dotted name but groups that hold none, such as `camera: {}`.

    Args:
        flat: the values.
        known: dotted names of parameters.
    """
    groups = {name[:at] for name in known for at, char in enumerate(name) if char == "."}
    return {name: value for name, value in flat.items() if value != {} or name not in groups}


def check(leaf: Leaf, value: Any) -> Any:
    """Return `value` as the parameter's own type.

    Raises:
        ConfigError: wrong type, out of range, not one of the choices, or wrong length.
    """
    origin = get_origin(leaf.kind)
    if origin is tuple:
        return _check_list(leaf, value, get_args(leaf.kind)[0])
    return _check_scalar(leaf, value, leaf.kind)


def _check_list(leaf: Leaf, value: Any, kind: Any) -> tuple[Any, ...]:
    if isinstance(value, str) or not hasattr(value, "__iter__"):
        raise ConfigError(f"{leaf.name} must be a list of {_kind_words(kind)}, not {shown(value)}.")
    items = tuple(_check_scalar(leaf, item, kind) for item in value)
    if leaf.key.length is not None and len(items) != leaf.key.length:
        raise ConfigError(
            f"{leaf.name} must have {leaf.key.length} elements, not {len(items)}: "
            f"{shown(list(items))}."
        )
    return items


def _kind_words(kind: Any) -> str:
    return {float: "numbers", int: "whole numbers", str: "text", bool: "true or false"}[kind]


def _check_scalar(leaf: Leaf, value: Any, kind: Any) -> Any:
    name = leaf.name
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigError(f"{name} must be a number{_unit(leaf)}, not {shown(value)}.")
        return _check_range(leaf, _float(value))
    if kind is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise ConfigError(f"{name} must be a whole number{_unit(leaf)}, not {shown(value)}.")
        return _check_range(leaf, value)
    if kind is bool:
        if not isinstance(value, bool):
            raise ConfigError(f"{name} must be true or false, not {shown(value)}.")
        return value
    if isinstance(value, bool) and str(value).lower() in leaf.key.choices:
        return str(value).lower()  # YAML reads an unquoted true as a boolean
    if not isinstance(value, str):
        raise ConfigError(f"{name} must be text, not {shown(value)}; put it in quotes.")
    if printable(value) != value:
        raise ConfigError(f"{name} must be text without control characters, not {shown(value)}.")
    if leaf.key.choices and value not in leaf.key.choices:
        raise ConfigError(
            f"{name} must be one of {', '.join(leaf.key.choices)}, not {shown(value)}."
        )
    return value


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number beyond 1.8e308
        return math.copysign(math.inf, value)


def _unit(leaf: Leaf) -> str:
    return f" ({leaf.key.unit})" if leaf.key.unit else ""


def _check_range(leaf: Leaf, value: Any) -> Any:
    if math.isnan(value):
        if leaf.key.optional:
            return value
        raise ConfigError(f"{leaf.name} must be a number{_unit(leaf)}, not NaN.")
    if 0.0 < abs(value) < LEAST_SIZE:
        raise ConfigError(
            f"{leaf.name} must be 0 or at least {LEAST_SIZE:g}{_unit(leaf)} in size, not {value:g}."
        )
    low, high = leaf.key.low, leaf.key.high
    if (low is not None and value < low) or (high is not None and value > high):
        least = "-inf" if low is None else f"{low:g}"
        most = "inf" if high is None else f"{high:g}"
        raise ConfigError(
            f"{leaf.name} must lie within {least} to {most}{_unit(leaf)}, not {value:g}."
        )
    return value


def build(cls: type[T], values: Mapping[str, Any], prefix: str = "") -> T:
    """Return a group of parameters from nested or dotted values; absent ones keep their defaults.

    Args:
        cls: the group's dataclass.
        values: nested mapping, or one with dotted names.
        prefix: of all names, ending in a dot.

    Raises:
        ConfigError: unknown key, or a value that `check` refuses.
    """
    known = {leaf.name: leaf for leaf in leaves(cls, prefix)}
    flat = without_empty_groups(flatten(values), known)
    for name in flat:
        if name not in known:
            raise unknown(name, known)
    checked = {name: check(known[name], value) for name, value in flat.items()}
    return _assemble(cls, checked, prefix)


def unknown(name: str, known: Iterable[str]) -> ConfigError:
    """Return the error about a name that is no parameter, with those that were probably meant.

    Args:
        name: dotted.
        known: dotted names of parameters.
    """
    meant = _meant(name, list(dict.fromkeys(known)))
    if not meant:
        return ConfigError(
            f"{cut(name)} is not a parameter; remove it, or see the files in config/."
        )
    if len(meant) > _SUGGESTED:
        meant = [*meant[:_SUGGESTED], f"one of {len(meant) - _SUGGESTED} more"]
    *others, last = meant
    named = f"{', '.join(others)} or {last}" if others else last
    return ConfigError(f"{cut(name)} is not a parameter; did you mean {named}?")


def _meant(name: str, known: Sequence[str]) -> list[str]:
    """Return the parameters that a name without its group, or a misspelt one, may stand for."""
    by_last: dict[str, list[str]] = {}
    for candidate in known:
        by_last.setdefault(_last(candidate), []).append(candidate)
    whole = difflib.get_close_matches(name, known, n=1, cutoff=_ALIKE)
    last = difflib.get_close_matches(_last(name), by_last, n=1, cutoff=_ALIKE)
    same = by_last.get(_last(name)) or (by_last[last[0]] if last else [])
    return same or whole if "." not in name else whole or same


def _last(name: str) -> str:
    return name.rsplit(".", 1)[-1]


def _assemble(cls: type[T], checked: Mapping[str, Any], prefix: str) -> T:
    hints = type_hints(cls)
    made: dict[str, Any] = {}
    for item in fields(cls):  # type: ignore[arg-type]
        name, kind = prefix + item.name, hints[item.name]
        if is_dataclass(kind) and isinstance(kind, type):
            made[item.name] = _assemble(kind, checked, name + ".")
        elif name in checked:
            made[item.name] = checked[name]
    return cls(**made)
