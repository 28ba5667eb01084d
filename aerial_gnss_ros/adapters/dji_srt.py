# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads SRT subtitles with telemetry, which DJI drones write beside their videos.

Supported generations: `GPS(lon,lat,sats) BAROMETER:h` (Phantom 3, 4); `GPS (lon, lat, sats), D …m,
H …m`, with or without `F.PRY (p°, r°, y°), G.PRY (p°, r°, y°)` (Mavic Mini, Phantom 4 RTK);
brackets `[latitude: …] [longtitude: …] [altitude: …] [Drone: Yaw:…]` (Mavic Air, 2 Enterprise);
`[rel_alt: … abs_alt: …]` (Mini 3, Air 3); `[gb_yaw: … gb_pitch: … gb_roll: …]` (Mavic 3 Enterprise,
M30). The times are those of the video.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.dji_flight import (
    DjiLog,
    RefusedRow,
    height_guess,
    position_refusal,
    quaternions,
    range_refusal,
    summarise_refusals,
)
from aerial_gnss_ros.core.geometry.frames import yaw_from_heading
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.text.sentences import counted

_N = r"([-+]?\d+(?:\.\d+)?)"
_TIMES = re.compile(r"(\d+):(\d\d):(\d\d)[,.](\d{3})\s*--\s?>")
_GPS = re.compile(rf"\b(?:GPS|RTK)\s*\(\s*{_N}\s*,\s*{_N}\s*[,)]", re.IGNORECASE)
_COLON = r"\s*(?::\s*)?"  # not \s*:?\s*, whose time grows with the square of the spaces
_LATITUDE = re.compile(rf"latitude{_COLON}{_N}", re.IGNORECASE)
_LONGITUDE = re.compile(rf"longt?itude{_COLON}{_N}", re.IGNORECASE)
_HEIGHTS = {
    "rel_alt": re.compile(rf"rel_alt{_COLON}{_N}", re.IGNORECASE),
    "H": re.compile(rf"\bH{_COLON}{_N}\s?m\b"),
    "BAROMETER": re.compile(rf"BAROMETER\s*:\s*{_N}", re.IGNORECASE),
}
_ALTITUDE = re.compile(rf"\baltitude\s*:\s*{_N}", re.IGNORECASE)


def _triple(*names: str) -> re.Pattern[str]:
    return re.compile(r"[\s,]*".join(rf"{name}\s*:\s*{_N}" for name in names), re.IGNORECASE)


def _pry(name: str) -> re.Pattern[str]:
    return re.compile(rf"{name}\.PRY\s*\(\s*{_N}°?\s*,\s*{_N}°?\s*,\s*{_N}°?\s*\)")


# Pattern, and the groups of roll, pitch and yaw in it.
_GIMBAL = ((_triple("gb_yaw", "gb_pitch", "gb_roll"), (2, 1, 0)), (_pry("G"), (1, 0, 2)))
_BODY = (
    (_triple("drone_yaw", "drone_pitch", "drone_roll"), (2, 1, 0)),
    (re.compile(rf"Drone\s*:\s*Yaw\s*:\s*{_N}\s*,\s*Pitch\s*:\s*{_N}\s*,\s*Roll\s*:\s*{_N}"),
     (2, 1, 0)),
    (_pry("F"), (1, 0, 2)),
)  # fmt: skip
_DIGITAL_ZOOM = re.compile(rf"dzoom_ratio\s*:\s*{_N}", re.IGNORECASE)
_FOCAL_LENGTH = re.compile(rf"focal_len\s*:\s*{_N}", re.IGNORECASE)
_ZOOM_UNIT = 10_000.0  # Mavic 3 writes 10000 for 1.0
_MOST_BYTES = 200_000_000
_MOST_TEXT = 10_000
"""Characters of a subtitle; DJI's have less than a thousand."""
_EXPECTED = (
    "GPS (longitude, latitude, …), or [latitude: …] [longitude: …], and for the camera gb_yaw, "
    "gb_pitch, gb_roll or G.PRY"
)


def read_srt(path: Path) -> DjiLog:
    """Read a telemetry subtitle file; see `dji_log.read_dji_log`."""
    blocks = list(_blocks(path))
    if not blocks:
        raise InputError(f"{path} holds no subtitles; expected blocks with `0:00:01,000 --> …`.")
    swapped = _is_latitude_first([text for _, _, text in blocks])
    rows: list[tuple[float, ...]] = []
    refused: list[RefusedRow] = []
    sources: set[str] = set()
    last = -1.0
    for line, time, text in blocks:
        row, reason = _row(time, text, swapped, sources)
        reason = reason or ("time does not increase" if time <= last else None)
        if row is None or reason:
            refused.append(RefusedRow(line, reason or ""))
            continue
        last = time
        rows.append(row)
    if len(rows) < 2:
        words = re.sub(r"<[^>]*>|\n\d+\s*$", "", blocks[0][2])  # without the next one's number
        sample = " ".join(words.split())[:160]
        why = summarise_refusals(refused)
        raise InputError(
            f"{path} has {len(rows)} usable subtitles, and a flight needs two ({why}); the first "
            f"one reads «{sample}»; expected: {_EXPECTED}."
        )
    zoom = _zoom([text for _, _, text in blocks])
    return _flight(path, np.array(rows, dtype=np.float64), refused, sources, swapped, zoom)


