# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads parameter files: ROS parameter YAML as `--params-file` takes it, or a plain mapping.

ROS itself ignores a parameter that no node declares. Here a misspelt key is refused by name, and
every message names the file. Only in a section that other programs may share (`/**`, `/drone1/*`)
it is reported and ignored. Sections are selected as in ROS: by the node's full name, with `*` for
one token and `**` for any number; an exact name takes precedence over a pattern, and the later of
two equal ones over the earlier. A file without `ros__parameters` is one section for every node.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.yaml_files import read_yaml
from aerial_gnss_ros.core.config.robot_classes import leaf_of
from aerial_gnss_ros.core.config.schema import (
    Leaf,
    build,
    check,
    flatten,
    leaves,
    type_hints,
    unknown,
    without_empty_groups,
)
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.text.sentences import cut, shown

ROS_KEY = "ros__parameters"
# Declared by every rclpy node itself.
_ROS_OWN = re.compile(r"use_sim_time|start_type_description_service|qos_overrides\..*")

Section = tuple[tuple[str, ...], Mapping[str, Any]]
Tell = Callable[[str], None]


def read(
    paths: Sequence[Path | str],
    schemas: Mapping[str, type[Any]],
    namespace: str = "/",
    tell: Tell | None = None,
) -> dict[str, dict[str, Any]]:
    """Return the checked values that parameter files give to each node, by dotted name.

    Args:
        paths: the files; later ones take precedence.
        schemas: node name (`estimator`) to the dataclass of its parameters.
        namespace: the nodes' namespace, for files with sections such as `/drone1/estimator`.
        tell: called with a sentence about each unknown key ignored in a shared section; None: such
            keys are refused, too.

    Returns:
        Values for each node's configuration, by node name. `use_sim_time` and other parameters of
        ROS itself are not among them: see `ros_parameters`.

    Raises:
        ConfigError: a file is missing or not YAML, none of its sections is for these nodes, or a
            key is unknown, of the wrong type or out of range.
    """
    merged: dict[str, dict[str, Any]] = {node: {} for node in schemas}
    for path in map(Path, paths):
        content = _load(path)
        with _naming(path):
            sections = _sections(content)
            shared = _told_of(path, tell) if _is_ros(content) else None
            _merge(sections, schemas, namespace, merged, shared)
    return merged


def foreign(
    paths: Sequence[Path | str], schemas: Mapping[str, type[Any]], node: str, namespace: str = "/"
) -> dict[str, str]:
    """Return a node's unknown keys from sections that other programs may share.

    Args:
        paths: parameter files that ROS itself was given.
        schemas: as for `read`.
        node: the node's name in them.
        namespace: of the node.

    Returns:
        The file, by key.

    Raises:
        ConfigError: a file is missing or not YAML.
    """
    found: dict[str, str] = {}
    own: set[str] = set()
    for path in map(Path, paths):
        for pattern, values in _sections(_load(path)):
            if not _matches(pattern, _tokens(namespace, node)):
                continue
            flat = _flat(values, schemas)
            names = [k for k in flat if not any(_knows(s, k) for s in schemas.values())]
            if _is_shared(pattern):
                found.update(dict.fromkeys(names, str(path)))
            else:
                own.update(names)
    return {name: path for name, path in found.items() if name not in own}


def left_out(path: Path | str, name: str) -> str:
    """Return the sentence about an ignored key."""
    return (
        f"{path}: {cut(name)} is not a parameter of this package and is ignored; if it was meant "
        "for one of its nodes, it is misspelt."
    )


def _told_of(path: Path, tell: Tell | None) -> Tell | None:
    return None if tell is None else lambda name: tell(left_out(path, name))


def ros_parameters(paths: Sequence[Path | str], node: str, namespace: str = "/") -> dict[str, Any]:
    """Return the parameters of ROS itself, such as `use_sim_time`, that the files give to a node.

    Raises:
        ConfigError: a file is missing or not YAML.
    """
    own: dict[str, Any] = {}
    for path in map(Path, paths):
        content = _load(path)
        with _naming(path):
            sections = _by_precedence(_sections(content))
        for pattern, values in sections:
            if _matches(pattern, _tokens(namespace, node)):
                own.update({k: v for k, v in flatten(values).items() if is_ros_own(k)})
    return own


def is_ros_own(name: str) -> bool:
    """Whether a parameter belongs to ROS itself and so to no schema."""
    return _ROS_OWN.fullmatch(name) is not None


