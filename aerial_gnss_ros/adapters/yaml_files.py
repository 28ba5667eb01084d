# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads YAML within bounds: the result is the file's content or an error of one sentence.

Aliases can expand a few lines to gigabytes, and PyYAML's constructors raise arbitrary exceptions on
wrong values. So size, depth and the expansion of aliases are bounded while the file is composed,
and every error names file and line.
"""

from __future__ import annotations

import re
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

from aerial_gnss_ros.adapters.text_files import read_text
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import shown

MOST_BYTES = 1_000_000
MOST_DEPTH = 32
MOST_NODES = 50_000
MOST_EXPANDED = 2 * MOST_BYTES
"""Limit of the characters of all values, with aliases counted at every use."""
_MOST_KEY = 256
_MOST_BITS = 64


class _RefusedError(Exception):
    """An error, to be prefixed with the file's name."""


def read_yaml(path: Path, *, first: bool = False) -> Any:
    """Return the content of a YAML file; None if it is empty.

    Args:
        path: the file.
        first: whether further documents (after `---`) are ignored; otherwise they are an error.

    Raises:
        InputError: the file cannot be read, is not YAML, or exceeds the bounds of this module.
    """
    text = read_text(path, MOST_BYTES)
    try:
        return _load(text, first)
    except _RefusedError as error:
        raise InputError(f"{path}: {error}") from error
    except yaml.YAMLError as error:
        raise InputError(f"{path}: is not YAML: {_problem(error, text)}.") from error


def yaml_of_text(text: str) -> Any:
    """Return the content of YAML text, such as the value of a parameter; None if it is empty.

    Raises:
        InputError: it is not YAML, or exceeds the bounds of this module.
    """
    if len(text) > MOST_BYTES:
        raise InputError(f"is longer than {MOST_BYTES} characters.")
    try:
        return _load(text, first=False)
    except _RefusedError as error:
        raise InputError(str(error)) from error
    except yaml.YAMLError as error:
        raise InputError(f"is not YAML: {_problem(error, text)}.") from error


def check_depth(path: Path, most_bytes: int) -> None:
    """Refuse a YAML file that nests too deeply for another reader.

    Args:
        path: the file.
        most_bytes: size limit of the file.

    Raises:
        InputError: the file cannot be read, is not YAML, or nests deeper than `MOST_DEPTH`.
    """
    text = read_text(path, most_bytes)
    depth = 0
    try:
        for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > MOST_DEPTH:
                raise InputError(f"{path}: {_too_deep(event.start_mark)}")
    except yaml.YAMLError as error:
        if "nesting depth" in str(error):  # libyaml's own limit, before it yields any event
            mark = getattr(error, "problem_mark", None)
            raise InputError(f"{path}: {_too_deep(mark)}") from error
        raise InputError(f"{path}: is not YAML: {_problem(error, text)}.") from error


def _too_deep(mark: Any) -> str:
    where = f"line {mark.line + 1} " if mark else ""
    return f"{where}nests deeper than {MOST_DEPTH} levels."


def _load(text: str, first: bool) -> Any:
    loader: Any = _Loader(text)
    try:
        if not first:
            return loader.get_single_data()
        return loader.get_data() if loader.check_data() else None
    finally:
        loader.dispose()


class _Loader(yaml.SafeLoader):
    """YAML as ROS reads it (1e-3 is a number), except that a duplicate key is an error."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = self._nodes = self._expanded = 0
        self._sizes: dict[str, tuple[int, int]] = {}  # of completed anchored nodes

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Compose a node within the bounds; an alias counts with its full content."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent) and event.anchor is not None:
            if event.anchor in self.anchors and event.anchor not in self._sizes:
                raise _RefusedError(f"the alias *{event.anchor} in line {line} contains itself.")
            self._grow(*self._sizes.get(event.anchor, (0, 0)), line)
            return super().compose_node(parent, index)
        before = self._nodes, self._expanded
        self._depth += 1
        if self._depth > MOST_DEPTH:
            raise _RefusedError(f"line {line} is nested deeper than {MOST_DEPTH} levels.")
        self._grow(1, len(event.value) if isinstance(event, yaml.ScalarEvent) else 0, line)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if event.anchor is not None:
            self._sizes[event.anchor] = self._nodes - before[0], self._expanded - before[1]
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct a value; any exception of its constructor becomes a sentence."""
        try:
            made = super().construct_object(node, deep)
        except (yaml.YAMLError, _RefusedError):
            raise
        except Exception as error:  # constructors raise arbitrary exceptions on wrong values
            raise _RefusedError(_unusable(node)) from error
        if isinstance(made, int) and made.bit_length() > _MOST_BITS:
            raise _RefusedError(_unusable(node))
        return made

    def _grow(self, nodes: int, characters: int, line: int) -> None:
        self._nodes += nodes
        self._expanded += characters
        if self._nodes > MOST_NODES or self._expanded > MOST_EXPANDED:
            raise _RefusedError(
                f"holds more than {MOST_NODES} values or {MOST_EXPANDED} characters (aliases "
                f"counted at every use), exceeded in line {line}."
            )


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    made: dict[Any, Any] = {}
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        key = loader.construct_object(key_node, deep=True)
        if not isinstance(key, Hashable) or len(str(key)) > _MOST_KEY:
            raise _RefusedError(
                f"a key must be a word of at most {_MOST_KEY} characters, not {shown(key)} in line "
                f"{line}."
            )
        if key in made:
            raise _RefusedError(f"{key} is given twice (line {line}); keep one of them.")
        made[key] = loader.construct_object(value_node, deep=True)
    return made


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def _unusable(node: yaml.Node) -> str:
    kind = node.tag.rpartition(":")[2]
    value = shown(node.value) if isinstance(node, yaml.ScalarNode) else "what follows"
    return f"{value} in line {node.start_mark.line + 1} is not a valid {kind}."


def _problem(error: yaml.YAMLError, text: str) -> str:
    if isinstance(error, yaml.reader.ReaderError):
        line = text.count("\n", 0, error.position) + 1
        character = error.character if isinstance(error.character, str) else chr(error.character)
        return f"the character {character!r} is not allowed in line {line}"
    mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
    where = f" in line {mark.line + 1}" if mark else ""
    return f"{' '.join(str(problem or 'damaged').split())[:200]}{where}"
