# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Topics whose names end with the version of their message, as PX4's do from version 1 on."""

from __future__ import annotations

import re
from collections.abc import Iterable


def newest_version(topic: str, present: Iterable[str]) -> str:
    """Return the topic itself if present, else its newest version, else itself.

    Args:
        topic: full name without version, such as `/fmu/out/vehicle_local_position`.
        present: full names of published or recorded topics.
    """
    names = set(present)
    if topic in names:
        return topic
    pattern = re.compile(re.escape(topic) + r"_v(\d+)")
    versions = [(int(match[1]), match[0]) for match in map(pattern.fullmatch, names) if match]
    return max(versions)[1] if versions else topic
