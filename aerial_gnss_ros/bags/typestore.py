# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types of ROS 2 Jazzy with vision_msgs and geographic_msgs, and messages from dicts."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
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
    store = store or typestore()
    if msgtype not in store.fielddefs:
        raise InputError(
            f"message type {msgtype} is unknown; known: vision_msgs, geographic_msgs "
            "and the common interfaces of ROS 2 Jazzy."
        )
    definitions = dict(store.fielddefs[msgtype][1])
    unknown = set(fields) - set(definitions)
    if unknown:
        raise InputError(f"{msgtype} has no field {', '.join(sorted(unknown))}.")
    defaults = _DEFAULTS.get(msgtype, {})
    values = {
        name: _value(definition, fields.get(name, defaults.get(name)), store)
        for name, definition in definitions.items()
    }
    return store.types[msgtype](**values)


def serialize(msgtype: str, fields: Mapping[str, Any]) -> bytes:
    """Return a message as CDR bytes; see `make`."""
    return bytes(typestore().serialize_cdr(make(msgtype, fields), msgtype))


def _value(definition: Any, value: Any, store: Typestore) -> Any:
    kind, inner = definition
    if kind == Nodetype.BASE:
        return _scalar(inner[0], value)
    if kind == Nodetype.NAME:
        return make(inner, value or {}, store)
    (element_kind, element), length = inner
    length = length if kind == Nodetype.ARRAY else 0
    if element_kind == Nodetype.NAME:
        return [make(element, item, store) for item in (value or [{}] * length)]
    if element[0] in ("string", "wstring"):
        return list(value or [""] * length)
    dtype = _NUMPY.get(element[0], element[0])
    if isinstance(value, bytes | bytearray | memoryview):
        return np.frombuffer(value, dtype=dtype)
    return np.zeros(length, dtype=dtype) if value is None else np.asarray(value, dtype=dtype)


def _scalar(name: str, value: Any) -> Any:
    if name in ("string", "wstring"):
        return "" if value is None else str(value)
    if name == "bool":
        return bool(value)
    if name.startswith("float"):
        return 0.0 if value is None else float(value)
    return 0 if value is None else int(value)
