# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters from dataclasses: descriptors, ranges, refusal of keys that ROS would ignore."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, get_args, get_origin

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from aerial_gnss_ros.adapters.parameter_changes import after
from aerial_gnss_ros.adapters.parameter_documents import meaning
from aerial_gnss_ros.adapters.parameter_files import checked, free_groups, is_ros_own
from aerial_gnss_ros.core.config.references import reference_leaf_of
from aerial_gnss_ros.core.config.robot_classes import leaf_of
from aerial_gnss_ros.core.config.schema import Leaf, leaves
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.distribution import after_changes
from aerial_gnss_ros.nodes.schemas import SCHEMAS

_ARRAYS = {
    bool: Parameter.Type.BOOL_ARRAY,
    int: Parameter.Type.INTEGER_ARRAY,
    float: Parameter.Type.DOUBLE_ARRAY,
    str: Parameter.Type.STRING_ARRAY,
}


def own_values(
    node: str, overrides: Mapping[str, Any], foreign: Collection[str] = ()
) -> dict[str, Any]:
    """Return the checked parameter values that ROS was given for a node.

    A shared section, or `-p` with two nodes in one process, gives each node the other's keys too:
    these are ignored, as are keys of other programs. Any other unknown key is refused, which ROS
    itself would ignore.

    Args:
        node: the node's name in `SCHEMAS`.
        overrides: from `--params-file` and `-p`.
        foreign: keys from sections that other programs may share.

    Raises:
        ConfigError: an unknown key, a wrong type or a value out of range.
    """
    others = {
        leaf.name for name, schema in SCHEMAS.items() if name != node for leaf in leaves(schema)
    }
    free = {group for schema in SCHEMAS.values() for group in free_groups(schema)}
    schema = SCHEMAS[node]
    known = {leaf.name for leaf in leaves(schema)}
    own = {
        name: value
        for name, value in overrides.items()
        if not is_ros_own(name)
        and name not in foreign
        and (name in known or not (name in others or _foreign(name, free, schema)))
    }
    return checked(schema, own)


def _foreign(name: str, free: set[str], schema: type[Any]) -> bool:
    first = name.split(".", 1)[0]
    return first in free and first not in free_groups(schema)


def declare(
    node: Node, schema: type[Any], values: Mapping[str, Any], *, changeable: bool = False
) -> None:
    """Declare every parameter of a schema, and its free keys that have values.

    Args:
        node: the node that declares them.
        schema: the dataclass of its parameters.
        values: checked values by dotted name; absent ones keep their defaults.
        changeable: whether the node itself decides when a parameter can be changed.
    """
    known = {leaf.name: leaf for leaf in leaves(schema)}
    for name, leaf in known.items():
        value = values.get(name, leaf.default)
        if get_origin(leaf.kind) is tuple:
            _declare_list(node, leaf, list(value), changeable)
        else:
            described = descriptor(leaf, changeable)
            node.declare_parameter(name, value, described, ignore_override=True)
    for name, value in values.items():
        if name not in known:
            node.declare_parameter(name, _listed(value), _free(name), ignore_override=True)


def _free(name: str) -> ParameterDescriptor:
    """Return the descriptor of a key that the user has chosen; who may change it may delete it."""
    leaf = leaf_of(name) or reference_leaf_of(name)
    if leaf is None:
        return ParameterDescriptor(description="Given by the user.", read_only=True)
    described = descriptor(leaf)
    described.dynamic_typing = not described.read_only
    return described


def declare_free(node: Node, values: Mapping[str, Any], groups: Collection[str]) -> None:
    """Declare the keys of groups that have values, with these, and no others.

    Args:
        node: with its parameters declared.
        values: by dotted name.
        groups: whose keys the user may change.
    """
    for group in groups:
        for rest in node.get_parameters_by_prefix(group):
            if f"{group}.{rest}" not in values:
                node.undeclare_parameter(f"{group}.{rest}")
    for name, value in values.items():
        if name.split(".", maxsplit=1)[0] not in groups:
            continue
        if node.has_parameter(name):
            node.set_descriptor(name, _free(name))
            if not _alike(node.get_parameter(name).value, value):
                node.set_parameters([Parameter(name, value=_listed(value))])
        else:
            node.declare_parameter(name, _listed(value), _free(name), ignore_override=True)


