# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which tracks each reference may be, and where on the water its box is expected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.label_format import class_token
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """A reference and the tracks that it may be.

    Attributes:
        name: of the reference.
        position: (2,) East, North where its box should be, m.
        spread: (2, 2) covariance of that, m².
        rows: the tracks.
        crowded: whether there are more tracks of its class than references.
        stays: whether it does not move.
    """

    name: str
    position: Array
    spread: Array
    rows: tuple[int, ...]
    crowded: bool = False
    stays: bool = False


def candidates_of(
    frame: PosedFrame, local: LocalMap, tracks: Sequence[Track], links: Mapping[str, str]
) -> list[Candidate]:
    """Return the references of an image with the tracks that each may be.

    A track may be a reference of its class if it is in view or already is that reference.

    Args:
        frame: the image, with the positions of references at its time.
        local: the map.
        tracks: by row of the filter.
        links: label of the track that each used reference is.
    """
    return [
        Candidate(
            place.name,
            _expected_position(place, frame, local),
            place.covariance,
            _rows(place, frame, tracks, links.get(place.name)),
            stays=not place.moves,
        )
        for place in frame.references
    ]


def with_crowding(
    found: Sequence[Candidate], places: Sequence[ReferencePlace]
) -> dict[str, Candidate]:
    """Return candidates by name, marked where there are more tracks than references of a class."""
    classes = [place.class_id for place in places]
    return {
        one.name: replace(one, crowded=len(one.rows) > classes.count(place.class_id))
        for one, place in zip(found, places, strict=True)
    }


def _rows(
    place: ReferencePlace, frame: PosedFrame, tracks: Sequence[Track], label: str | None
) -> tuple[int, ...]:
    """Return the tracks that a reference may be."""
    token, stamp_ns = class_token(place.class_id), frame.detections.stamp_ns
    return tuple(
        row
        for row, track in enumerate(tracks)
        if track.robot_id
        and class_token(track.class_id) == token
        and (track.last_seen_ns == stamp_ns or track.robot_id == label)
    )


def _expected_position(place: ReferencePlace, frame: PosedFrame, local: LocalMap) -> Array:
    """Return where the line of sight to a reference meets the water (2,), m.

    What stands out of the water appears farther from the camera than it is.
    """
    position: Array = local.positions([place.latitude], [place.longitude])[0]
    pose, high = frame.pose, place.height
    if 0.0 < high < pose.height:
        camera = local.positions([pose.latitude], [pose.longitude])[0]
        position = position + high / (pose.height - high) * (position - camera)
    return position
