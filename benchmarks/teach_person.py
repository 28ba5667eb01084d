# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a person who knows where the robots are does next in `aerial-gnss teach`.

Clicks each robot in the first frame in which it is whole; draws a box where the one that a click
gave is off; says yes to what is asked, or draws a box; clicks a robot again that is in view and has
no box. Questions about robots that are not in view as a whole stay without an answer, which leaves
out these frames. Boxes that are sure and wrong are not looked for.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.tracks import Sight, clipped, overlap

Labels = Sequence[tuple[str, NDArray[np.float64], str]]
"""Class, box (centre, size) and robot of each label in a frame."""
RIGHT_IOU = 0.5


@dataclass(frozen=True)
class Act:
    """One thing to do.

    Attributes:
        kind: "click", "box" or "yes".
        robot: its true name.
        frame: index.
        box: (4,) centre and size of the robot there.
    """

    kind: str
    robot: str
    frame: int
    box: NDArray[np.float64]


def next_act(session: Session, truth: Sequence[Labels], names: Mapping[str, str]) -> Act | None:
    """Return what to do next; None: nothing.

    Args:
        session: with the marks so far.
        truth: labels by frame.
        names: of the robots in the session, by their true ones; those not yet marked are missing.
    """
    at = [{robot: box for _, box, robot in labels} for labels in truth]
    acts = (
        _first_clicks(session, at, names),
        _corrections(session, at, names),
        _answers(session, at, names),
        _unseen(session, at, names),
    )
    return next(itertools.chain(*acts), None)


Boxes = Sequence[Mapping[str, NDArray[np.float64]]]


def _first_clicks(session: Session, at: Boxes, names: Mapping[str, str]) -> Iterator[Act]:
    for frame, boxes in enumerate(at):
        for robot, box in boxes.items():
            if robot not in names and _whole(box, session.recording.size):
                yield Act("click", robot, frame, box)


def _corrections(session: Session, at: Boxes, names: Mapping[str, str]) -> Iterator[Act]:
    """Yield boxes where a mark's is off."""
    newest = {(mark.robot, mark.frame): mark.box for mark in session.project.marks}
    for robot, name in names.items():
        for (marked, frame), box in newest.items():
            right = at[frame].get(robot)
            if (
                marked == name
                and box is not None
                and right is not None
                and overlap(box, right) < RIGHT_IOU
            ):
                yield Act("box", robot, frame, clipped(right, session.recording.size))


def _answers(session: Session, at: Boxes, names: Mapping[str, str]) -> Iterator[Act]:
    """Yield answers to questions, in the first frame in which the robot has a right box."""
    true_name = {name: robot for robot, name in names.items()}
    for asked in session.questions():
        robot, of = true_name[asked.robot], session.tracks[asked.robot]
        seen = [frame for frame in range(asked.frame, asked.until + 1) if robot in at[frame]]
        for frame in seen:
            if overlap(of[frame].box, at[frame][robot]) >= RIGHT_IOU:
                yield Act("yes", robot, frame, of[frame].box)
        if seen:
            box = clipped(at[seen[0]][robot], session.recording.size)
            yield Act("box", robot, seen[0], box)


def _unseen(session: Session, at: Boxes, names: Mapping[str, str]) -> Iterator[Act]:
    """Yield clicks on robots that are in view and have no box."""
    for frame, boxes in enumerate(at):
        for robot, box in boxes.items():
            track = session.tracks.get(names[robot], {}).get(frame)
            unseen = track is None or track.sight is Sight.OUT
            if unseen and _whole(box, session.recording.size):
                yield Act("click", robot, frame, box)


def _whole(box: NDArray[np.float64], size: tuple[int, int]) -> bool:
    low, high = box[:2] - box[2:] / 2.0, np.array(size) - box[:2] - box[2:] / 2.0
    return bool(min(*low, *high) > 2.0)
