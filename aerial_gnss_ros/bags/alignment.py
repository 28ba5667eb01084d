# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Aligns a video with a flight record; refuses a video of another flight."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.adapters.dji_flight import DjiLog
from aerial_gnss_ros.core.values.errors import InputError

_SLACK_S = 2.0
_SHARE = 0.02
_FIX_IT = "give --offset SECONDS (log time of the video's start), or the right files"


@dataclass(frozen=True)
class Alignment:
    """Start of a video.

    Attributes:
        start_s: in the log's time, s.
        how: source of the start time, in words.
    """

    start_s: float
    how: str


def align(
    log: DjiLog,
    duration_s: float,
    offset_s: float | None = None,
    recording: int | None = None,
) -> Alignment:
    """Return the start of a video in the log's time.

    Args:
        log: the flight.
        duration_s: of the video.
        offset_s: log time of its start, from the user.
        recording: which of the log's recordings it is, from 1, from the user.

    Raises:
        InputError: the durations do not match, or the start is unknown.
    """
    if recording is not None and offset_s is not None:
        raise InputError("--recording and --offset contradict each other; give one.")
    if offset_s is not None:
        start = Alignment(offset_s, f"--offset {offset_s:g} s")
    elif log.of_video:
        start = Alignment(0.0, "the subtitles have the video's own times")
    else:
        start = _marked(log, duration_s, recording)
    _check_overlap(log, duration_s, start.start_s)
    return start


def _marked(log: DjiLog, duration_s: float, recording: int | None) -> Alignment:
    spans = log.recordings_s
    if not spans:
        raise InputError(
            f"{log.path} does not mark when the video was recorded (no isVideo column, or never "
            f"true); {_FIX_IT}."
        )
    if recording is not None and not 1 <= recording <= len(spans):
        raise InputError(f"--recording {recording}: the log marks {len(spans)}: {_listed(spans)}.")
    chosen = [recording - 1] if recording is not None else list(range(len(spans)))
    slack = max(_SLACK_S, _SHARE * duration_s)
    fitting = [i for i in chosen if abs(spans[i][1] - spans[i][0] - duration_s) <= slack]
    if len(fitting) == 1:
        begin, end = spans[fitting[0]]
        return Alignment(
            begin,
            f"recording {fitting[0] + 1} of the log ({begin:.1f} to {end:.1f} s), accurate to "
            "about 1 s: the marker is coarse",
        )
    if fitting:
        numbers = " and ".join(str(i + 1) for i in fitting)
        raise InputError(
            f"recordings {numbers} of the log both fit the video's {duration_s:.1f} s: "
            f"{_listed(spans)}; choose with --recording."
        )
    raise InputError(
        f"log and video are of different flights: the video lasts {duration_s:.1f} s, and the "
        f"recordings that {log.path} marks are {_listed(spans)}; {_FIX_IT}."
    )


def _check_overlap(log: DjiLog, duration_s: float, start_s: float) -> None:
    first, last = float(log.seconds[0]), float(log.seconds[-1])
    slack = max(_SLACK_S, _SHARE * duration_s)
    if start_s < first - slack or start_s + duration_s > last + slack:
        raise InputError(
            f"log and video do not match: the video would last from {start_s:.1f} to "
            f"{start_s + duration_s:.1f} s, but {log.path} covers {first:.1f} to {last:.1f} s; "
            f"{_FIX_IT}."
        )


def _listed(spans: tuple[tuple[float, float], ...]) -> str:
    return ", ".join(
        f"{i}: {end - begin:.1f} s from {begin:.1f} s" for i, (begin, end) in enumerate(spans, 1)
    )