def checked(schema: type[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return flat values converted to their parameters' types, except in free groups.

    Raises:
        ConfigError: an unknown key, a wrong type or a value out of range.
    """
    known = {leaf.name: leaf for leaf in leaves(schema)}
    free = free_groups(schema)
    return {
        name: _checked_free(name, value)
        if _is_free(name, free)
        else _checked_value(schema, known, name, value)
        for name, value in values.items()
    }


def _checked_free(name: str, value: Any) -> Any:
    leaf = leaf_of(name)
    return value if leaf is None else check(leaf, value)


def free_groups(schema: type[Any]) -> tuple[str, ...]:
    """Return the groups whose keys the user chooses, such as `robots`."""
    hints = type_hints(schema)
    return tuple(
        item.name
        for item in fields(schema)
        if "key" not in item.metadata and not is_dataclass(hints[item.name])
    )


def _is_free(name: str, free: Sequence[str]) -> bool:
    return name.split(".", 1)[0] in free


def _checked_value(schema: type[Any], known: Mapping[str, Leaf], name: str, value: Any) -> Any:
    if name not in known:
        build(schema, {name: value})  # raises, and suggests the nearest name
        raise ConfigError(f"{name} is not a parameter.")
    if value is None:
        if known[name].key.length is None and "tuple" in str(known[name].kind):
            return ()  # ROS passes an empty list this way
        raise ConfigError(f"{name} has no value; give one or remove the line.")
    return check(known[name], value)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Prefix errors with the file's name."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def _merge(
    sections: Sequence[Section],
    schemas: Mapping[str, type[Any]],
    namespace: str,
    merged: dict[str, dict[str, Any]],
    shared: Tell | None,
) -> None:
    names = {node: _tokens(namespace, node) for node in schemas}
    if not any(_matches(pattern, name) for pattern, _ in sections for name in names.values()):
        present = ", ".join("/" + "/".join(pattern) for pattern, _ in sections) or "nothing"
        wanted = " or ".join("/" + "/".join(name) for name in names.values())
        raise ConfigError(
            f"has no section for {wanted}, only for {present}; rename it, or give its --namespace."
        )
    for pattern, values in _by_precedence(sections):
        matched = [node for node, name in names.items() if _matches(pattern, name)]
        flat = {k: v for k, v in _flat(values, schemas).items() if not is_ros_own(k)}
        if shared is not None and matched and _is_shared(pattern):
            for name in [k for k in flat if not any(_knows(s, k) for s in schemas.values())]:
                del flat[name]
                shared(name)
        for node, share in _shares(flat, [(n, schemas[n]) for n in matched]).items():
            merged[node].update(share)


def _flat(values: Mapping[str, Any], schemas: Mapping[str, type[Any]]) -> dict[str, Any]:
    known = [leaf.name for one in schemas.values() for leaf in leaves(one)]
    free = [f"{group}." for one in schemas.values() for group in free_groups(one)]
    return without_empty_groups(flatten(values), [*known, *free])


def _shares(
    flat: Mapping[str, Any], matched: Sequence[tuple[str, type[Any]]]
) -> dict[str, dict[str, Any]]:
    """Give each node its values of a section; a value that no node knows is refused."""
    shares: dict[str, dict[str, Any]] = {node: {} for node, _ in matched}
    for name, value in flat.items() if matched else ():
        takers = [pair for pair in matched if _knows(pair[1], name)]
        if not takers:
            raise unknown(name, (leaf.name for _, one in matched for leaf in leaves(one)))
        for node, schema in takers:
            shares[node].update(checked(schema, {name: value}))
    return shares


def _knows(schema: type[Any], name: str) -> bool:
    return _is_free(name, free_groups(schema)) or any(leaf.name == name for leaf in leaves(schema))


def _tokens(namespace: str, node: str) -> tuple[str, ...]:
    return (*(token for token in namespace.split("/") if token), node)


def _matches(pattern: Sequence[str], name: Sequence[str]) -> bool:
    if not pattern:
        return not name
    if pattern[0] == "**":
        return any(_matches(pattern[1:], name[skip:]) for skip in range(len(name) + 1))
    return bool(name) and pattern[0] in ("*", name[0]) and _matches(pattern[1:], name[1:])


def _is_shared(pattern: Sequence[str]) -> bool:
    """Whether a section may also apply to nodes of other names."""
    return not pattern or pattern[-1] in ("*", "**")


def _is_ros(content: Mapping[str, Any]) -> bool:
    return any(True for _ in _ros_sections(content, ()))


def _by_precedence(sections: Sequence[Section]) -> list[Section]:
    return sorted(sections, key=lambda section: not {"*", "**"} & set(section[0]))


def _sections(content: Mapping[str, Any]) -> list[Section]:
    found = list(_ros_sections(content, ()))
    return found or [(("**",), content)]


def _ros_sections(content: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[Section]:
    for name, value in content.items():
        if name == ROS_KEY:
            if not isinstance(value, Mapping):
                raise ConfigError(
                    f"{'/'.join(above)}.{ROS_KEY} must be a mapping, not {shown(value)}."
                )
            yield above, value
        elif isinstance(value, Mapping):
            yield from _ros_sections(value, above + tuple(t for t in name.split("/") if t))


def _load(path: Path) -> Mapping[str, Any]:
    """Return a file's mapping, every key as text."""
    try:
        content = read_yaml(path)
    except InputError as error:
        raise ConfigError(str(error)) from error
    if content is None:
        return {}
    if not isinstance(content, Mapping):
        raise ConfigError(
            f"{path}: must hold parameter names with values, not {shown(content)[:40]!r}."
        )
    return _with_text_keys(content)


def _with_text_keys(content: Mapping[Any, Any]) -> dict[str, Any]:
    return {
        str(name): _with_text_keys(value) if isinstance(value, Mapping) else value
        for name, value in content.items()
    }