def _blocks(path: Path) -> Iterator[tuple[int, float, str]]:
    """Yield line number, time in s and text of each subtitle."""
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}.") from error
    if len(content) > _MOST_BYTES:
        raise InputError(
            f"{path} is larger than {_MOST_BYTES // 1_000_000} MB, too large for subtitles."
        )
    lines = content.decode("utf-8-sig", errors="replace").splitlines()
    start, time, text = 0, 0.0, list[str]()
    for number, line in enumerate(lines, start=1):
        match = _TIMES.match(line.strip())
        if match is None:
            text.append(line)
            continue
        if start:
            yield start, time, "\n".join(text)[:_MOST_TEXT]
        hours, minutes, seconds, thousandths = map(float, match.groups())
        start, time = number, 3600.0 * hours + 60.0 * minutes + seconds + thousandths * 1e-3
        text = []
    if start:
        yield start, time, "\n".join(text)[:_MOST_TEXT]


def _is_latitude_first(texts: list[str]) -> bool:
    """Whether GPS(a, b) must be latitude first: b could not be a latitude."""
    pairs = [(float(m[1]), float(m[2])) for text in texts if (m := _GPS.search(text))]
    return any(abs(b) > 90.0 for _, b in pairs) and all(abs(a) <= 90.0 for a, _ in pairs)


def _zoom(texts: list[str]) -> list[str]:
    """Return signs of a changing focal length, in words; usually empty."""
    ratios = {float(match[1]) for text in texts if (match := _DIGITAL_ZOOM.search(text))}
    zooms = sorted({r / _ZOOM_UNIT if r >= 0.5 * _ZOOM_UNIT else r for r in ratios})
    lengths = sorted({float(match[1]) for text in texts if (match := _FOCAL_LENGTH.search(text))})
    found = []
    if zooms and (zooms[0] != 1.0 or zooms[-1] != 1.0):
        found.append(f"dzoom_ratio is {_span(zooms)}")
    if len(lengths) > 1:
        found.append(f"focal_len is {_span(lengths)}")
    if not found:
        return []
    sentence = (
        f"zoom: {' and '.join(found)}, but one camera model applies to all images: positions from "
        "images at another zoom are wrong"
    )
    return [sentence]


def _span(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g} to {values[-1]:g}"


def _row(
    time: float, text: str, swapped: bool, sources: set[str]
) -> tuple[tuple[float, ...] | None, str | None]:
    """Return time, latitude, longitude, height, body and gimbal roll, pitch, yaw; or an error."""
    latitude, longitude, gps = _LATITUDE.search(text), _LONGITUDE.search(text), _GPS.search(text)
    if latitude and longitude:
        place = float(latitude[1]), float(longitude[1])
        sources.add("[latitude] [longitude]")
    elif gps:
        place = (float(gps[1]), float(gps[2])) if swapped else (float(gps[2]), float(gps[1]))
        sources.add("GPS(…)")
    else:
        return None, "no position"
    reason = position_refusal(*place)
    if reason:
        return None, reason
    height = float("nan")
    for name, pattern in _HEIGHTS.items():
        match = pattern.search(text)
        if match:
            height = float(match[1])
            sources.add(name)
            break
    else:
        if _ALTITUDE.search(text):
            sources.add("altitude")
    angles = *_angles(text, _BODY), *_angles(text, _GIMBAL)
    reason = range_refusal(time, height, angles)
    return (None, reason) if reason else ((time, *place, height, *angles), None)


def _angles(
    text: str, patterns: tuple[tuple[re.Pattern[str], tuple[int, int, int]], ...]
) -> tuple[float, ...]:
    for pattern, places in patterns:
        match = pattern.search(text)
        if match:
            return tuple(float(match[1 + place]) for place in places)
    return (float("nan"),) * 3


def _flight(
    path: Path,
    rows: Array,
    refused: list[RefusedRow],
    sources: set[str],
    swapped: bool,
    zoom: list[str],
) -> DjiLog:
    height = rows[:, 3]
    body, gimbal = _orientations(rows[:, 4:7]), _orientations(rows[:, 7:10])
    with_height = bool(np.isfinite(height).any())
    statements = ["time: of the video itself"]
    guesses = list(zoom)
    if "GPS(…)" in sources:
        order = "latitude, longitude" if swapped else "longitude, latitude"
        (statements if swapped else guesses).append(f"position: GPS(…) is {order}, …")
    else:
        statements.append("position: latitude and longitude")
    if with_height:
        used = next(name for name in _HEIGHTS if name in sources)
        statements.append(f"height: {used} (m), above the take-off point")
        guesses.append(height_guess(float(np.nanmin(height))))
        absent = int(np.isnan(height).sum())
        if absent:
            guesses.append(f"height: {counted(absent, 'subtitle')} of {len(rows)} without one")
    else:
        why = "altitude has no stated datum" if "altitude" in sources else "none is recorded"
        guesses.append(f"height: {why}, so the bag has none; give height.source: constant")
    for name, values in (("attitude", body), ("gimbal", gimbal)):
        if len(values):
            statements.append(f"{name}: roll, pitch, yaw from north (NED), given as FLU in ENU")
        else:
            guesses.append(
                f"{name}: not recorded in this file, so the bag has none"
                + ("; the flight record as CSV has it" if name == "gimbal" else "")
            )
    return DjiLog(
        path=path,
        stamps_ns=np.round(rows[:, 0] * 1e9).astype(np.int64),
        latitude=np.radians(rows[:, 1]),
        longitude=np.radians(rows[:, 2]),
        height=height if with_height else np.zeros(0),
        attitude=body,
        gimbal=gimbal,
        refused=tuple(refused),
        statements=tuple(statements),
        guesses=tuple(guesses),
        of_video=True,
    )


def _orientations(rpy_deg: Array) -> Array:
    """Return FLU in ENU (n, 4); (0, 4) if any row lacks an angle."""
    if not np.isfinite(rpy_deg).all():
        return np.zeros((0, 4))
    roll, pitch, yaw = rpy_deg.T
    return quaternions(roll, pitch, np.asarray(yaw_from_heading(np.radians(yaw))))
