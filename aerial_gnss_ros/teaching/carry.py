# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Carries marks to all frames of a recording, forwards and backwards in time, all robots at once.

Between two frames a box moves with the image (geometry or alignment) and by the robot's own
velocity; then it is placed on what stands out there (`proposals.py`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.teaching.proposals import Proposals
from aerial_gnss_ros.teaching.tracks import (
    TUNING,
    Sight,
    Track,
    absent,
    assigned,
    best,
    clipped,
    coasted,
    doubted,
    extents,
    likelihoods,
    overlap,
    predicted,
    started,
    turning,
    updated,
)

Array = NDArray[np.float64]
SIZE_RATIO = (0.67, 1.5)
"""Bounds of the length of an outline's diagonals relative to the mark's."""
FIT_RATIO = (0.75, 1.35)
"""Bounds of the drawn relative to the outlined box of a mark: how tightly the person draws."""
NEXT = 0.6
"""Distance from a box's middle, in its sides, within which another robot's middle is in it."""
FAR = 2.0
"""Distance from the image's middle, in its widths, beyond which a robot's pixels mean nothing."""


@dataclass(frozen=True)
class Mark:
    """A person's statement about a robot in a frame.

    Attributes:
        robot: its name.
        frame: index.
        box: (4,) centre x, y, width, height, px; None: it is not visible from here on, forwards
            and backwards to its next box.
    """

    robot: str
    frame: int
    box: Array | None


class Frames(Protocol):
    """Images of a recording and what is known of them."""

    size: tuple[int, int]
    """Width and height, px."""

    def __len__(self) -> int: ...

    def time(self, index: int) -> float:
        """Return a frame's time, s."""

    def proposals(self, index: int) -> Proposals:
        """Return what stands out in a frame."""

    def outline(self, index: int, box: Array) -> Array | None:
        """Return the box (4,) of what a rough box touches in a frame; None: nothing."""

    def look(self, index: int, box: Array) -> Array:
        """Return the colours (k,) in a box of a frame, see `proposals.looks`."""

    def clutter(self, index: int, box: Array) -> float:
        """Return the share of the pixels round a box that are no water."""

    def plane(self, index: int, point: Array) -> Array:
        """Return the pixels (2, 2) of a metre to the East and North at a point (2,) of a frame.

        Where the camera is unknown, they are those of any other unit: the identity.
        """

    def motion(self, first: int, second: int, points: Array) -> tuple[Array, float]:
        """Return where points (n, 2) px of one frame are in another (NaN: nowhere), and one sigma.

        The sigma is of the image's motion alone, px.
        """


Tracks = dict[str, dict[int, Track]]
"""What is known of each robot by frame; nothing of frames after it was lost."""


def carried(frames: Frames, marks: Sequence[Mark]) -> Tracks:
    """Return the tracks of each robot.

    Args:
        frames: of the recording.
        marks: of all robots; the last one counts for a robot in a frame.
    """
    anchors: dict[str, dict[int, Mark]] = {}
    for mark in marks:
        anchors.setdefault(mark.robot, {})[mark.frame] = mark
    runs = [_run(frames, anchors, step) for step in (1, -1)]
    result: Tracks = {}
    for robot in anchors:
        found = result.setdefault(robot, {})
        for frame in range(len(frames)):
            known = [run[robot][frame] for run in runs if frame in run[robot]]
            if known:
                found[frame] = best(known)
    _settle(result, anchors)
    return result


def _run(frames: Frames, anchors: Mapping[str, Mapping[int, Mark]], step: int) -> Tracks:
    """Carry all marks in one direction of time."""
    result: Tracks = {robot: {} for robot in anchors}
    active: dict[str, Track] = {}
    gone: dict[str, Track] = {}
    fits: dict[str, Array] = {}
    order = range(len(frames))[::step]
    for frame in order:
        fixed = {robot: of[frame] for robot, of in anchors.items() if frame in of}
        moving = {robot: one for robot, one in active.items() if robot not in fixed}
        active = _advanced(frames, moving, frame, fits)
        for robot, mark in fixed.items():
            track, fits[robot] = _begun(frames, mark)
            (gone if mark.box is None else active)[robot] = track
            if mark.box is not None:
                gone.pop(robot, None)
        for robot, track in gone.items():
            result[robot][frame] = absent(frame, track)
        for robot, track in active.items():
            result[robot][frame] = track
        active = {r: t for r, t in active.items() if t.sight is not Sight.LOST}
    return result


def _begun(frames: Frames, mark: Mark) -> tuple[Track, Array]:
    """Return the track at a mark, and how the drawn box relates to the outline there."""
    if mark.box is None:
        nowhere = started(mark.frame, np.array([0.0, 0.0, 1.0, 1.0]), np.zeros(1), np.eye(2))
        return absent(mark.frame, nowhere), np.ones(2)
    outline = frames.outline(mark.frame, mark.box)
    fit = np.ones(2)
    if outline is not None and overlap(outline, mark.box) > 0.3:
        fit = np.clip(mark.box[2:] / outline[2:], *FIT_RATIO)
    plane = frames.plane(mark.frame, mark.box[:2])
    return started(mark.frame, mark.box, frames.look(mark.frame, mark.box), plane), fit


def _advanced(
    frames: Frames, active: Mapping[str, Track], frame: int, fits: Mapping[str, Array]
) -> dict[str, Track]:
    """Return all tracks in the next frame."""
    result: dict[str, Track] = {}
    ahead: dict[str, tuple[Track, float]] = {}
    for robot, track in active.items():
        elapsed = abs(frames.time(frame) - frames.time(track.frame))
        middle = track.box[:2] + track.velocity * elapsed
        points = middle + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        moved, sigma = frames.motion(track.frame, frame, points)
        away = np.abs(moved[0] - 0.5 * np.array(frames.size)).max()
        if np.isfinite(moved).all() and away < FAR * frames.size[0]:
            ahead[robot] = predicted(track, frame, moved, sigma, elapsed), elapsed
        else:  # kept in its own frame's pixels until it comes nearer
            result[robot] = coasted(track, frames.size, out=True)
    found = _candidates(frames, frame, [track for track, _ in ahead.values()])
    values = np.array([likelihoods(track, found) for track, _ in ahead.values()])
    values = values.reshape(len(ahead), len(found.boxes))
    chosen, probability = assigned(values, found.boxes)
    for i, (robot, (track, elapsed)) in enumerate(ahead.items()):
        if chosen[i] < 0:
            result[robot] = coasted(track, frames.size)
            continue
        proposal = found.boxes[chosen[i]]
        box = _placed(frames, track, proposal, fits[robot])
        others = [
            (other.box, chosen[j] < 0) for j, (other, _) in enumerate(ahead.values()) if j != i
        ]
        if _merged(box, others) or _merged(proposal, others):
            result[robot] = doubted(track)
            continue
        cluttered = frames.clutter(frame, box) > TUNING.clutter
        result[robot] = updated(
            track,
            clipped(box, frames.size),
            found.looks[chosen[i]],
            min(float(probability[i]), 0.5 if cluttered else 1.0),
            elapsed,
        )
    return result


def _candidates(frames: Frames, frame: int, tracks: Sequence[Track]) -> Proposals:
    """Return what stands out in a frame, and the outlines where robots are expected.

    A long robot may be several proposals, and a faint one none.
    """
    found = frames.proposals(frame)
    own = [box for track in tracks for box in _expected(frames, track)]
    if not own:
        return found
    looks = [frames.look(frame, box) for box in own]
    return Proposals(np.vstack([found.boxes, *own]), np.vstack([found.looks, *looks]))


def _expected(frames: Frames, track: Track) -> list[Array]:
    """Return the outlines of what is where a robot is expected: as before, and however turned."""
    rough = [track.box, np.array([*track.box[:2], *turning(track)])]
    return [box for one in rough if (box := frames.outline(track.frame, one)) is not None]


def _merged(box: Array, others: Sequence[tuple[Array, bool]]) -> bool:
    """Return whether a box may show two robots that touch.

    Args:
        box: (4,) of one.
        others: predicted box of each other robot, and whether nothing shows it.
    """
    return any(
        bool((np.abs(other[:2] - box[:2]) <= NEXT * box[2:]).all())
        or (hidden and overlap(other, box) > 0.0)
        for other, hidden in others
    )


def _placed(frames: Frames, track: Track, proposal: Array, fit: Array) -> Array:
    """Return the box on a proposal: its outline, as tight as the person draws.

    The outline of a part is too small for the robot: then that of all that is where it may be.
    """
    around = np.concatenate([proposal[:2], np.maximum(proposal[2:], track.box[2:])])
    turned = np.array([*track.box[:2], *turning(track)])
    for rough in (around, turned):
        outline = frames.outline(track.frame, rough)
        if outline is None:
            continue
        box = np.concatenate([outline[:2], outline[2:] * fit])
        ratio = extents(box[None], track.plane)[0] / track.extent
        if SIZE_RATIO[0] < ratio < SIZE_RATIO[1]:
            return box
    # Moved no farther than needed to hold the part.
    room = np.maximum(track.box[2:] - proposal[2:], 0.0) / 2.0
    apart = track.box[:2] - proposal[:2]
    return np.concatenate([proposal[:2] + np.clip(apart, -room, room), track.box[2:]])


def _settle(result: Tracks, anchors: Mapping[str, Mapping[int, Mark]]) -> None:
    """Make labels unsure whose box another robot is in, unless a person marked them."""
    for robot, own in result.items():
        others = [found for name, found in result.items() if name != robot]
        for frame, track in own.items():
            if track.sight is not Sight.SURE or frame in anchors[robot]:
                continue
            near = [found[frame] for found in others if frame in found]
            boxes = [(t.box, False) for t in near if t.sight in (Sight.SURE, Sight.UNSURE)]
            if _merged(track.box, boxes):
                own[frame] = doubted(track)