def _alike(one: Any, other: Any) -> bool:
    """Return whether two values are the same, whatever holds their elements."""
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    lists = [hasattr(each, "__iter__") and not isinstance(each, str) for each in (one, other)]
    return list(one) == list(other) if all(lists) else bool(one == other)


def _listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _declare_list(node: Node, leaf: Leaf, value: list[Any], changeable: bool) -> None:
    """Declare a list with its type: rclpy would take an empty one for bytes."""
    kind = _ARRAYS[get_args(leaf.kind)[0]]
    node.declare_parameter(leaf.name, kind, ParameterDescriptor(), ignore_override=True)
    node.set_parameters([Parameter(leaf.name, kind, value)])
    described = descriptor(leaf, changeable)
    described.type = kind.value
    described.dynamic_typing = not described.read_only  # an empty list has no type of its own
    node.set_descriptor(leaf.name, described)


def descriptor(leaf: Leaf, changeable: bool = False) -> ParameterDescriptor:
    """Return a parameter's descriptor: meaning, unit, range, and whether it can be changed."""
    key = leaf.key
    limits = []
    if key.choices:
        limits.append(f"one of {', '.join(key.choices)}")
    if key.length is not None:
        limits.append(f"{key.length} elements")
    if key.optional:
        limits.append("NaN: not given")
    made = ParameterDescriptor(
        name=leaf.name,
        description=meaning(leaf),
        additional_constraints="; ".join(limits),
        read_only=not (key.dynamic or changeable),
        dynamic_typing=(key.dynamic or changeable) and leaf.kind is float,  # takes 1 for 1.0
    )
    if key.low is None and key.high is None:
        return made
    low = -math.inf if key.low is None else key.low
    high = math.inf if key.high is None else key.high
    if leaf.kind is float and not key.optional:  # NaN lies in no range that rclpy knows
        made.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif leaf.kind is int and math.isfinite(low) and math.isfinite(high):
        made.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    return made


def follow_changes(
    node: Node,
    current: Callable[[], Mapping[str, Any]],
    build: Callable[[Mapping[str, Any]], Any],
    accept: Callable[[dict[str, Any], Any], None],
    fixed: Callable[[str], str] = lambda _name: "",
    groups: Collection[str] = (),
) -> None:
    """Let a running node accept new values of its dynamic parameters.

    Args:
        node: with its parameters declared.
        current: returns the values in use, by dotted name.
        build: creates a configuration from values; raises ConfigError with the sentence that the
            caller of `ros2 param set` reads.
        accept: called with the new values and their configuration.
        fixed: returns why a parameter cannot be changed now; empty if it can.
        groups: whose keys the user chooses and may change (see `parameter_changes`).
    """

    def merged(parameters: list[Parameter]) -> dict[str, Any]:
        wanted = {p.name: p.value for p in parameters if not is_ros_own(p.name)}
        return after(current(), wanted, groups)

    def validate(parameters: list[Parameter]) -> SetParametersResult:
        for one in parameters:
            own = is_ros_own(one.name)
            if own and not node.has_parameter(one.name):
                return SetParametersResult(successful=False, reason=f"{one.name} is not declared.")
            reason = "" if own else fixed(one.name)
            if reason and one.value != current().get(one.name):
                return SetParametersResult(successful=False, reason=reason)
        try:
            build(merged(parameters))
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def changed(parameters: list[Parameter]) -> None:
        values = merged(parameters)
        if values != current():
            accept(values, build(values))
        if (
            any(one.name.split(".", maxsplit=1)[0] in groups for one in parameters)
            and not declaring
        ):
            declaring.append(True)  # to declare one is a change, too
            declare_free(node, values, groups)
            declaring.clear()

    declaring: list[bool] = []

    node.add_on_set_parameters_callback(validate)
    after_changes(node, changed)
