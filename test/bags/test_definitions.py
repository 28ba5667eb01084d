# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The definition that a bag carries wins over the one that this program knows."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat

from aerial_gnss_ros.bags.definitions import Definitions
from aerial_gnss_ros.bags.typestore import typestore

MSG, IDL = MessageDefinitionFormat.MSG, MessageDefinitionFormat.IDL
FLOAT = "std_msgs/msg/Float64"


def connection(msgtype, text, form=MSG):
    return SimpleNamespace(msgtype=msgtype, msgdef=MessageDefinition(form, text))


def fields(msgtype, text, form=MSG):
    """Return the names of a type's fields as the bag's definition has them; None if unknown."""
    store = Definitions().store(connection(msgtype, text, form))
    return None if store is None else [name for name, _ in store.fielddefs[msgtype][1]]


@pytest.mark.parametrize("text", ["float64 data\n", "float64 data # metres\nint32 LARGE=7\n", ""])
def test_a_definition_that_says_the_same_or_nothing_is_the_common_one(text):
    assert Definitions().store(connection(FLOAT, text)) is typestore()


def test_a_bags_own_definition_says_how_its_bytes_were_written():
    assert fields(FLOAT, "float64 data\nfloat32 sigma\n") == ["data", "sigma"]
    assert [name for name, _ in typestore().fielddefs[FLOAT][1]] == ["data"]


def test_a_type_that_nobody_has_heard_of_comes_with_its_parts():
    text = "Depth depth\n" + "=" * 80 + "\nMSG: sea_msgs/Depth\nfloat32 metres\n"
    assert fields("sea_msgs/msg/Dive", text) == ["depth"]
    assert fields("sea_msgs/msg/Dive", "Depth depth\n") is None  # its part is missing
    idl = "module sea_msgs { module msg { struct Depth { float metres; }; }; };"
    assert fields("sea_msgs/msg/Depth", f"IDL: sea_msgs/msg/Depth\n{idl}", IDL) == ["metres"]


@pytest.mark.parametrize("text", ["what is this?", "float64", "\0"])
def test_what_cannot_be_parsed_leaves_what_is_known(text):
    assert Definitions().store(connection(FLOAT, text)) is typestore()
    assert Definitions().store(connection("sea_msgs/msg/Dive", text)) is None


def test_a_definition_is_parsed_once(monkeypatch):
    found = Definitions()
    one = found.store(connection(FLOAT, "float64 more\n"))
    monkeypatch.setattr("aerial_gnss_ros.bags.definitions._find", lambda _: 1 / 0)
    assert found.store(connection(FLOAT, "float64 more\n")) is one
