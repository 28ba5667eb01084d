# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the server and the page of `aerial-gnss teach` say to each other.

The page sends `{"do": ...}`: `frame` (shows one), `mark` (a click, a box or `absent`, as in a file
of clicks), `answer` (`yes` or not, to the guess in a frame; `until`: to all up to that frame),
`undo`, `write` (the data set). It receives `hello`, `state` (robots, questions, one letter a frame
for what is known), `frame` (boxes), `busy`, `no` (why something was refused), and `written`.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import AerialGnssError, InputError
from aerial_gnss_ros.teaching.clicks import Click, click_of
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.tracks import Sight, clipped
from aerial_gnss_ros.view.server import Answer, Route, Socket, begin, result_of

PAGE = "teach.html"
PORT = 8061
LETTERS = {Sight.SURE: "s", Sight.UNSURE: "u", Sight.LOST: "l", Sight.OUT: "o"}
UNKNOWN = "-"

Write = Callable[[Session], str]
"""Writes the data set and returns what to say of it."""


class Teacher:
    """One session for all browsers; its work runs in one thread, in order.

    Args:
        session: the marks.
        class_name: of robots without one.
        write: writes the data set.
    """

    def __init__(self, session: Session, class_name: str, write: Write) -> None:
        self.session, self.class_name, self.write = session, class_name, write
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="teach")
        self.browsers: set[TeachSocket] = set()

    def submit(self, task: Callable[[], dict[str, Any] | None]) -> Future[dict[str, Any] | None]:
        """Do a task after those before it."""
        return self._pool.submit(task)

    def hello(self) -> dict[str, Any]:
        """Return what the page needs once."""
        recording = self.session.recording
        return {
            "kind": "hello",
            "name": recording.name,
            "frames": len(recording),
            "size": list(recording.size),
            "class": self.class_name,
            "posed": recording.posed,
        }

    def state(self) -> dict[str, Any]:
        """Return what is known of all frames."""
        session, count = self.session, len(self.session.recording)
        robots = []
        for robot, class_name in session.project.classes.items():
            of = session.tracks.get(robot, {})
            sights = [
                LETTERS[of[frame].sight] if frame in of else UNKNOWN for frame in range(count)
            ]
            marked = [mark.frame for mark in session.project.marks if mark.robot == robot]
            robots.append(
                {"name": robot, "class": class_name, "sights": "".join(sights), "marked": marked}
            )
        questions = [
            {"robot": one.robot, "frame": one.frame, "until": one.until}
            for one in session.questions()
        ]
        marks = len(session.project.marks)
        return {"kind": "state", "robots": robots, "questions": questions, "marks": marks}

    def frame(self, number: int) -> dict[str, Any]:
        """Return the boxes of a frame."""
        boxes = []
        for robot, of_frame in self.session.tracks.items():
            track = of_frame.get(number)
            if track is None or track.sight is Sight.OUT:
                continue
            box = clipped(track.box, self.session.recording.size)
            corner = [*(box[:2] - box[2:] / 2.0), *box[2:]]
            rounded = [round(float(value), 1) for value in corner]
            boxes.append({"robot": robot, "sight": track.sight.value, "box": rounded})
        return {"kind": "frame", "frame": number, "boxes": boxes}

    def do(self, fields: dict[str, Any]) -> dict[str, Any] | None:
        """Do what a page asks; return what only that page is told.

        Raises:
            AerialGnssError: it is refused.
        """
        match fields.get("do"):
            case "mark":
                self.session.add([self._click(fields)])
            case "answer":
                self.session.add(self._answers(fields))
            case "undo":
                if self.session.undo() is None:
                    raise InputError("there is no mark to take back.")
            case "write":
                return {"kind": "written", "words": self.write(self.session)}
        return None

    def _click(self, fields: dict[str, Any]) -> Click:
        mark = {key: value for key, value in fields.items() if key != "do"}
        return click_of(mark, self.session.recording.names, self.class_name, "this mark")

    def _answers(self, fields: dict[str, Any]) -> list[Click]:
        robot = str(fields.get("robot"))
        class_name = self.session.project.classes.get(robot, "")
        known = self.session.tracks.get(robot, {})
        first = int(fields.get("frame", -1))
        clicks = []
        for frame in range(first, int(fields.get("until", first)) + 1):
            track = known.get(frame)
            if track is None:
                raise InputError(f"frame {frame} has no box of {robot} to answer about.")
            box = clipped(track.box, self.session.recording.size)
            corner = box.copy()
            corner[:2] -= box[2:] / 2.0
            clicks.append(
                Click(robot, class_name, frame, box=corner if fields.get("yes") else None)
            )
        return clicks


class TeachSocket(Socket):
    """A browser that teaches."""

    def initialize(self, teacher: Teacher) -> None:
        """Tornado's constructor."""
        self._teacher = teacher
        self._frame = 0
        self._working: list[Any] = []

    def opened(self) -> None:
        """Send what the page needs."""
        self._teacher.browsers.add(self)
        self.send(self._teacher.hello())
        self._tell()

    def received(self, fields: dict[str, Any]) -> None:
        """Show a frame, or do some work in the background."""
        if fields.get("do") == "frame":
            number = fields.get("frame")
            if isinstance(number, int) and 0 <= number < len(self._teacher.session.recording):
                self._frame = number
                self.send(self._teacher.frame(number))
            return
        self.send({"kind": "busy"})
        self._working = [one for one in self._working if not one.done()]
        self._working.append(begin(self._do(fields)))

    def closed(self) -> None:
        """Forget the browser."""
        self._teacher.browsers.discard(self)

    async def _do(self, fields: dict[str, Any]) -> None:
        try:
            answer = await result_of(self._teacher.submit(lambda: self._teacher.do(fields)))
            if answer is not None:
                self.send(answer)
        except (AerialGnssError, ValueError, TypeError) as error:
            self.send({"kind": "no", "words": str(error)})
        for browser in set(self._teacher.browsers):
            browser._tell()  # noqa: SLF001 - of the same class

    def _tell(self) -> None:
        self.send(self._teacher.state())
        self.send(self._teacher.frame(self._frame))


class FrameAnswer(Answer):
    """The image of a frame."""

    def initialize(self, files: list[Path]) -> None:
        """Tornado's constructor."""
        self._files = files

    def get(self, number: str) -> None:
        """Answer with a JPEG."""
        index = int(number)
        if index >= len(self._files):
            self.send_error(404)
            return
        self.set_header("Content-Type", "image/jpeg")
        self.set_header("Cache-Control", "private, max-age=3600")
        self.finish(self._files[index].read_bytes())


def routes(teacher: Teacher) -> list[Route]:
    """Return the routes of the page."""
    files = teacher.session.recording.files
    return [
        (r"/teach", TeachSocket, {"teacher": teacher}),
        (r"/frames/(\d{1,6})", FrameAnswer, {"files": files}),
    ]
