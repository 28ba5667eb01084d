# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes a node's parameters as documented YAML: every key with unit, meaning and default."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from aerial_gnss_ros.core.config.schema import Leaf, leaves, type_hints

_WIDTH = 100
_HEADER = """\
Every parameter of the {node} node with its default. Generated from the program's own defaults by
{generator}; a test compares them.

Copy the file and keep only the lines that you change; absent keys keep their defaults. A whole
number is accepted for a decimal one, but ROS requires all numbers of a list to be of one type:
[0.0, 90.0, 0.0]. `.nan` means "not given", since ROS parameters have no empty value.
`/**/{node}` is the node in any namespace; write `/drone1/{node}` for one drone only."""


def document(node: str, schema: type[Any], generator: str, examples: str = "") -> str:
    """Return the YAML file of a node's defaults.

    Args:
        node: the node's name.
        schema: the dataclass of its parameters.
        generator: the command that writes the file, for the header.
        examples: text appended as comments, for keys without a default.
    """
    lines = [
        f"# {line}".rstrip() for line in _HEADER.format(node=node, generator=generator).splitlines()
    ]
    lines += [f"/**/{node}:", "  ros__parameters:"]
    lines += _group(schema, "", 4)
    if examples:
        lines += [f"    # {line}".rstrip() for line in examples.splitlines()]
    return "\n".join(lines) + "\n"


def _group(schema: type[Any], prefix: str, indent: int) -> Iterator[str]:
    by_name = {leaf.name: leaf for leaf in leaves(schema, prefix)}
    hints = type_hints(schema)
    for item in fields(schema):
        name, kind = prefix + item.name, hints[item.name]
        if is_dataclass(kind) and isinstance(kind, type):
            yield from _comment((kind.__doc__ or "").split("\n\n", maxsplit=1)[0], indent)
            yield f"{' ' * indent}{item.name}:"
            yield from _group(kind, name + ".", indent + 2)
        elif name in by_name:
            leaf = by_name[name]
            yield from _comment(meaning(leaf), indent)
            yield f"{' ' * indent}{item.name}: {scalar(leaf.default)}"


def meaning(leaf: Leaf) -> str:
    """Return a parameter's meaning, unit, range, default and whether it is dynamic."""
    key = leaf.key
    facts = []
    if key.unit:
        facts.append(f"unit {key.unit}")
    if key.low is not None or key.high is not None:
        low = "any" if key.low is None else f"{key.low:g}"
        high = "any" if key.high is None else f"{key.high:g}"
        facts.append(f"{low} to {high}")
    facts.append(f"default {scalar(leaf.default)}")
    if key.dynamic:
        facts.append("can be changed while running")
    return f"{key.doc} [{'; '.join(facts)}]"


def _comment(text: str, indent: int) -> Iterator[str]:
    wrapped = textwrap.wrap(" ".join(text.split()), _WIDTH - indent - 2, break_long_words=False)
    for line in wrapped:
        yield f"{' ' * indent}# {line}"


def scalar(value: Any) -> str:
    """Return a value as YAML that ROS and YAML 1.1 readers understand alike."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(scalar(item) for item in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return ".nan" if math.isnan(value) else repr(value)
    if isinstance(value, int):
        return str(value)
    plain = re.fullmatch(r"[A-Za-z_/~][\w/.\-]*", value)
    truth = value.lower() in ("true", "false", "yes", "no", "on", "off", "y", "n", "null", "~")
    return str(value) if plain and not truth else f'"{value}"'
