# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a running node's parameters are after a request to change some of them.

`classes` and `references` have keys that the user chooses. Each is a parameter of its own
(`references.pier.sigma_m`), but a new reference is complete only with several, and `ros2 param set`
sets one at a time. So the whole of it can be given as text: `references.pier` as `{class: beacon,
position: [13.194, -59.641], sigma_m: 0.05}`. Empty text, or deleting the parameter, removes it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from aerial_gnss_ros.adapters.yaml_files import yaml_of_text
from aerial_gnss_ros.core.config.schema import flatten
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.text.sentences import shown


def after(
    values: Mapping[str, Any], wanted: Mapping[str, Any], groups: Collection[str]
) -> dict[str, Any]:
    """Return the values after a request.

    Args:
        values: by dotted name.
        wanted: new values by dotted name; None deletes a key of a group.
        groups: whose keys the user chooses and may change.

    Raises:
        ConfigError: the text of an entry is no mapping.
    """
    new = dict(values)
    for name, value in wanted.items():
        parts = name.split(".")
        if parts[0] not in groups:
            new[name] = _plain(value)
        elif len(parts) == 2:
            for old in [one for one in new if one.startswith(f"{name}.")]:
                del new[old]
            new.update(_entry(name, value))
        elif value is None:
            new.pop(name, None)
        else:
            new[name] = _plain(value)
    return new


def _entry(name: str, value: Any) -> dict[str, Any]:
    """Return the keys of an entry of a group that is given as text."""
    if value is None or (isinstance(value, str) and not value.strip()):
        return {}
    try:
        content = yaml_of_text(value) if isinstance(value, str) else None
    except InputError as error:
        raise ConfigError(f"{name}: {error}") from error
    if not isinstance(content, dict) or not content:
        raise ConfigError(
            f"{name} must be text with its keys, such as {{key: value}}, or empty to remove it, "
            f"not {shown(value)}."
        )
    return flatten(content, f"{name}.")


def _plain(value: Any) -> Any:
    """Return lists and ROS's arrays as tuples."""
    if isinstance(value, str | bytes) or not hasattr(value, "__iter__"):
        return value
    return tuple(value)
