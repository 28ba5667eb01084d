# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Teaching one robot: a person's clicks, the labels that follow, and the questions that remain."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.carry import Mark, Tracks, carried
from aerial_gnss_ros.teaching.clicks import Click
from aerial_gnss_ros.teaching.project import Project, Statement
from aerial_gnss_ros.teaching.proposals import strength
from aerial_gnss_ros.teaching.recording import Recording
from aerial_gnss_ros.teaching.tracks import Sight, Track, clipped, outside, overlap
from aerial_gnss_ros.text.sentences import counted

Array = NDArray[np.float64]
REACH_PX = 12.0
"""Distance from a click within which an object counts as clicked, px."""
SIZES_PX = (16.0, 32.0, 64.0, 128.0, 256.0)
"""Sizes tried for an object that is no proposal."""
CLEAR = 51.0
"""Least squared distance from the water of an object that is no proposal: where no pixel of
Gaussian water is, as for the detector `anomaly`."""
SAME = 0.8
"""Overlap above which two robots' boxes in one frame are one object."""


@dataclass(frozen=True)
class Question:
    """A label to confirm, correct or refuse.

    Attributes:
        robot: its name.
        frame: index, the first of the unsure ones in a row.
        box: (4,) the best guess, px.
        until: the last of the unsure frames in a row.
    """

    robot: str
    frame: int
    box: Array
    until: int


class Session:
    """A project while it is worked on.

    Args:
        folder: of the project, with extracted frames.

    Attributes:
        recording: its frames.
        project: its marks.
        tracks: what the marks say about all frames.
    """

    def __init__(self, folder: Path) -> None:
        self.recording = Recording(folder)
        self.project = Project(folder, self.recording.name, len(self.recording))
        self.tracks: Tracks = {}
        self.carry()

    def carry(self) -> None:
        """Carry all marks to all frames."""
        marks = self.project.marks
        self.tracks = carried(self.recording, marks) if marks else {}

    def statement(self, click: Click) -> Statement:
        """Return what a click says.

        Raises:
            InputError: it is outside the image, on nothing, or on another robot.
        """
        box = None
        if click.box is not None:
            low, size = click.box[:2], click.box[2:]
            box = np.concatenate([low + size / 2.0, size])
            if outside(box, self.recording.size) > 0.99:
                raise InputError(_beyond("the box", click.frame, click.box[:2], self.recording))
            box = clipped(box, self.recording.size)
        elif click.point is not None:
            if not ((click.point >= 0.0) & (click.point <= self.recording.size)).all():
                raise InputError(_beyond("the click", click.frame, click.point, self.recording))
            known = self.tracks.get(click.robot, {}).get(click.frame)
            box = self.box_at(click.frame, click.point, None if known is None else known.box[2:])
            if box is None:
                raise InputError(
                    f"frame {click.frame}: nothing stands out from the water at "
                    f"{click.point[0]:g}, {click.point[1]:g} px; draw a box round the robot."
                )
        if box is not None:
            self._refuse_other(click, box)
        return Statement(Mark(click.robot, click.frame, box), click.class_name)

    def add(self, clicks: Sequence[Click]) -> int:
        """Keep clicks and carry them; return how many are new.

        Raises:
            InputError: one is refused; those before it are kept.
        """
        new = 0
        try:
            for click in clicks:
                new += self.project.add(self.statement(click))
        except InputError as error:
            if not new:
                raise
            raise InputError(
                f"{error} {counted(new, 'mark')} before it "
                f"{'is' if new == 1 else 'are'} kept; --undo takes the last one back."
            ) from error
        finally:
            if new:
                self.carry()
        return new

    def twins(self) -> list[tuple[str, str, int]]:
        """Return pairs of robots that have the same box, and in how many frames."""
        found = []
        for one, other in itertools.combinations(self.tracks, 2):
            both = self.tracks[one].keys() & self.tracks[other].keys()
            pairs = [(self.tracks[one][frame], self.tracks[other][frame]) for frame in both]
            count = sum(
                Sight.OUT not in (a.sight, b.sight) and overlap(a.box, b.box) > SAME
                for a, b in pairs
            )
            if count:
                found.append((one, other, count))
        return found

    def undo(self) -> Statement | None:
        """Take back the last mark."""
        taken = self.project.undo()
        if taken is not None:
            self.carry()
        return taken

    def box_at(self, frame: int, point: Array, size: Array | None = None) -> Array | None:
        """Return the box (4,) of the object at a point of a frame; None if nothing stands out.

        Args:
            frame: index.
            point: (2,) px.
            size: (2,) width and height that the robot has there by its other marks, px; None: it
                has none. An object of another size is glint, foam or two robots that touch.
        """
        found = self.recording.proposals(frame).boxes
        near = (np.abs(found[:, :2] - point) <= found[:, 2:] / 2.0 + REACH_PX).all(axis=1)
        tries = list(found[near][np.argsort(np.linalg.norm(found[near, :2] - point, axis=1))])
        known = len(tries)
        tries += [np.array([*point, side, side]) for side in SIZES_PX]
        for i, rough in enumerate(tries):
            outline = self.recording.outline(frame, rough)
            if outline is None:
                continue
            if i >= known and strength(self.recording.image(frame), outline) < CLEAR:
                continue  # a ripple
            if size is not None and not 0.5 < outline[2:].max() / size.max() < 2.0:
                continue
            touched = (np.abs(outline[:2] - point) <= outline[2:] / 2.0 + REACH_PX).all()
            if touched and (outline[2:] < 1.9 * np.maximum(rough[2:], 8.0)).all():
                return outline
        if size is None or not near.any():
            return None
        return np.concatenate([point, size])

    def questions(self) -> list[Question]:
        """Return all labels that need an answer, in the order of frames."""
        asked = []
        for robot, of_frame in self.tracks.items():
            begin: int | None = None
            for frame in range(len(self.recording) + 1):
                track = of_frame.get(frame)
                doubt = track is not None and track.sight in (Sight.UNSURE, Sight.LOST)
                if doubt and begin is None:
                    begin = frame
                elif not doubt and begin is not None:
                    box = clipped(of_frame[begin].box, self.recording.size)
                    asked.append(Question(robot, begin, box, frame - 1))
                    begin = None
        return sorted(asked, key=lambda one: (one.frame, one.robot))

    def labels(self, frame: int) -> list[tuple[str, Track]] | None:
        """Return the robots' labels in a frame; None if one of them is unknown or unsure."""
        found = []
        for robot, of_frame in self.tracks.items():
            track = of_frame.get(frame)
            if track is None or track.sight in (Sight.UNSURE, Sight.LOST):
                return None
            if track.sight is Sight.SURE:
                found.append((robot, track))
        return found

    def _refuse_other(self, click: Click, box: Array) -> None:
        for mark in self.project.marks:
            if (
                mark.robot != click.robot
                and mark.frame == click.frame
                and mark.box is not None
                and overlap(mark.box, box) > SAME
            ):
                raise InputError(
                    f"frame {click.frame}: {click.robot} would have the same box as {mark.robot}; "
                    "draw a box round each of two robots that touch."
                )


def _beyond(what: str, frame: int, point: Array, recording: Recording) -> str:
    width, height = recording.size
    return (
        f"frame {frame}: {what} at {point[0]:g}, {point[1]:g} px is outside the image, which has "
        f"{width}x{height} px."
    )
