# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The shipped RViz configuration in a namespace."""

from __future__ import annotations

import re

_TOPIC = re.compile(r"(?m)^(\s+Value: )/(?!tf\b|tf_static\b|diagnostics\b)(\S+)$")
_FRAME = re.compile(r"(?m)^(\s+Fixed Frame: )(\S+)$")


def rviz_in_namespace(text: str, namespace: str) -> str:
    """Return an RViz configuration with its topics and fixed frame below a namespace.

    Args:
        text: of the file, with topics from the root.
        namespace: such as `drone1` or `/fleet/drone1`; empty: the root.
    """
    prefix = namespace.strip("/")
    if not prefix:
        return text
    return _FRAME.sub(rf"\g<1>{prefix}/\g<2>", _TOPIC.sub(rf"\g<1>/{prefix}/\g<2>", text))
