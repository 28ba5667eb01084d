# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which tracks each reference may be, and where on the water its box is expected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.label_format import class_token
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

Array = NDArray[np.float64]


class NamedTrack(Protocol):
    """What is read of a track, or of a fleet's robot."""

    @property
    def robot_id(self) -> str:
        """Its label; empty without one."""

    @property
    def class_id(self) -> str:
        """Its class."""

    @property
    def last_seen_ns(self) -> int:
        """Time of its last box, ns."""


@dataclass(frozen=True)
class Expected:
    """Where the box of a reference should be.

    Attributes:
        name: of the reference.
        class_id: class name as the detector gives it.
        position: (2,) East, North, m.
        spread: (2, 2) covariance of that, m².
        moves: whether it holds for one image only.
    """

    name: str
    class_id: str
    position: Array
    spread: Array
    moves: bool = False

    @classmethod
    def of(cls, place: ReferencePlace, pose: CameraPose, local: LocalMap) -> Expected:
        """Return where a camera shows a reference.

        Args:
            place: of the reference.
            pose: of the camera.
            local: the map.
        """
        position = _expected_position(place, pose, local)
        return cls(place.name, place.class_id, position, place.covariance, place.moves)


@dataclass(frozen=True)
class Motion:
    """Apparent motion of a track that may be a reference that stays.

    Attributes:
        nats: log odds that it is the reference and stays, to that it is something else.
        adrift: log odds that it is the reference and has come loose, to the same.
        metres: by which it has moved, where what speaks for that is most; 0: nothing does.
        misfit: what other tracks are off by, one variance of each axis, if it stays: its motion is
            then an error of the platform beyond the stated ones, m².
    """

    nats: float = 0.0
    adrift: float = 0.0
    metres: float = 0.0
    misfit: float = 0.0


_NO_MOTION = Motion()


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
        motions: of its tracks, by row, as far as they are known.
    """

    name: str
    position: Array
    spread: Array
    rows: tuple[int, ...]
    crowded: bool = False
    stays: bool = False
    motions: Mapping[int, Motion] = field(default_factory=dict)

    def motion(self, row: int) -> Motion:
        """Return the motion of a track; none if nothing is known of it."""
        return self.motions.get(row, _NO_MOTION)


def candidates_of(
    expected: Sequence[Expected],
    stamp_ns: int,
    tracks: Sequence[NamedTrack],
    links: Mapping[str, str],
) -> list[Candidate]:
    """Return the references of an image with the tracks that each may be.

    A track may be a reference of its class if it is in view or already is that reference.

    Args:
        expected: references.
        stamp_ns: of the image, ns.
        tracks: by row of the filter.
        links: label of the track that each used reference is.
    """
    return [
        Candidate(
            one.name,
            one.position,
            one.spread,
            _rows(one, stamp_ns, tracks, links.get(one.name)),
            stays=not one.moves,
        )
        for one in expected
    ]


def with_crowding(found: Sequence[Candidate], expected: Sequence[Expected]) -> dict[str, Candidate]:
    """Return candidates by name, marked where there are more tracks than references of a class."""
    classes = [one.class_id for one in expected]
    return {
        one.name: replace(one, crowded=len(one.rows) > classes.count(class_id))
        for one, class_id in zip(found, classes, strict=True)
    }


def _rows(
    one: Expected, stamp_ns: int, tracks: Sequence[NamedTrack], label: str | None
) -> tuple[int, ...]:
    """Return the tracks that a reference may be."""
    token = class_token(one.class_id)
    return tuple(
        row
        for row, track in enumerate(tracks)
        if track.robot_id
        and class_token(track.class_id) == token
        and (track.last_seen_ns == stamp_ns or track.robot_id == label)
    )


def below_camera(
    places: Sequence[ReferencePlace], pose: CameraPose, log: Events
) -> list[ReferencePlace]:
    """Return the references below the camera; where one is above it, `log` says so once."""
    for one in places:
        if one.height >= pose.height:
            log.warn_once(
                f"{one.name} is above the camera",
                f"Reference {one.name} is not used from below it: references.{one.name}.height_m "
                f"is {one.height:g} m, and the camera is {pose.height:.1f} m above the water.",
            )
    return [one for one in places if one.height < pose.height]


def _expected_position(place: ReferencePlace, pose: CameraPose, local: LocalMap) -> Array:
    """Return where the line of sight to a reference meets the water (2,), m.

    What stands out of the water appears farther from the camera than it is.
    """
    position: Array = local.positions([place.latitude], [place.longitude])[0]
    high = place.height
    if high:
        camera = local.positions([pose.latitude], [pose.longitude])[0]
        position = position + high / (pose.height - high) * (position - camera)
    return position
