# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types of ROS 2 Jazzy with vision_msgs and geographic_msgs, and messages from dicts."""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from aerial_gnss_ros.core.values.errors import InputError

TEXTS = Path(__file__).resolve().parent / "msg"
"""The .msg texts that rosbags lacks; interfaces/ compiles the same files for the pip build."""

GEOJSON_TYPE = "foxglove_msgs/msg/GeoJSON"
"""Type that Foxglove's map panel draws; it occurs only in bags, so no package is needed."""

_NUMPY = {"bool": "bool", "byte": "uint8", "char": "uint8"}  # others have numpy's names
_DEFAULTS = {"geometry_msgs/msg/Quaternion": {"w": 1.0}}  # the only one in the types used here


@functools.cache
def typestore() -> Typestore:
    """Return the type store for reading and writing bags."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types: dict[str, Any] = {}
    for path in sorted(TEXTS.glob("*/msg/*.msg")):
        name = f"{path.parent.parent.name}/msg/{path.stem}"
        types.update(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    types.update(get_types_from_msg("string geojson\n", GEOJSON_TYPE))
    store.register(types)
    return store


def extended(texts: Mapping[str, str]) -> Typestore:
    """Return a new store with the types of `typestore` and others.

    Args:
        texts: definitions as in .msg files, by message type.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    known = typestore().fielddefs
    types = {name: known[name] for name in known if name not in store.fielddefs}
    for name, text in texts.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


def make(msgtype: str, fields: Mapping[str, Any], store: Typestore | None = None) -> Any:
    """Return a message of `rosbags` from nested dicts in ROS field names.

    Args:
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        fields: absent ones keep their defaults (zero, empty, identity).
        store: of the message types; None: `typestore`.

    Raises:
        InputError: the type is unknown or lacks a given field.
    """
    makers = _makers(typestore() if store is None else store)
    # Copied, for what is absent is shared between the messages that a maker makes.
    return copy.deepcopy(makers.of(msgtype)(fields))


def serialize(msgtype: str, fields: Mapping[str, Any]) -> bytes:
    """Return a message as CDR bytes; see `make`."""
    store = typestore()
    made = _makers(store).of(msgtype)(fields)
    return bytes(store.serialize_cdr(made, msgtype))


class _Makers:
    """What makes messages, by type; made once, for a replay makes ten messages an image."""

    def __init__(self, store: Typestore) -> None:
        self.store = store
        self._known: dict[str, _Maker] = {}

    def of(self, msgtype: str) -> _Maker:
        """Return what makes messages of a type.

        Raises:
            InputError: the type is unknown.
        """
        if msgtype not in self._known:
            if msgtype not in self.store.fielddefs:
                raise InputError(
                    f"message type {msgtype} is unknown; known: vision_msgs, geographic_msgs "
                    "and the common interfaces of ROS 2 Jazzy."
                )
            self._known[msgtype] = _Maker(msgtype, self)
        return self._known[msgtype]


@functools.lru_cache(maxsize=4)
def _makers(store: Typestore) -> _Makers:
    return _Makers(store)


class _Maker:
    """Makes messages of one type from nested dicts."""

    def __init__(self, msgtype: str, makers: _Makers) -> None:
        self._name, self._kind = msgtype, makers.store.types[msgtype]
        definitions = makers.store.fielddefs[msgtype][1]
        self._converters = {name: _converter(one, makers) for name, one in definitions}
        own = _DEFAULTS.get(msgtype, {})
        self._absent = {name: take(own.get(name)) for name, take in self._converters.items()}

    def __call__(self, fields: Mapping[str, Any]) -> Any:
        """Return a message; what is absent is the same object in all of them.

        Raises:
            InputError: the type has no field of a given name.
        """
        values = self._absent.copy()
        converters = self._converters
        for name, value in fields.items():
            if name not in converters:
                unknown = sorted(set(fields) - set(converters))
                raise InputError(f"{self._name} has no field {', '.join(unknown)}.")
            if value is not None:
                values[name] = converters[name](value)
        return self._kind(**values)


def _converter(definition: Any, makers: _Makers) -> Callable[[Any], Any]:
    """Return what makes a field's value of what is given; None gives the default."""
    kind, inner = definition
    if kind == Nodetype.BASE:
        return _SCALARS.get(inner[0], _float if inner[0].startswith("float") else _int)
    if kind == Nodetype.NAME:
        one = makers.of(inner)
        return lambda value: one(value or {})
    (element_kind, element), length = inner
    length = length if kind == Nodetype.ARRAY else 0
    if element_kind == Nodetype.NAME:
        each = makers.of(element)
        return lambda value: [each(item) for item in (value or [{}] * length)]
    if element[0] in ("string", "wstring"):
        return lambda value: list(value or [""] * length)
    dtype = np.dtype(_NUMPY.get(element[0], element[0]))
    return functools.partial(_array, dtype, length)


def _array(dtype: np.dtype[Any], length: int, value: Any) -> NDArray[Any]:
    if isinstance(value, bytes | bytearray | memoryview):
        return np.frombuffer(value, dtype=dtype)
    return np.zeros(length, dtype=dtype) if value is None else np.asarray(value, dtype=dtype)


def _float(value: Any) -> float:
    return 0.0 if value is None else float(value)


def _int(value: Any) -> int:
    return 0 if value is None else int(value)


def _text(value: Any) -> str:
    return "" if value is None else str(value)


_SCALARS: dict[str, Callable[[Any], Any]] = {"string": _text, "wstring": _text, "bool": bool}
