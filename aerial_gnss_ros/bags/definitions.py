# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses the type store for a connection: the common one, or one with the bag's definitions."""

from __future__ import annotations

from typing import Any

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)
from rosbags.typesys.store import Typestore

from aerial_gnss_ros.bags.typestore import typestore

_IDL_SEPARATOR = "=" * 80 + "\n"


class Definitions:
    """Creates and caches the type stores that one bag needs.

    A bag's own definition takes precedence: its bytes were written with it, and it may describe
    types unknown to this program. If it equals the common one, the common store is used.
    """

    def __init__(self) -> None:
        self._stores: dict[tuple[str, str], Typestore | None] = {}

    def store(self, connection: Connection) -> Typestore | None:
        """Return the store with a connection's type, or None if it is not described."""
        key = (connection.msgtype, connection.msgdef.data)
        if key not in self._stores:
            self._stores[key] = _find(connection)
        return self._stores[key]


def _find(connection: Connection) -> Typestore | None:
    common = typestore()
    known = common if connection.msgtype in common.fielddefs else None
    try:
        types = _own_types(connection)
        if all(
            name in common.fielddefs and _fields(common.fielddefs[name]) == _fields(definition)
            for name, definition in types.items()
        ):
            return known
        store = get_typestore(Stores.EMPTY)
        store.register(types)
        store.get_msgdef(connection.msgtype)  # fails if a nested type is missing
    except (TypesysError, KeyError, AssertionError):  # a definition that cannot be parsed
        return known
    return store


def _own_types(connection: Connection) -> dict[str, Any]:
    form, text = connection.msgdef
    types: dict[str, Any] = {}
    if form == MessageDefinitionFormat.MSG and text.strip():  # empty: the recorder had none
        types.update(get_types_from_msg(text, connection.msgtype))
    elif form == MessageDefinitionFormat.IDL:
        for part in text.split(_IDL_SEPARATOR):
            body = part.split("\n", 1)[1] if part.startswith("IDL: ") else part
            if body.strip():
                types.update(get_types_from_idl(body))
    return types


def _fields(definition: Any) -> list[Any]:
    """Return names and types of a definition's fields, without constants."""
    return [(name, kind) for name, kind in definition[1]]
