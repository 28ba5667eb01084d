# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Summary of a replay as text and JSON; every box is used or refused for a reason."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.replay import Summary
from aerial_gnss_ros.core.values.rejection import Cause, Reason
from aerial_gnss_ros.text.sentences import counted

WIDTH = 100
"""Line width in columns."""


def as_json(
    output: Path, summary: Summary, names: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the summary as JSON values; `names` are the truth's by label."""
    return {
        "output": str(output),
        "detections_from": summary.detections_from,
        "frames": summary.frames,
        "positions": sum(summary.positions.values()),
        "robots": dict(sorted(summary.positions.items())),
        "coasting": dict(sorted(summary.coasting.items())),
        "truth": dict(sorted((names or {}).items())),
        "boxes": summary.boxes,
        "boxes_used": summary.used,
        "rejections": dict(sorted(summary.rejections.items())),
        "unconfirmed": {str(cause): n for cause, n in sorted(summary.causes.items())},
        "images_refused": summary.images_refused,
        "images_dropped": dict(sorted(summary.images_dropped.items())),
        "notes": summary.notes,
    }


def as_text(output: Path, summary: Summary, names: Mapping[str, str] | None = None) -> str:
    """Return the summary in words; `names` are the truth's by label."""
    robots = summary.positions
    positions = sum(robots.values())
    counts = (summary.frames, "image"), (len(robots), "robot"), (positions, "position")
    coasting = _coasting(sum(summary.coasting.values()))
    coasting += " (predicted, not seen)" if coasting else ""
    lines = [f"{output}: {', '.join(counted(*one) for one in counts)}{coasting}"]
    lines += [
        f"  {name:<24} {counted(count, 'position')}{_coasting(summary.coasting[name])}"
        f"{_truly(name, names or {})}"
        for name, count in sorted(robots.items())
    ]
    lines += boxes(summary)
    if summary.images_refused:
        lines.append(f"unusable images: {summary.images_refused}")
    for reason, count in sorted(summary.images_dropped.items()):
        lines.append(f"images skipped ({reason}): {count}")
    return "\n".join(lines)


def _coasting(count: int) -> str:
    return f", of which {count} coasting" if count else ""


def _truly(label: str, names: Mapping[str, str]) -> str:
    if not names:
        return ""
    return f", truly {names[label]}" if label in names else ", no true robot"


def boxes(summary: Summary) -> list[str]:
    """Return lines that account for every box, the most frequent reason first."""
    refused = sum(summary.rejections.values())
    if not refused:
        return [f"boxes: {summary.boxes}, refused: none"]
    lines = [f"boxes: {summary.boxes}, of which {summary.used} updated robots; refused: {refused}"]
    for name, count in summary.rejections.most_common():
        lines += _explained(f"  {name:<24} {count:>6}", Reason(name).meaning)
        if name == Reason.UNCONFIRMED:
            for cause, share in summary.causes.most_common():
                lines += _explained(f"    {cause!s:<22} {share:>6}", _words(cause, summary))
    return lines


def folded(notes: Iterable[str]) -> list[str]:
    """Return sentences in order, merging those that differ only in numbers into the first."""
    first: dict[str, str] = {}
    more: dict[str, int] = {}
    for note in notes:
        kind = re.sub(r"\d[\d.,]*", "#", note)
        more[kind] = more.get(kind, -1) + 1
        first.setdefault(kind, note)
    return [
        f"{note} ({more[kind]} more such)" if more[kind] else note for kind, note in first.items()
    ]


def _words(cause: Cause, summary: Summary) -> str:
    if cause is not Cause.IMAGES_TOO_SELDOM:
        return cause.meaning
    return f"{cause.meaning} (here one each {summary.interval_s:.2g} s)"


def _explained(start: str, meaning: str) -> list[str]:
    """Return lines with a meaning beside a count, wrapped below it if longer."""
    return textwrap.wrap(
        meaning, WIDTH, initial_indent=f"{start}  ", subsequent_indent=" " * (len(start) + 2)
    )
