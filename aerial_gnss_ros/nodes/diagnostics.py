# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Status lines and the /diagnostics message made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from aerial_gnss_ros.nodes.arrivals import SILENCE_S
from aerial_gnss_ros.nodes.inputs import ONCE, OPTIONAL, Input
from aerial_gnss_ros.text.plain_text import printable

OK: bytes = DiagnosticStatus.OK
WARN: bytes = DiagnosticStatus.WARN
ERROR: bytes = DiagnosticStatus.ERROR
STALE: bytes = DiagnosticStatus.STALE


@dataclass(frozen=True)
class Status:
    """One line of /diagnostics.

    Attributes:
        name: of the component within the node.
        level: OK, WARN, ERROR or STALE.
        message: its condition, in words.
        values: details, in display order.
    """

    name: str
    level: bytes
    message: str
    values: Mapping[str, Any] = field(default_factory=dict)


def input_status(source: Input, now_ns: int) -> Status:
    """Return the status line of an input.

    Args:
        source: the input.
        now_ns: time of the clock that recorded its arrivals, ns.
    """
    age_s = source.arrivals.age_s(now_ns)
    level, words = OK, "received"
    if age_s is None:
        level = OK if source.expected == OPTIONAL else STALE
        words = "optional, not given" if source.expected == OPTIONAL else "never received"
    elif age_s >= SILENCE_S and source.missed:
        level, words = WARN, f"silent for {age_s:.0f} s"
    elif age_s >= SILENCE_S and source.expected == ONCE:
        words = "received, the last value holds"
    values = {
        "topic": source.topic,
        "messages": source.arrivals.count,
        "rate_hz": source.arrivals.rate(now_ns),
        "age_s": "never" if age_s is None else age_s,
        "lost_in_transport": source.lost,
    }
    return Status(source.name, level, words, values)


def diagnostic_array(node: str, stamp: Any, lines: Sequence[Status]) -> Any:
    """Return the message.

    Args:
        node: full name of the node.
        stamp: builtin_interfaces/Time.
        lines: in display order.
    """
    prefix = node.lstrip("/")
    made = DiagnosticArray()
    made.header.stamp = stamp
    made.status = [
        DiagnosticStatus(
            name=f"{prefix}: {line.name}",
            level=line.level,
            message=printable(line.message),
            hardware_id=prefix,
            values=[KeyValue(key=key, value=_text(value)) for key, value in line.values.items()],
        )
        for line in lines
    ]
    return made


def _text(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, float) else printable(str(value))
