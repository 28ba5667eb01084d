# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports an import: what was read, guessed and refused."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.dji_flight import height_guess
from aerial_gnss_ros.adapters.dji_log import DjiLog, RefusedRow, summarise_refusals
from aerial_gnss_ros.bags.alignment import Alignment
from aerial_gnss_ros.bags.maps import iso_time
from aerial_gnss_ros.bags.video import Video
from aerial_gnss_ros.commands.camera_arguments import ChosenCamera
from aerial_gnss_ros.core.config.telemetry import AttitudeConfig, GimbalConfig
from aerial_gnss_ros.text.sentences import counted

_LINES_SHOWN = 8
_WIDTH = 100
_GAPS_SHOWN = 5
_ANGLES = {"attitude": AttitudeConfig().max_gap, "gimbal": GimbalConfig().max_gap}


@dataclass(frozen=True)
class Imported:
    """Data of an import report.

    Attributes:
        path: of the bag.
        log: the flight.
        camera: as described in the bag.
        video: the file.
        alignment: start of the video in the log's time.
        every: every n-th frame was imported.
        start_ns: Unix time of the log's time zero, ns.
        counts: messages by topic.
        water_level: above the take-off point, m; None if not given.
    """

    path: Path
    log: DjiLog
    camera: ChosenCamera | None
    video: Video | None
    alignment: Alignment | None
    every: int
    start_ns: int
    counts: dict[str, int]
    water_level: float | None = None

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""
        return float(self.log.stamps_ns[-1] - self.log.stamps_ns[0]) * 1e-9


def as_json(done: Imported) -> dict[str, object]:
    """Return the summary as JSON."""
    found: dict[str, object] = {
        "bag": str(done.path),
        "rows": len(done.log),
        "duration_s": done.duration_s,
        "start": iso_time(done.start_ns),
        "messages": done.counts,
        "conversions": list(done.log.statements),
        "guesses": list(_guesses(done)),
        "gaps_s": [list(gap) for gap in done.log.gaps_s],
        "refused_lines": _by_reason(done.log.refused),
    }
    if done.video is not None and done.alignment is not None:
        found["video"] = {
            "path": str(done.video.path),
            "size": [done.video.width, done.video.height],
            "rate_hz": done.video.rate_hz,
            "duration_s": done.video.duration_s,
            "begins_at_s": done.alignment.start_s,
            "known_from": done.alignment.how,
        }
    if done.camera is not None:
        found["camera"] = {"source": done.camera.source, "warnings": done.camera.warnings}
    return found


def as_text(done: Imported) -> str:
    """Return the summary as text."""
    lines = [f"{done.log.path}: {counted(len(done.log), 'row')}, {done.duration_s:.1f} s"]
    groups = {
        "read": list(_read(done)),
        "guessed": list(_guesses(done)) or ["nothing"],
        "refused": list(_refused(done)) or ["nothing"],
    }
    for group, texts in groups.items():
        lines.append("")
        for i, text in enumerate(texts):
            first = f"  {group if i == 0 else '':<9}"
            lines.append(
                textwrap.fill(
                    text,
                    _WIDTH,
                    initial_indent=first,
                    subsequent_indent=" " * 13,
                    break_on_hyphens=False,
                )
            )
    lines += ["", f"{done.path}:"]
    lines += [f"  {topic:<28} {counted(count, 'message')}" for topic, count in done.counts.items()]
    return "\n".join(lines)


def _read(done: Imported) -> Iterator[str]:
    yield from done.log.statements
    if done.water_level is not None:
        yield (
            f"water level: {done.water_level:g} m above the take-off point (--water-level); height "
            "above water = height - water_level"
        )
    if done.log.clock_ns is not None:
        yield f"start: {iso_time(done.start_ns)}"
    if done.video is not None and done.alignment is not None:
        video = done.video
        each = "every frame" if done.every == 1 else f"one frame in {done.every}"
        yield (
            f"video: {video.path}, {video.width}x{video.height}, {video.rate_hz:.2f} frames a "
            f"second, {video.duration_s:.1f} s; {each} re-encoded as JPEG (an H.264 frame cannot "
            "be copied)"
        )
        yield f"video begins at {done.alignment.start_s:g} s: {done.alignment.how}"
    if done.camera is not None:
        yield f"camera: {done.camera.source}"


def _guesses(done: Imported) -> Iterator[str]:
    stated = done.water_level is not None  # then the height is not guessed
    yield from (guess for guess in done.log.guesses if not (stated and guess in _of_height(done)))
    under_water = done.log.lowest - (done.water_level or 0.0)
    if stated and under_water <= 0.0:
        yield (
            f"height: down to {under_water:.1f} m above the water with this --water-level; images "
            "from there give no positions; check its sign"
        )
    if done.log.clock_ns is None:
        yield f"date: the log has none in UTC, so it begins at {iso_time(done.start_ns)}"
    if done.camera is None:
        yield (
            "camera: none in the bag; give --camera, or --image-size, --focal-length-mm and "
            "--sensor-width-mm, for one"
        )
    else:
        yield from (f"camera: {warning}" for warning in done.camera.warnings)


def _of_height(done: Imported) -> tuple[str, ...]:
    return (height_guess(done.log.lowest),) if len(done.log.height) else ()


def _refused(done: Imported) -> Iterator[str]:
    if done.log.refused:
        words = summarise_refusals(done.log.refused, _LINES_SHOWN)
        yield f"{words}; --json lists every line"
    step = float(np.median(np.diff(done.log.seconds)))
    slow = [k for k, most in _ANGLES.items() if len(getattr(done.log, k)) and step > most]
    if slow:
        keys = " and ".join(f"{name}.max_gap ({_ANGLES[name]:g} s)" for name in slow)
        yield (
            f"rows are {step:.1f} s apart, more than {keys} allows: images between them give no "
            "positions; raise it if the camera was held still"
        )
    gaps = done.log.gaps_s
    if gaps:
        shown = ", ".join(f"{length:.1f} s after {at:.1f} s" for at, length in gaps[:_GAPS_SHOWN])
        more = f" and {len(gaps) - _GAPS_SHOWN} more" if len(gaps) > _GAPS_SHOWN else ""
        yield f"gaps in the log: {shown}{more}; images in a gap give no positions"


def _by_reason(refused: tuple[RefusedRow, ...]) -> dict[str, list[int]]:
    lines: dict[str, list[int]] = {}
    for row in refused:
        lines.setdefault(row.reason, []).append(row.line)
    return lines
