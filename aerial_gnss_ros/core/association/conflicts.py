# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Resolves detections claimed by several tracks."""

from __future__ import annotations

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL


def without_disputed(
    tracks: list[Track],
    rows: list[int],
    columns: list[int],
    chosen: list[int],
    log: list[float],
    kind: list[str],
    stamp_ns: int,
) -> list[int]:
    """Drop assigned boxes that may belong to another robot that was out of view.

    A robot out of view for long is not updated by a single box. Where a box could be that robot as
    well as another one whose position has become uncertain, neither is updated: the box starts a
    track, which `reidentification` decides with all evidence.

    Args:
        tracks: all of them.
        rows: of the pairs.
        columns: of the pairs.
        chosen: assigned pairs.
        log: log likelihood of each pair.
        kind: of each track; "" is not updated by a single box.
        stamp_ns: of the image, ns.
    """
    for k in list(chosen):
        if stamp_ns - tracks[rows[k]].last_seen_ns <= MOTION_MODEL.held_s * 1e9:
            continue
        least = log[k] - CLEAR_NATS
        if any(
            log[i] > least and columns[i] == columns[k] and not kind[row]
            and tracks[row].robot_id and tracks[row].class_id == tracks[rows[k]].class_id
            for i, row in enumerate(rows)
        ):  # fmt: skip
            chosen = [one for one in chosen if one != k]
    return chosen


def keep_established(
    tracks: list[Track],
    rows: list[int],
    columns: list[int],
    chosen: list[int],
    inside: list[int],
    away_ns: int,
) -> list[int]:
    """Return the assignment with each contested box left to the track that has had it so far.

    Two tracks of which each image shows only one may be one robot. If the nearer one took the box,
    the label would alternate; so it stays with the one seen last, and the other coasts until an
    image shows both. If images have shown both, the better fit takes it, since detectors miss
    robots now and then; but no robot returns from a longer absence in the very image that misses
    the other one.

    Args:
        tracks: all of them.
        rows: of the pairs.
        columns: of the pairs.
        chosen: assigned pairs.
        inside: pairs inside robots' gates.
        away_ns: robots last seen before this stamp were out of view, not just missed, ns.
    """
    if len(inside) == len(chosen):
        return chosen
    rivals: dict[int, list[int]] = {}
    for k in inside:
        rivals.setdefault(columns[k], []).append(k)
    found, wearing = list(chosen), {rows[k] for k in chosen}
    for place, k in enumerate(chosen):
        track = tracks[rows[k]]
        wearers = [
            other
            for other in rivals[columns[k]]
            if rows[other] not in wearing
            and tracks[rows[other]].last_seen_ns > track.last_seen_ns
            and (track.last_seen_ns < away_ns or not tracks[rows[other]].coexisted(track))
        ]
        if wearers:
            found[place] = max(wearers, key=lambda other: tracks[rows[other]].last_seen_ns)
            wearing.symmetric_difference_update((rows[k], rows[found[place]]))
    return found
